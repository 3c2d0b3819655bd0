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
One triangle of a picture in plain numpy, to be read before the kernels, which compute the same.

A triangle has vertices i = a, b, c on the screen at (u_i, v_i) [pixel], u to the right and v down,
at depth z_i. Its edge functions (Pineda, 1988) are twice the areas of the triangles that a point p
makes with two of the vertices, with a x b = a_u b_v - a_v b_u:

    E_a(p) = (c - b) x (p - b),   E_b(p) = (a - c) x (p - c),   E_c(p) = (b - a) x (p - a)

Their sum is twice the signed area A, and p is inside where all have its sign. The weights
w_i = E_i / (2 A) are linear on the screen, and so is reversed Z, s = 1 / z, on any plane:

    s(p) = w_a s_a + w_b s_b + w_c s_c

A pixel keeps the greatest s of all triangles, which is the nearest (the Z-buffer). A value q is
interpolated linearly on the screen, or perspective-correctly, interpolating q / z (Heckbert,
1989):

    q(p) = w_a q_a + w_b q_b + w_c q_c,   q(p) = (w_a s_a q_a + w_b s_b q_b + w_c s_c q_c) / s(p)
"""
import numpy as np


def draw_triangle(corners, reversed_z, values, colour, depth, in_space=False) -> None:
    """
    Draw a triangle into an image and its Z-buffer.

    corners: (3, 2) [pixel]; reversed_z: (3,) [1/m]; values: (3, channels) at the corners; colour:
    (height, width, channels) and depth: (height, width), of reversed Z, 0 where nothing is yet,
    are written where the triangle is seen; in_space: how values are interpolated.
    """
    v, u = np.mgrid[:depth.shape[0], :depth.shape[1]]
    a, b, c = corners
    twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if twice_area == 0.0:
        return
    inside, weights = np.ones(depth.shape, bool), []
    for begin, end in ((b, c), (c, a), (a, b)):
        du, dv = np.sign(twice_area) * (end - begin)
        edge = du * (v - begin[1]) - dv * (u - begin[0])
        # The top-left rule: a centre on an edge belongs to the triangle below or right of it.
        is_top_or_left = dv < 0.0 or (dv == 0.0 and du > 0.0)
        inside &= edge >= 0.0 if is_top_or_left else edge > 0.0
        weights.append(edge / abs(twice_area))
    s = sum(w * s_i for w, s_i in zip(weights, reversed_z))
    seen = inside & (s > depth)
    if in_space:
        weights = [w * s_i / np.where(seen, s, 1.0) for w, s_i in zip(weights, reversed_z)]
    shown = sum(w[..., None] * value for w, value in zip(weights, values))
    colour[seen], depth[seen] = shown[seen], s[seen]
