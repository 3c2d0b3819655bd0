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

"""How the cloth lies when it starts: nearly flat."""
import numpy as np

WAVES = 4
"""Waves of the bump along the cloth's length, and as many down its width."""


def bump(rows: int, columns: int, size: float, seed: int) -> np.ndarray:
    """
    Return how far out of their plane the nodes start (rows, columns) [m], at most size.

    An exactly flat sheet would stay flat forever, like a board: no force on it, neither gravity
    nor a wind along it, has a component across. A smooth random surface of the longest waves,
    zero at the hoist, and the same at every resolution: the nodes only sample it. The same seed
    gives the same surface.
    """
    u, v = np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows)
    wave = np.arange(WAVES)
    along = np.sin((wave[:, None] + 0.5) * np.pi * u)
    down = np.cos(wave[:, None] * np.pi * v)
    shares = np.random.default_rng(seed).uniform(-1.0, 1.0, (WAVES, WAVES))
    return size / WAVES**2 * (down.T @ shares @ along)
