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
Segments: pixels that are shaded in one go (see pixel_pass), in steps from field to field.

A segment is a piece of a row, or what is marked of several rows, so that short pieces are not
shaded one by one: its first steps write down where each pixel is, and the others do not care.
"""
from typing import NamedTuple

from flag_sim.drawing.visibility import triangle_of
from flag_sim.jit.kernels import late_kernel, wide_kernel

import numpy as np

# Pixels of a segment, at most.
SEGMENT = 256
# Fields: columns and rows of the pixels' samples; their depth [m]; ...
COLUMN, ROW, DEPTH = (np.uint64(k * SEGMENT) for k in range(3))
# ... the sun's light, and the mirrored sun; the colour that light is multiplied to; ...
SUNLIGHT, ADDED, RED, GREEN, BLUE = (np.uint64(k * SEGMENT) for k in range(3, 8))
# ... where in the shadow map, and how deep, less the bias; ...
AT_U, AT_V, AT_Z = (np.uint64(k * SEGMENT) for k in range(8, 11))
# ... where in the texture, and in which mipmap; whether texels are looked up, for there is no flat
# tile; red, green and blue in linear light.
AT_X, AT_Y, LOD = (np.uint64(k * SEGMENT) for k in range(8, 11))
IS_OPEN = np.uint64(11 * SEGMENT)
LINEAR_RED, LINEAR_GREEN, LINEAR_BLUE = (np.uint64(k * SEGMENT) for k in range(11, 14))
FIELDS = 14


class Segment(NamedTuple):
    """
    A thread's memory for a segment.

    fields: flat float32, field after field, for places that are constants apart let LLVM make
    vectors of a loop; owners: (SEGMENT,) int32, the object that each pixel sees, -1 where that is
    nothing or is not shaded pixel by pixel; rest: (SEGMENT,) int32, pixels whose texels are
    looked up; colour, depth, faces: (SEGMENT,), see
    rasterizer.Target, of pixels that are copied here from several places: sources (SEGMENT,)
    int64.
    """

    fields: np.ndarray
    owners: np.ndarray
    rest: np.ndarray
    colour: np.ndarray
    depth: np.ndarray
    faces: np.ndarray
    sources: np.ndarray


def new_segment(is_wanted: bool) -> Segment:
    """Make the memory, of size 0 if it is not wanted."""
    count = SEGMENT * is_wanted
    return Segment(np.zeros(FIELDS * count, np.float32), *np.zeros((2, count), np.int32),
                   np.zeros(count, np.uint32), np.zeros(count, np.float32),
                   np.zeros(count, np.uint32), np.zeros(count, np.int64))


@late_kernel
def set_places(fields, first, count, column, row):
    """Write COLUMN and ROW of `count` pixels of a row, from the segment's pixel `first` on."""
    for i in range(np.uint64(count)):
        fields[COLUMN + first + i] = column + np.float32(np.int32(i))
        fields[ROW + first + i] = row


@wide_kernel
def find_owners(begin, count, faces, object_of, owners):
    """
    Write the owners of pixels begin .. begin + count - 1 of `faces`; see Surfaces.object_of.

    Returns False, and writes nothing, if all of them see nothing.
    """
    any_mark = np.uint32(0)
    for i in range(count):
        any_mark |= faces[begin + i]
    if any_mark == 0:
        return False
    for i in range(count):
        mark = faces[begin + i]
        owner = object_of[triangle_of(mark)]
        owners[i] = owner if mark != np.uint32(0) else np.int32(-1)
    return True


@wide_kernel
def sees(pixels, owners, k):
    """Return whether some of the pixels see object k."""
    _, first, end = pixels
    seen = np.int32(0)
    for i in range(first, end):
        seen |= np.int32(owners[i] == k)
    return seen != 0
