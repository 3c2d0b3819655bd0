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

"""Whether the flag that comes hangs where the renderer's pole stands."""
from collections.abc import Mapping
import math

from flag_sim.declarations.factories import hoist_of
from flag_sim.declarations.scene import PLACE
from flag_sim.protocol.throttled_log import Entry
import numpy as np

PATIENCE = 10
"""Frames in a row that are apart before it is said: parameters of two nodes are set in turn."""
TOLERANCE = 1e-3
"""Distance [m], and part of the coordinates, at which a hoist is on its pole: float32, rounded."""


class PoleMatch:
    """Follows where flags hang, frame after frame, by the renderer's parameters {name: value}."""

    def __init__(self):
        self._apart = 0

    def update(self, vertices: np.ndarray, values: Mapping) -> list[Entry]:
        """Return what there is to log of a flag (rows, columns, 3) [m]."""
        expected, hoist = hoist_of(values), vertices[0, 0]
        close = TOLERANCE * (1.0 + np.abs(expected).max())
        is_on = not values['pole.visible'] or math.dist(hoist, expected) <= close
        self._apart = 0 if is_on else self._apart + 1
        if self._apart != PATIENCE:
            return []
        names = ', '.join(one.name for one in PLACE)
        there, here = (' '.join(f'{x:.3f}' for x in place) for place in (hoist, expected))
        return [Entry('warning', (
            f'the flag hangs at ({there}) m, and from the pole that is drawn it would at ({here}) '
            f'm: {names}, pole.height and pole.diameter must be the same in physics and in the '
            'renderer; keys named scene.* set both'))]
