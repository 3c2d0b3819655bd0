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
