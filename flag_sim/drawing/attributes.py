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
Attributes: whatever a pixel shows of the triangle that it sees, interpolated between vertices.

Visibility leaves in each pixel the number of a slot. For each slot stand here the planes over the
screen that an attribute's channels are: at the slot's first pixel, and their changes a column and
a row. Attributes come in groups of THREE channels, of which red, green and blue are one; the
fourth lane holds where the first pixel is. `screen` interpolation is linear from pixel to pixel,
`perspective` linear in space: then the planes are of the channels times reversed Z (Heckbert,
1989), which is divided out pixel by pixel. No value leaves the range of the triangle's vertices:
where one is so thin that planes change by thousands from pixel to pixel, so does their rounding.
"""
from typing import NamedTuple

from flag_sim.drawing.lanes import (
    add_times, CHANNELS, double, least, load, most, pack, single, store, times)
from flag_sim.kernels import inner_kernel, kernel

import numpy as np

# Channels of a group, and numbers of its planes: at the first pixel, a column on, a row on, the
# least and the most, CHANNELS each.
THREE, PLANE = 3, 5 * CHANNELS
FIRST, COLUMN, ROW, LEAST, MOST = (np.uint64(k * CHANNELS) for k in range(5))
LAST_LANE = np.uint64(CHANNELS - 1)
# The slot that pixels hold where nothing is.
NOTHING = np.uint32(0)


class Values(NamedTuple):
    """
    Attributes of a scene's vertices or triangles, both sides of them.

    numbers: flat float32; of each group, first: (groups,) uint64, from where on its numbers
    stand, (n, 2, CHANNELS): [:, 0] of the front, [:, 1] of the back; at_triangles: (groups,) bool,
    one for each triangle and not for each vertex; is_perspective: (groups,) bool, how they are
    interpolated; nothing: (groups CHANNELS,) float32, what pixels show where nothing is.
    """

    numbers: np.ndarray
    first: np.ndarray
    at_triangles: np.ndarray
    is_perspective: np.ndarray
    nothing: np.ndarray


@kernel
def write_nothing(values, groups, table):
    """Write the planes of the slot NOTHING, which are level."""
    table[:groups * PLANE] = 0.0
    for g in range(groups):
        for lane in range(THREE):
            value = values.nothing[g * CHANNELS + lane]
            for field in (FIRST, LEAST, MOST):
                table[np.uint64(g * PLANE + lane) + field] = value


@inner_kernel
def write_planes(values, groups, table, slot, source, origin, weights):
    """
    Write the planes of a slot for the first `groups` groups of attributes.

    source: its vertices' numbers a, b, c, its triangle's and the side that is seen (0 or 1);
    origin: column and row of its first pixel; weights: two times nine, planes of the barycentric
    coordinates of a, b and c, linear on the screen, and the same times reversed Z.
    """
    a, b, c, triangle, side = source
    screen, perspective = weights
    for g in range(np.uint64(groups)):
        place = (np.uint64(slot) * np.uint64(groups) + g) * np.uint64(PLANE)
        first = values.first[g] + side * np.uint64(CHANNELS)
        at = (a, b, c)
        if values.at_triangles[g]:
            at = (triangle, triangle, triangle)
        if values.is_perspective[g]:
            _write_group(values.numbers, first, at, perspective, table, place)
        else:
            _write_group(values.numbers, first, at, screen, table, place)
        table[place + FIRST + LAST_LANE] = origin[0]
        table[place + COLUMN + LAST_LANE] = origin[1]


@inner_kernel
def _write_group(numbers, first, at, weights, table, place):
    at_a = load(numbers, first + at[0] * np.uint64(2 * CHANNELS))
    at_b = load(numbers, first + at[1] * np.uint64(2 * CHANNELS))
    at_c = load(numbers, first + at[2] * np.uint64(2 * CHANNELS))
    a, a_u, a_v, b, b_u, b_v, c, c_u, c_v = weights
    store(table, place + FIRST, _mean(at_a, at_b, at_c, a, b, c))
    store(table, place + COLUMN, _mean(at_a, at_b, at_c, a_u, b_u, c_u))
    store(table, place + ROW, _mean(at_a, at_b, at_c, a_v, b_v, c_v))
    store(table, place + LEAST, least(at_a, least(at_b, at_c)))
    store(table, place + MOST, most(at_a, most(at_b, at_c)))


@inner_kernel
def _mean(at_a, at_b, at_c, of_a, of_b, of_c):
    """Return the sum of three lanes, weighted, in float64, rounded to float32."""
    return single(add_times(add_times(times(double(at_a), of_a), double(at_b), of_b),
                            double(at_c), of_c))


@kernel
def darken(table, slot, darker, groups, factor):
    """Write the planes of slot `darker`: those of `slot`, red, green and blue times a factor."""
    source, target = slot * groups * PLANE, darker * groups * PLANE
    for k in range(groups * PLANE):
        is_colour = k < PLANE and k % CHANNELS < THREE
        table[target + k] = table[source + k] * (factor if is_colour else np.float32(1.0))


class Area(NamedTuple):
    """
    Pixels of a band: columns left .. right - 1 of `rows` rows from row `first` of its buffers on.

    Buffers have `stride` pixels a row; their row 0 is row `top` of the image.
    """

    top: int
    first: int
    rows: int
    left: int
    right: int
    stride: int


@kernel
def resolve_colours(slots, depths, area, values, groups, table, words):
    """
    Write what pixels show of group 0 as colours: words, red lowest.

    slots, depths: what visibility left.
    """
    top, begin, rows, left, right, stride = area
    step, is_perspective = np.uint64(groups * PLANE), values.is_perspective[0]
    for row in range(begin, begin + rows):
        first, v = np.uint64(row * stride), np.float32(top + row)
        for j in range(np.uint64(left), np.uint64(right)):
            lanes = _lanes_at(table, slots[first + j] * step, np.float32(np.int32(j)), v,
                              depths[first + j], is_perspective)
            words[first + j] = pack(lanes)


@kernel
def resolve_channels(slots, depths, area, values, group, table, image):
    """
    Write what pixels show of another group into an image.

    image: (height, width, CHANNELS) float32, of which the area's rows and columns are written.
    """
    top, begin, rows, left, right, stride = area
    groups, is_perspective = values.first.size, values.is_perspective[group]
    flat, width = image.reshape(-1), image.shape[1]
    for row in range(begin, begin + rows):
        first, v = np.uint64(row * stride), np.float32(top + row)
        target = np.uint64((top + row) * width)
        for j in range(np.uint64(left), np.uint64(right)):
            place = (slots[first + j] * np.uint64(groups) + np.uint64(group)) * np.uint64(PLANE)
            lanes = _lanes_at(table, place, np.float32(np.int32(j)), v, depths[first + j],
                              is_perspective)
            store(flat, (target + j) * np.uint64(CHANNELS), lanes)


@inner_kernel
def _lanes_at(table, place, u, v, reversed_z, is_perspective):
    """Return the channels of planes at column u, row v."""
    place = np.uint64(place)
    u -= table[place + FIRST + LAST_LANE]
    v -= table[place + COLUMN + LAST_LANE]
    lanes = add_times(load(table, place + FIRST), load(table, place + ROW), v)
    lanes = add_times(lanes, load(table, place + COLUMN), u)
    if is_perspective:
        lanes = times(lanes, np.float32(1.0) / reversed_z)
    return least(most(lanes, load(table, place + LEAST)), load(table, place + MOST))
