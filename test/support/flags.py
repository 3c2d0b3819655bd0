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

"""Flags to draw."""
import numpy as np


def wave(rows=21, columns=31, phase=0.0):
    """Make a flag on its pole, with waves."""
    s, z = np.meshgrid(np.linspace(0.0, 2.25, columns), np.linspace(8.9, 7.4, rows))
    y = 0.3 * s + 0.15 * s * np.sin(5.0 * s + z - phase)
    return np.stack([0.05 + s, y, z - 0.1 * s], axis=-1)


def nearest(positions):
    """Return how near edges of faces of cloth (rows, columns, 3) come to the z axis [m]."""
    flat = positions[..., :2]
    a, b, c, d = flat[:-1, :-1], flat[:-1, 1:], flat[1:, :-1], flat[1:, 1:]
    first = np.stack([a, c, a, b, a, b]).reshape(-1, 2)
    way = np.stack([b, d, c, d, d, c]).reshape(-1, 2) - first
    length2 = np.maximum(np.sum(way * way, axis=-1), 1e-300)
    along = np.clip(-np.sum(first * way, axis=-1) / length2, 0.0, 1.0)
    return np.hypot(*(first + along[:, None] * way).T).min()
