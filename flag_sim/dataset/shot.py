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
The frames of a clip as the nodes make them: wind, then cloth, then what is drawn of it.

What stands here is what the nodes wind, physics and renderer do with a frame when it is their
turn, without the messages between them, so that a clip is the same to the byte.
"""
from collections.abc import Iterator
from typing import NamedTuple

from flag_sim.animation.keys import read_timeline, values_at
from flag_sim.animation.wind_source import WindSource
from flag_sim.cloth.simulation import MAX_WIND
from flag_sim.dataset.recipe import Drawn
from flag_sim.declarations.factories import Look, look_of
from flag_sim.declarations.keyable import TARGETS
from flag_sim.declarations.moving_cloth import MovingCloth
from flag_sim.declarations.nodes import named
from flag_sim.declarations.physics import check_method
from flag_sim.declarations.scene import check_scene
from flag_sim.drawing import LastFrame
from flag_sim.parameters import checks
from flag_sim.protocol.clock import FrameClock
import numpy as np


class NoClip(Exception):
    """A clip that cannot be made, for a reason that lies in what was drawn for it."""


class Moment(NamedTuple):
    """
    One frame of a clip, before it is drawn.

    index; stamp [ns]; wind: (3,) float64 [m/s]; keyed: {node.parameter: value}; look: what its
    picture depends on beside the cloth; points: (rows, columns, 6) float32, positions [m] and unit
    normals, as on `vertices`; velocities: (rows, columns, 3) float32 [m/s]; is_softened: whether
    the cloth was softer than it is set; pole_load: (6,) float64, force [N] and moment [N m] of
    what the flag does to its pole, if it was asked for.
    """

    index: int
    stamp: int
    wind: np.ndarray
    keyed: dict
    look: Look
    points: np.ndarray
    velocities: np.ndarray
    is_softened: bool
    pole_load: np.ndarray | None = None

    @property
    def positions(self) -> np.ndarray:
        """Return the positions as the renderer reads them: (rows, columns, 3) float64 [m]."""
        return self.points[..., :3].astype(np.float64)

    @property
    def normals(self) -> np.ndarray:
        """Return the unit normals as the renderer reads them: (rows, columns, 3) float64."""
        return self.points[..., 3:].astype(np.float64)

    def as_last(self) -> LastFrame:
        """Return the frame for the flow between it and another one."""
        return LastFrame(self.positions, self.look.camera, self.look.dimensions)


def check(drawn: Drawn) -> None:
    """Raise NoClip where what was drawn cannot be a clip, as far as it is known beforehand."""
    try:
        wind = drawn.values['wind']
        WindSource(wind, read_timeline(wind, TARGETS))
        for node in ('physics', 'renderer'):
            _check_together(node, drawn.values[node])
        look_of(drawn.values['renderer'])
        MovingCloth(drawn.values['physics'])
    except ValueError as error:
        raise NoClip(str(error)) from None


def _check_together(node, values):
    """Raise ValueError for what a node refuses of values that are right one by one."""
    check_scene(values)
    if node == 'physics':
        check_method(values)


class Shot:
    """
    The frames of a clip.

    drawn: what it is made by; frames: how many; rate [Hz]; has_load: whether to tell pole_load.
    """

    def __init__(self, drawn: Drawn, frames: int, rate: float, has_load: bool = False):
        check(drawn)
        self._has_load = has_load
        self._values = {node: {**values, 'threads': 1} if node != 'wind' else values
                        for node, values in drawn.values.items()}
        self._frames, self._rate = frames, rate

    def __iter__(self) -> Iterator[Moment]:
        """Yield the frames; raise NoClip where one cannot be made as it is set."""
        wind_values = self._values['wind']
        timeline = read_timeline(wind_values, TARGETS)
        source, clock = WindSource(wind_values, timeline), FrameClock(self._rate)
        cloth = MovingCloth(self._values['physics'])
        look_values, look = None, None
        for index in range(self._frames):
            clock.index = index
            at = clock.time
            keyed = values_at(timeline, at / 1e9, TARGETS)
            wind = self._checked(index, lambda: source.at(at / 1e9))
            self._checked(index, lambda: checks.vector('wind', wind, MAX_WIND))
            cloth.advance_to(at, wind, self._checked(index, self._merged, 'physics', keyed))
            if cloth.divergence or cloth.gap:
                raise NoClip(f'frame {index}: ' + (cloth.divergence or (
                    f'{checks.text(cloth.gap)} s between frames is more than max_gap')))
            values = self._checked(index, self._merged, 'renderer', keyed)
            if values != look_values:
                look_values, look = values, self._checked(index, look_of, values)
            points = np.concatenate([cloth.positions, cloth.normals()], axis=2, dtype=np.float32)
            yield Moment(index, at, wind, keyed, look, points,
                         cloth.velocities.astype(np.float32), bool(cloth.softness()),
                         np.concatenate(cloth.pole_load(wind)) if self._has_load else None)

    def _merged(self, node, keyed):
        """Return a node's values of a frame: its own and, before them, the keyed ones."""
        own = {name.removeprefix(f'{node}.'): value for name, value in keyed.items()
               if name.startswith(f'{node}.')}
        values = {**self._values[node], **{name: named(node)[name].accept(value)
                                           for name, value in own.items()}}
        if own:
            _check_together(node, values)
        return values

    @staticmethod
    def _checked(index, make, *arguments):
        """Return what is made; what is refused is why there is no clip."""
        try:
            return make(*arguments)
        except ValueError as error:
            raise NoClip(f'frame {index}: {error}') from None
