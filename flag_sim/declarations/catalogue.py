# Copyright 2026 The flag_sim Authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Every dial of every node, in the order in which people meet them."""
from dataclasses import replace
from math import pi

from flag_sim.parameters.parameter import Dial

# Angles are given within one turn to either side, so that a track may pass through half a turn.
TURN = 2.0 * pi

SCENE = (
    Dial('pole.height', 9.0, 'height of the pole without its tip', 'm', 0.1, 1000.0),
    Dial('pole.diameter', 0.1, 'diameter of the pole; radius of its tip', 'm', 0.001, 10.0),
    Dial('flag.length', 0.0,
         'hoist to fly, 0.001 at least; 0: one and a half times the width', 'm', 0.0, 100.0),
    Dial('flag.width', 0.0,
         'upper to lower edge, 0.001 at least; 0: a sixth of the pole', 'm', 0.0, 100.0),
    Dial('platform.side', 1.0, 'side of the platform, a square', 'm', 0.01, 100.0),
    Dial('platform.height', 0.3, 'height of the platform', 'm', 0.01, 100.0),
)

# How frames are delivered, by the wind and by the player.
PACE = Dial('pace', 'realtime',
            'realtime: by the clock; lockstep: as fast as every frame is done',
            choices=('realtime', 'lockstep'))
WAIT_FOR = Dial('wait_for', ['renderer'],
                'nodes whose frame_done makes a frame done: renderer, recorder, your own',
                item=str)
RESEND_AFTER = Dial('resend_after', 1.0, 'lockstep: an unfinished frame is sent again after', 's',
                    0.05, 60.0)

WIND = (
    Dial('rate', 30.0, 'frames per simulated second', 'Hz', 0.01, 1000.0),
    Dial('frames', 0, 'length of the shot; 0: without end', 'frames', 0, 2**31 - 1),
    PACE,
    Dial('window', 3, 'lockstep: frames from the oldest unfinished one on', 'frames', 1, 8),
    WAIT_FOR,
    RESEND_AFTER,
    Dial('paused', False, 'no frames while true'),
    Dial('publish_clock', False, 'publish the simulation time on /clock', fixed=True),
    Dial('stamp.clock', 'simulation',
         'simulation: stamps count from stamp.start; wall: from the time of day, to match sensors',
         choices=('simulation', 'wall'), fixed=True),
    Dial('stamp.start', 0.0, 'simulation: stamp of the first frame of every take', 's', 0.0, 2e9,
         fixed=True),
    Dial('speed', 6.0, 'wind speed', 'm/s', 0.0, 200.0),
    Dial('azimuth', 0.35, 'where the wind blows to, from +x towards +y', 'rad', -TURN, TURN),
    Dial('elevation', 0.0, 'where the wind blows to, above the ground', 'rad', -pi / 2, pi / 2),
    Dial('gust.intensity', 0.0, 'turbulence as a part of the speed (Dryden); 0: steady wind', '',
         0.0, 2.0),
    Dial('gust.length', 5.0, 'size of the eddies', 'm', 0.01, 10000.0),
    Dial('gust.seed', 0, 'another seed, another series', '', 0, 2**31 - 1),
    Dial('autokey', False, 'what is set on any node becomes a key at the current time'),
    Dial('save_to', '',
         'params file that holds the shot, keys and all nodes, after every change of it'),
    Dial('loop', False, 'after the last key or event, begin with the first again'),
    Dial('snap_keys', False, 'keys and events count at the frame nearest to their time'),
    Dial('events.names', [], 'events to announce on keyframe', item=str),
    Dial('events.times', [], 'their times', 's', 0.0, 1e9),
    Dial('tracks', [], 'keyed parameters, as node.parameter; each has keys.<track>.times, '
         '.values, .laws and .turns', item=str),
)

PHYSICS = (
    Dial('grid.columns', 31, 'nodes from hoist to fly', 'nodes', 2, 1001),
    Dial('grid.rows', 21, 'nodes from upper to lower edge', 'nodes', 2, 1001),
    Dial('area_density', 0.2, 'mass of the cloth per area', 'kg/m2', 1e-6, 1e6),
    Dial('stiffness', 1000.0, 'stiffness along the threads', 'N/m', 0.0, 1e9),
    Dial('shear_stiffness', 500.0, 'stiffness against shear', 'N/m', 0.0, 1e9),
    Dial('bend_stiffness', 1e-3, 'stiffness against bending', 'N m', 0.0, 1e6),
    Dial('damping', 0.05, 'damping ratio of every spring', '', 0.0, 1e6),
    Dial('node_damping', 0.0, 'rate at which nodes lose speed', '1/s', 0.0, 1e6),
    Dial('gravity', 9.81, 'downward acceleration', 'm/s2', 0.0, 1000.0),
    Dial('air.density', 1.2, 'density of the air', 'kg/m3', 0.0, 1000.0),
    Dial('air.drag_coefficient', 1.17, 'drag of the faces across the wind', '', 0.0, 100.0),
    Dial('air.law', 'quadratic', 'how the force on a face grows with the wind across it',
         choices=('quadratic', 'linear', 'seed')),
    Dial('solver', 'symplectic', 'method of the steps',
         choices=('symplectic', 'verlet', 'rk4', 'xpbd', 'implicit', 'euler', 'seed')),
    Dial('substeps', 0, 'steps per frame at least; 0: as many as stability asks', '', 0, 100000),
    Dial('step_safety', 0.9, 'step as a share of the largest stable one', '', 0.01, 1.0),
    Dial('substeps_limit', 1000, 'steps per frame at most; beyond, the cloth is made softer',
         '', 1, 100000),
    Dial('stretch_limit', 1.0,
         'greatest strain from the hoist to any node; 1: the cloth may double its length', '',
         0.0, 1e6),
    Dial('precision', 'float64', 'of the numbers inside; float32 is twice as fast, to 0.1 mm',
         choices=('float64', 'float32')),
    Dial('pole_collision', True, 'keep the cloth out of the pole'),
    Dial('start_noise', 1e-4, 'the cloth starts flat but for a random bump of at most this; 0: '
         'exactly flat, and in calm air or a wind along it it stays so for ever', 'm', 0.0, 0.1),
    Dial('start_seed', 0, 'another seed, another bump', '', 0, 2**31 - 1),
    Dial('preroll', 0.0,
         "time that a cloth which begins anew has moved in its first frame's wind, unseen", 's',
         0.0, 60.0),
    Dial('max_gap', 1.0, 'longest time between frames that is simulated', 's', 0.0, 3600.0),
    Dial('threads', 1, 'threads that step; 0: as many as the first frames show to be worth it',
         '', 0, 64, fixed=True),
)


def _material(thing, color):
    """Return the dials of what a thing is made of."""
    return (
        Dial(f'{thing}.color', color, f'colour of the {thing}: red, green, blue', '',
             0.0, 255.0, length=3),
        Dial(f'{thing}.diffuse', 1.0, f'share of the sun that the {thing} returns', '', 0.0, 10.0),
        Dial(f'{thing}.specular', 0.0, f'strength of the sun mirrored by the {thing}; 0: off', '',
             0.0, 10.0),
        Dial(f'{thing}.shininess', 30.0, 'exponent of the mirrored sun: more is smaller', '',
             1.0, 1000.0),
    )


RENDERER = (
    Dial('width', 640, 'image width', 'pixels', 1, 7680),
    Dial('height', 480, 'image height', 'pixels', 1, 4320),
    Dial('camera.projection', 'perspective', 'how space is mapped to the image',
         choices=('perspective', 'orthographic')),
    Dial('camera.vertical_fov', 0.56, 'perspective: angle that the height sees', 'rad',
         0.001, 3.1),
    Dial('camera.scale', 3.0, 'orthographic: height that the image shows', 'm', 0.001, 10000.0),
    Dial('camera.target', [1.1, 0.0, 7.85], 'point in the middle of the image', 'm', -1e4, 1e4,
         length=3),
    Dial('camera.distance', 5.5, 'from the target', 'm', 0.0, 10000.0),
    Dial('camera.azimuth', -pi / 2, 'of the camera seen from the target', 'rad',
         -TURN, TURN),
    Dial('camera.elevation', -0.1, 'of the camera seen from the target', 'rad', -pi / 2, pi / 2),
    Dial('camera.roll', 0.0, 'turn about the line of sight', 'rad', -TURN, TURN),
    Dial('camera.near', 0.05, 'nothing nearer is drawn', 'm', 0.001, 1000.0),
    Dial('samples', 1, '1: at pixel centres alone; 4, 8 or 16 more where edges are',
         choices=(1, 4, 8, 16)),
    Dial('shading', 'gouraud', 'light at vertices and between, or one per triangle',
         choices=('gouraud', 'flat')),
    Dial('interpolation', 'screen', 'of light between vertices: linear on the screen or in space',
         choices=('screen', 'perspective')),
    Dial('hidden_surface', 'zbuffer', 'nearest of every pixel, or triangles from far to near',
         choices=('zbuffer', 'painter')),
    Dial('outline', False, 'draw the edges of the triangles, darker'),
    Dial('sun.azimuth', -1.0, 'where the sun stands, from +x towards +y', 'rad', -TURN, TURN),
    Dial('sun.elevation', 0.7, 'where the sun stands, above the horizon', 'rad', -pi / 2, pi / 2),
    Dial('sun.intensity', 0.8, 'light of the sun', '', 0.0, 10.0),
    Dial('ambient', 0.35, 'light from everywhere', '', 0.0, 10.0),
    *_material('flag', [205.0, 35.0, 40.0]),
    Dial('flag.transmission', 0.3, 'share of the sun that shines through the flag; 0: off', '',
         0.0, 1.0),
    *_material('pole', [200.0, 200.0, 205.0]),
    *_material('platform', [150.0, 145.0, 135.0]),
    Dial('pole.visible', True, 'draw the pole'),
    Dial('platform.visible', True, 'draw the platform'),
    Dial('background', [180.0, 240.0, 240.0], 'colour where nothing is: red, green, blue', '',
         0.0, 255.0, length=3),
    Dial('threads', 1, 'threads that draw; 0: as many as the first frames show to be worth it',
         '', 0, 64, fixed=True),
)

RECORDER = (
    Dial('path', '', 'folder of the new bag; empty: rosbag2_ and the date', fixed=True),
    Dial('topics',
         ['camera/image_raw', 'camera/camera_info', 'vertices', 'parameters', 'keyframe'],
         'topics to record', item=str, fixed=True),
    Dial('frames', 0, 'end after so many frames; 0: when told to', 'frames', 0, 2**31 - 1,
         fixed=True),
    Dial('storage', 'mcap', 'file format', choices=('mcap', 'sqlite3'), fixed=True),
    Dial('compression', 'none', 'compression of the file', choices=('none', 'zstd'), fixed=True),
)

PLAYER = (
    Dial('path', '', 'the bag that is played', fixed=True),
    Dial('topics', [], 'topics to play; none: parameters, or else vertices', item=str,
         fixed=True),
    replace(PACE, fixed=True),
    Dial('rate', 1.0, 'realtime: how much faster than it was', '', 0.01, 1000.0, fixed=True),
    replace(WAIT_FOR, fixed=True),
    replace(RESEND_AFTER, fixed=True),
)

NODES = {
    'wind': WIND,
    'physics': SCENE + PHYSICS,
    'renderer': SCENE + RENDERER,
    'recorder': RECORDER,
    'player': PLAYER,
}
"""Every dial of every node, by the node's name."""
