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

"""
*Rests*: whether a flag comes to rest once the wind stops, and hangs as statics says.

A method that keeps on moving in calm air is wrong for ever, however near it is after a tenth of a
second. And a sheet that was softened hangs longer than its stiffness allows.

Air alone slows a flag ever more slowly, as 1 / time: a hand stills it first, so that what is left
is what the method itself keeps up. It does so until the flag is still, however long that takes:
folds may creep for most of a minute before they give way, also of an exact flag.
"""
import dataclasses
import math
from typing import NamedTuple

from flag_sim.cloth import Cloth, Diverged
from flag_sim.study.measures.reference import Shot
from flag_sim.study.measures.summary import rms
import numpy as np

BLOWN = 2.0     # in the shot's wind, before it stops [s]
STILLED = 60.0  # then in calm air, with STILLING, at most [s]
USUAL = 20.0    # and usually, until it is still [s]
STILL = 0.5     # speed (RMS) of a flag that is still, all along WATCHED [mm/s]
STILLING = 1.0  # node damping, such that it neither swings on nor creeps [1/s]
FREE = 6.0      # then in calm air as it is [s]
WATCHED = 1.0   # the last of either, in which the speed counts [s]
SLOW = 5.0      # greatest residual speed of a flag at rest [mm/s]
DEEPER = 0.1    # greatest error of how deep it hangs, in parts of its length


class Rest(NamedTuple):
    """What became of a flag in calm air."""

    speed: float    # residual, RMS over nodes and the time that is watched [mm/s]; inf: diverged
    depth: float    # of the nodes' mean below the hoist's upper end [m]


def rest(shot: Shot, cloth: Cloth) -> Rest:
    """Return what becomes of a cloth that is blown in a shot's wind, which then stops."""
    material = cloth.material
    stilled = dataclasses.replace(material, node_damping=max(STILLING, material.node_damping))
    watched = shot.frames(WATCHED)
    try:
        shot.play(cloth, 0, shot.frames(BLOWN))
        cloth.material, speeds = stilled, []
        while len(speeds) < shot.frames(STILLED) and not (
                len(speeds) >= watched and max(speeds[-watched:]) < STILL):
            speeds.append(_speed(cloth, shot.dt))
        cloth.material = material
        speeds = [_speed(cloth, shot.dt) for _ in range(shot.frames(FREE))]
    except Diverged:
        return Rest(math.inf, math.inf)
    return Rest(rms(speeds[-watched:]), cloth.hoist_top[2] - float(cloth.positions[..., 2].mean()))


def _speed(cloth, dt):
    """Return the speed [mm/s] of a cloth, RMS over its nodes, after a frame in calm air."""
    cloth.advance(dt)
    return 1e3 * rms(np.linalg.norm(cloth.velocities, axis=-1))
