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

"""Every parameter of every node, in the order in which people meet them."""
from dataclasses import replace
from math import pi

from flag_sim.parameters.declaration import Declaration

# Angles are given within one turn to either side, so that a track may pass through half a turn.
TURN = 2.0 * pi

SCENE = (
    Declaration('pole.height', 9.0, 'height of the pole without its tip', 'm', 0.1, 1000.0),
    Declaration('pole.diameter', 0.1, 'diameter of the pole; radius of its tip', 'm', 0.001, 10.0),
    Declaration('flag.length', 0.0,
         'hoist to fly, 0.001 at least; 0: one and a half times the width', 'm', 0.0, 100.0),
    Declaration('flag.width', 0.0,
         'upper to lower edge, 0.001 at least; 0: a sixth of the pole', 'm', 0.0, 100.0),
    Declaration('platform.side', 1.0, 'side of the platform, a square', 'm', 0.01, 100.0),
    Declaration('platform.height', 0.3, 'height of the platform', 'm', 0.01, 100.0),
)

# How frames are delivered, by the wind and by the player.
PACE = Declaration('pace', 'realtime',
            'realtime: by the clock; lockstep: as fast as every frame is done',
            choices=('realtime', 'lockstep'))
WAIT_FOR = Declaration('wait_for', ['renderer'],
                'nodes whose frame_done makes a frame done: renderer, recorder, your own',
                item=str)
RESEND_AFTER = Declaration('resend_after', 1.0,
                           'lockstep: an unfinished frame is sent again after', 's',
                    0.05, 60.0)

WIND = (
    Declaration('rate', 30.0, 'frames per simulated second', 'Hz', 0.01, 1000.0),
    Declaration('frames', 0, 'length of the shot; 0: without end', 'frames', 0, 2**31 - 1),
    PACE,
    Declaration('window', 3, 'lockstep: frames from the oldest unfinished one on', 'frames', 1, 8),
    WAIT_FOR,
    RESEND_AFTER,
    Declaration('paused', False, 'no frames while true'),
    Declaration('publish_clock', False, 'publish the simulation time on /clock', fixed=True),
    Declaration('stamp.clock', 'simulation',
         'simulation: stamps count from stamp.start; wall: from the time of day, to match sensors',
         choices=('simulation', 'wall'), fixed=True),
    Declaration('stamp.start', 0.0, 'simulation: stamp of the first frame of every take', 's', 0.0,
                2e9,
         fixed=True),
    Declaration('speed', 6.0, 'wind speed', 'm/s', 0.0, 200.0),
    Declaration('azimuth', 0.35, 'where the wind blows to, from +x towards +y', 'rad', -TURN,
                TURN),
    Declaration('elevation', 0.0, 'where the wind blows to, above the ground', 'rad', -pi / 2,
                pi / 2),
    Declaration('gust.intensity', 0.0,
                'turbulence as a part of the speed (Dryden); 0: steady wind', '',
         0.0, 2.0),
    Declaration('gust.length', 5.0, 'size of the eddies', 'm', 0.01, 10000.0),
    Declaration('gust.seed', 0, 'another seed, another series', '', 0, 2**31 - 1),
    Declaration('autokey', False, 'what is set on any node becomes a key at the current time'),
    Declaration('save_to', '',
         'params file that holds the shot, keys and all nodes, after every change of it'),
    Declaration('loop', False, 'after the last key or event, begin with the first again'),
    Declaration('snap_keys', False, 'keys and events count at the frame nearest to their time'),
    Declaration('events.names', [], 'events to announce on keyframe', item=str),
    Declaration('events.times', [], 'their times', 's', 0.0, 1e9),
    Declaration('tracks', [], 'keyed parameters, as node.parameter; each has keys.<track>.times, '
         '.values, .laws and .turns', item=str),
)

PHYSICS = (
    Declaration('grid.columns', 31, 'nodes from hoist to fly', 'nodes', 2, 1001),
    Declaration('grid.rows', 21, 'nodes from upper to lower edge', 'nodes', 2, 1001),
    Declaration('area_density', 0.2, 'mass of the cloth per area', 'kg/m2', 1e-6, 1e6),
    Declaration('stiffness', 1000.0, 'stiffness along the threads', 'N/m', 0.0, 1e9),
    Declaration('shear_stiffness', 500.0, 'stiffness against shear', 'N/m', 0.0, 1e9),
    Declaration('bend_stiffness', 1e-3, 'stiffness against bending', 'N m', 0.0, 1e6),
    Declaration('damping', 0.05, 'damping ratio of every spring', '', 0.0, 1e6),
    Declaration('node_damping', 0.0, 'rate at which nodes lose speed', '1/s', 0.0, 1e6),
    Declaration('gravity', 9.81, 'downward acceleration', 'm/s2', 0.0, 1000.0),
    Declaration('air.density', 1.2, 'density of the air', 'kg/m3', 0.0, 1000.0),
    Declaration('air.drag_coefficient', 1.17, 'drag of the faces across the wind', '', 0.0, 100.0),
    Declaration('air.law', 'quadratic', 'how the force on a face grows with the wind across it',
         choices=('quadratic', 'linear', 'seed')),
    Declaration('solver', 'symplectic', 'method of the steps',
         choices=('symplectic', 'verlet', 'rk4', 'xpbd', 'implicit', 'euler', 'seed')),
    Declaration('substeps', 0, 'steps per frame at least; 0: as many as stability asks', '', 0,
                100000),
    Declaration('step_safety', 0.9, 'step as a share of the largest stable one', '', 0.01, 1.0),
    Declaration('substeps_limit', 1000,
                'steps per frame at most; beyond, the cloth is made softer',
         '', 1, 100000),
    Declaration('stretch_limit', 1.0,
         'greatest strain from the hoist to any node; 1: the cloth may double its length', '',
         0.0, 1e6),
    Declaration('precision', 'float64',
                'of the numbers inside; float32 is twice as fast, to 0.1 mm',
         choices=('float64', 'float32')),
    Declaration('pole_collision', True, 'keep the cloth out of the pole'),
    Declaration('start_noise', 1e-4,
                'the cloth starts flat but for a random bump of at most this; 0: '
         'exactly flat, and in calm air or a wind along it it stays so for ever', 'm', 0.0, 0.1),
    Declaration('start_seed', 0, 'another seed, another bump', '', 0, 2**31 - 1),
    Declaration('preroll', 0.0,
         "time that a cloth which begins anew has moved in its first frame's wind, unseen", 's',
         0.0, 60.0),
    Declaration('max_gap', 1.0, 'longest time between frames that is simulated', 's', 0.0, 3600.0),
    Declaration('threads', 1,
                'threads that step; 0: as many as the first frames show to be worth it',
         '', 0, 64, fixed=True),
)


def _material(thing, color):
    """Return the parameters of what a thing is made of."""
    return (
        Declaration(f'{thing}.color', color, f'colour of the {thing}: red, green, blue', '',
             0.0, 255.0, length=3),
        Declaration(f'{thing}.diffuse', 1.0, f'share of the sun that the {thing} returns', '', 0.0,
                    10.0),
        Declaration(f'{thing}.specular', 0.0,
                    f'strength of the sun mirrored by the {thing}; 0: off', '',
             0.0, 10.0),
        Declaration(f'{thing}.shininess', 30.0, 'exponent of the mirrored sun: more is smaller',
                    '',
             1.0, 1000.0),
    )


RENDERER = (
    Declaration('width', 640, 'image width', 'pixels', 1, 7680),
    Declaration('height', 480, 'image height', 'pixels', 1, 4320),
    Declaration('camera.projection', 'perspective', 'how space is mapped to the image',
         choices=('perspective', 'orthographic')),
    Declaration('camera.vertical_fov', 0.56, 'perspective: angle that the height sees', 'rad',
         0.001, 3.1),
    Declaration('camera.scale', 3.0, 'orthographic: height that the image shows', 'm', 0.001,
                10000.0),
    Declaration('camera.target', [1.1, 0.0, 7.85], 'point in the middle of the image', 'm', -1e4,
                1e4,
         length=3),
    Declaration('camera.distance', 5.5, 'from the target', 'm', 0.0, 10000.0),
    Declaration('camera.azimuth', -pi / 2, 'of the camera seen from the target', 'rad',
         -TURN, TURN),
    Declaration('camera.elevation', -0.1, 'of the camera seen from the target', 'rad', -pi / 2,
                pi / 2),
    Declaration('camera.roll', 0.0, 'turn about the line of sight', 'rad', -TURN, TURN),
    Declaration('camera.near', 0.05, 'nothing nearer is drawn', 'm', 0.001, 1000.0),
    Declaration('samples', 1, '1: at pixel centres alone; 4, 8 or 16 more where edges are',
         choices=(1, 4, 8, 16)),
    Declaration('shading', 'gouraud', 'light at vertices and between, or one per triangle',
         choices=('gouraud', 'flat')),
    Declaration('interpolation', 'screen',
                'of light between vertices: linear on the screen or in space',
         choices=('screen', 'perspective')),
    Declaration('hidden_surface', 'zbuffer',
                'nearest of every pixel, or triangles from far to near',
         choices=('zbuffer', 'painter')),
    Declaration('outline', False, 'draw the edges of the triangles, darker'),
    Declaration('sun.azimuth', -1.0, 'where the sun stands, from +x towards +y', 'rad', -TURN,
                TURN),
    Declaration('sun.elevation', 0.7, 'where the sun stands, above the horizon', 'rad', -pi / 2,
                pi / 2),
    Declaration('sun.intensity', 0.8, 'light of the sun', '', 0.0, 10.0),
    Declaration('ambient', 0.35, 'light from everywhere', '', 0.0, 10.0),
    *_material('flag', [205.0, 35.0, 40.0]),
    Declaration('flag.transmission', 0.3, 'share of the sun that shines through the flag; 0: off',
                '',
         0.0, 1.0),
    *_material('pole', [200.0, 200.0, 205.0]),
    *_material('platform', [150.0, 145.0, 135.0]),
    Declaration('pole.visible', True, 'draw the pole'),
    Declaration('platform.visible', True, 'draw the platform'),
    Declaration('background', [180.0, 240.0, 240.0], 'colour where nothing is: red, green, blue',
                '',
         0.0, 255.0, length=3),
    Declaration('threads', 1,
                'threads that draw; 0: as many as the first frames show to be worth it',
         '', 0, 64, fixed=True),
)

RECORDER = (
    Declaration('path', '', 'folder of the new bag; empty: rosbag2_ and the date', fixed=True),
    Declaration('topics',
         ['camera/image_raw', 'camera/camera_info', 'vertices', 'parameters', 'keyframe'],
         'topics to record', item=str, fixed=True),
    Declaration('frames', 0, 'end after so many frames; 0: when told to', 'frames', 0, 2**31 - 1,
         fixed=True),
    Declaration('storage', 'mcap', 'file format', choices=('mcap', 'sqlite3'), fixed=True),
    Declaration('compression', 'none', 'compression of the file', choices=('none', 'zstd'),
                fixed=True),
)

PLAYER = (
    Declaration('path', '', 'the bag that is played', fixed=True),
    Declaration('topics', [], 'topics to play; none: parameters, or else vertices', item=str,
         fixed=True),
    replace(PACE, fixed=True),
    Declaration('rate', 1.0, 'realtime: how much faster than it was', '', 0.01, 1000.0,
                fixed=True),
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
"""Every parameter of every node, by the node's name."""


def named(node: str) -> dict[str, Declaration]:
    """Return {parameter name: declaration} of a node."""
    return {declaration.name: declaration for declaration in NODES[node]}


def defaults(node: str) -> dict[str, object]:
    """Return {parameter name: default} of a node."""
    return {declaration.name: declaration.default for declaration in NODES[node]}
