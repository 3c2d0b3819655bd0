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

"""Parameters of the wind node."""
from flag_sim.animation.wind_settings import WindSettings
from flag_sim.declarations.pacing import PACE, RESEND_AFTER, WAIT_FOR
from flag_sim.parameters.declaration import Declaration
from flag_sim.parameters.declared import Group

SETTINGS = Group(WindSettings())

WIND = (
    Declaration('rate', 30.0, 'frames per simulated second', 'Hz', 0.01, 1000.0),
    Declaration('frames', 0, 'length of the shot; 0: without end', 'frames', 0, 2**31 - 1),
    PACE,
    Declaration('window', 3, 'lockstep: frames from the oldest unfinished one on', 'frames', 1, 8),
    WAIT_FOR,
    RESEND_AFTER,
    Declaration('paused', False, 'no frames while true'),
    Declaration('publish_clock', False, 'publish the simulation time on /clock', fixed=True),
    Declaration(
        'stamp.clock', 'simulation', 'simulation: stamps count from stamp.start; wall: from the '
        'time of day, to match sensors', choices=('simulation', 'wall'), fixed=True),
    Declaration('stamp.start', 0.0, 'simulation: stamp of the first frame of every take', 's',
                0.0, 2e9, fixed=True),
    *SETTINGS,
    Declaration('autokey', False, 'what is set on any node becomes a key at the current time'),
    Declaration(
        'save_to', '',
        'params file that holds the shot, keys and all nodes, after every change of it; while '
        'running: a .yaml file in the folder that it had at the start, or else the working one'),
    Declaration('loop', False, 'after the last key or event, begin with the first again'),
    Declaration('snap_keys', False, 'keys and events count at the frame nearest to their time'),
    Declaration('events.names', [], 'events to announce on keyframe', item=str),
    Declaration('events.times', [], 'their times', 's', 0.0, 1e9),
    Declaration(
        'tracks', [], 'keyed parameters, as node.parameter; each has keys.<track>.times, '
        '.values, .laws and .turns', item=str),
)
