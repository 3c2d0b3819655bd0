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
Coverage: which pixels belong to a triangle.

A pixel belongs to a triangle if its sample does, which most often is its centre; a sample on an
edge that two triangles share belongs to one of them alone (the top-left rule), so they leave
neither gaps nor pixels drawn twice. A sample is inside where three edge functions (Pineda, 1988)
are not negative. They are whole numbers, so coverage is exact: vertices lie at whole subpixels.
The fill rule is implemented only here (and, for reference, in plain.py).
"""
from flag_sim.drawing.geometry import SUBPIXEL_BITS
from flag_sim.jit.kernels import late_inner_kernel

import numpy as np


@late_inner_kernel
def edge_function(change_u, change_v, du, dv):
    """
    Return an edge function at an offset (du, dv) [subpixel] from where its edge begins.

    change_u, change_v: what a pixel to the right and a pixel down add to it; for an edge that has
    the inside to its left these are minus its extent in v and its extent in u [subpixel]. The
    function is divided by the subpixels of a pixel, which keeps its sign. A point on an edge that
    is neither a top nor a left one is outside: there the function is made negative.
    """
    is_excluded = (change_u < 0) | ((change_u == 0) & (change_v < 0))
    return (change_u * du + change_v * dv - (1 if is_excluded else 0)) >> SUBPIXEL_BITS


@late_inner_kernel
def first_inside(begin, here, change):
    """Return the first column, but not before `begin`, where here + column change may be >= 0."""
    if change > 0:
        return max(begin, -(here // change))
    return begin if change < 0 or here >= 0 else np.int64(2 ** 40)


@late_inner_kernel
def end_inside(end, here, change):
    """Return the column, but not beyond `end`, from where on here + column change is < 0."""
    return min(end, here // -change + 1) if change < 0 else end
