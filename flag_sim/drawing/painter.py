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

"""The painter's algorithm: triangles sorted from far to near (Newell et al., 1972, step one)."""
from flag_sim.jit.kernels import late_kernel

import numpy as np


def far_to_near(triangles: np.ndarray, view: np.ndarray) -> np.ndarray:
    """
    Order triangles (m, 3) by the depth of their centres, the farthest first: (m,) int32.

    view: (n, 3), of which [:, 2] is the vertices' depth [m]. Triangles of the same depth keep
    their order.
    """
    depths = np.empty(len(triangles))
    _sums_of_depths(triangles, view, depths)
    return np.argsort(-depths, kind='stable').astype(np.int32)


@late_kernel
def _sums_of_depths(triangles, view, depths):
    for t in range(triangles.shape[0]):
        depths[t] = view[triangles[t, 0], 2] + view[triangles[t, 1], 2] + view[triangles[t, 2], 2]
