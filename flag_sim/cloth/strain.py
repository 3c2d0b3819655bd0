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

"""How far the cloth is stretched, from its definition in plain numpy."""
from flag_sim.cloth.mesh import Mesh
from flag_sim.parameters import checks
import numpy as np


def greatest_strain(mesh: Mesh, positions: np.ndarray) -> float:
    """
    Return by which part of its length at rest the longest thread between two nodes is stretched.

    positions: (rows, columns, 3) [m]. Threads run along rows and columns; 0.0 where none is
    longer than at rest. Raises ValueError for other shapes, and for numbers that are not finite.
    """
    positions = checks.array('positions', positions, (mesh.rows, mesh.columns, 3), checks.LARGEST)
    return max(0.0, *(float(np.linalg.norm(np.diff(positions, axis=axis), axis=-1).max()) / rest
                      - 1.0 for axis, rest in ((0, mesh.dy), (1, mesh.dx))))
