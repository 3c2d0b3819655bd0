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
Sums over all nodes that are the same to the bit on every processor, with any number of threads.

What a sum is rounded to depends on its order. In whatever vectors a processor has, the order here
is one: nodes are counted off into LANES sums, which are added up in pairs, and the nodes into
segments, whose sums are added one after the other. Segments depend on the mesh alone, and each is
one thread's. Everything is summed in float64.
"""
from typing import NamedTuple

from flag_sim.cloth.records import Band, Field
from flag_sim.cloth.solvers.lanes import part_of
from flag_sim.jit.kernels import inner_kernel, wide_kernel
import numpy as np

LANES = 32
"""Sums that nodes are counted off into: a few vectors, so that none waits for the one before."""
NODES = 1024
"""Nodes in a segment, at least, but where there are fewer."""
SEGMENTS = 16
"""The most segments, and so the most threads that sum."""
PIECE = 64
"""Nodes that a segment is a whole number of."""


class Sums(NamedTuple):
    """Where sums are made; nothing is kept in it between steps."""

    lanes: np.ndarray  # LANES numbers for each segment and sum
    parts: np.ndarray  # one number for each segment and sum
    count: int         # how many sums there are

    @classmethod
    def of(cls, count: int) -> 'Sums':
        """Return room for so many sums."""
        return cls(np.zeros(SEGMENTS * count * LANES), np.zeros(SEGMENTS * count), count)


class Segment(NamedTuple):
    """Nodes, and where their sum is made."""

    first: np.uint64
    last: np.uint64    # not included
    stride: np.uint64  # from a node to the one below
    at: np.uint64      # in Sums.lanes


@inner_kernel
def _segments(whole):
    """Return how many segments all nodes are divided into."""
    return min(max(np.int64(whole.last - whole.first) // NODES, 1), SEGMENTS)


@inner_kernel
def segments_of(band: Band, whole: Band) -> tuple[int, int]:
    """Return which segments are a thread's: first and last, not included."""
    return part_of(_segments(whole), band, whole)


@inner_kernel
def _start(number, whole):
    """Return the first node of a segment."""
    pieces = (np.int64(whole.last - whole.first) + PIECE - 1) // PIECE
    return min(whole.first + np.uint64(PIECE * (pieces * number // _segments(whole))), whole.last)


@inner_kernel
def begin_sums(sums: Sums, first: int, count: int, number: int, whole: Band) -> Segment:
    """Begin the sums `first` and the following, `count` in all, of a segment, by its number."""
    at = (number * sums.count + first) * LANES
    for n in range(at, at + count * LANES):
        sums.lanes[n] = 0.0
    return Segment(_start(number, whole), _start(number + 1, whole), whole.stride, np.uint64(at))


@inner_kernel
def end_sums(sums: Sums, first: int, count: int, number: int) -> None:
    """End what begin_sums began: add up the lanes."""
    for one in range(number * sums.count + first, number * sums.count + first + count):
        at = one * LANES
        half = LANES // 2
        while half > 0:
            for n in range(at, at + half):
                sums.lanes[n] += sums.lanes[n + half]
            half //= 2
        sums.parts[one] = sums.lanes[at]


@inner_kernel
def total(sums: Sums, one: int, whole: Band) -> float:
    """Return a sum over all segments, once all have ended."""
    result = 0.0
    for number in range(_segments(whole)):
        result += sums.parts[number * sums.count + one]
    return result


@wide_kernel
def _add_dot(a, b, lanes, segment):
    """Add a . b of a segment's nodes to its lanes."""
    ax, ay, az = a
    bx, by, bz = b
    first, last, _, at = segment
    for start in range(first, last, np.uint64(LANES)):
        for i in range(start, min(start + np.uint64(LANES), last)):
            lanes[at + (i - start)] += (np.float64(ax[i]) * bx[i] + np.float64(ay[i]) * by[i]
                                        + np.float64(az[i]) * bz[i])


@wide_kernel
def _add_norm2(a, weight, lanes, segment):
    """Add weight a . a of a segment's nodes to its lanes."""
    x, y, z = a
    first, last, _, at = segment
    for start in range(first, last, np.uint64(LANES)):
        for i in range(start, min(start + np.uint64(LANES), last)):
            ax, ay, az = np.float64(x[i]), np.float64(y[i]), np.float64(z[i])
            lanes[at + (i - start)] += weight[i] * (ax * ax + ay * ay + az * az)


@inner_kernel
def dot(a: Field, b: Field, sums: Sums, whole: Band) -> float:
    """Return the sum of a . b over all nodes, by one thread."""
    for number in range(_segments(whole)):
        _add_dot(a, b, sums.lanes, begin_sums(sums, 0, 1, number, whole))
        end_sums(sums, 0, 1, number)
    return total(sums, 0, whole)


@inner_kernel
def norm2(a: Field, weight: np.ndarray, sums: Sums, whole: Band) -> float:
    """Return the sum of weight a . a over all nodes, by one thread."""
    for number in range(_segments(whole)):
        _add_norm2(a, weight, sums.lanes, begin_sums(sums, 0, 1, number, whole))
        end_sums(sums, 0, 1, number)
    return total(sums, 0, whole)
