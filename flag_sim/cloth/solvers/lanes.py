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
Lines that lie side by side: which of them a thread computes, and in which pieces.

In a line node follows node at a distance, `back`. Along a row that is 1; down the columns and the
diagonals it is a row, or one node less or more. There so many lines lie side by side, and of
`back` nodes in a row each is in another line: what a line's solution hands on goes from piece to
piece, while within a piece all nodes are computed at once, as vectors, and by whichever thread.
"""
from flag_sim.cloth.records import Band
from flag_sim.jit.kernels import inner_kernel
import numpy as np

ROWS = 16
"""Rows that are solved node by node in turn, so that none waits for the node before it."""
VECTOR = 16
"""The most numbers that are in a vector: pieces are whole vectors where they may be."""


@inner_kernel
def part_of(count: int, band: Band, whole: Band) -> tuple[int, int]:
    """Return the first and last, not included, of a thread's part of `count` equal things."""
    size = np.int64(whole.last - whole.first)
    return (count * np.int64(band.first - whole.first) // size,
            count * np.int64(band.last - whole.first) // size)


@inner_kernel
def rows_of(band: Band, whole: Band) -> tuple[int, int]:
    """Return which rows are a thread's: first and last, not included."""
    return part_of(np.int64((whole.last - whole.first) // whole.stride), band, whole)


@inner_kernel
def row_range(row: int, last_row: int, whole: Band) -> tuple[np.uint64, np.uint64]:
    """Return the first and last node, not included, of at most ROWS rows from one on."""
    first, stride = np.int64(whole.first), np.int64(whole.stride)
    return (np.uint64(first + row * stride),
            np.uint64(first + min(row + ROWS, last_row) * stride))


@inner_kernel
def lanes_of(back: np.uint64, band: Band, whole: Band) -> tuple[int, int, int]:
    """
    Return which lines are a thread's, first and last, not included, and how long pieces are.

    Counted from the end of a piece's range of nodes, which begins before the thread's own part of
    a piece and ends after it.
    """
    size = np.int64(back)
    if band.last - band.first == whole.last - whole.first:
        if size > VECTOR:
            size = size // VECTOR * VECTOR
        return 0, size, size
    begin, end = part_of((size + VECTOR - 1) // VECTOR, band, whole)
    return min(begin * VECTOR, size), min(end * VECTOR, size), size


@inner_kernel
def count_pieces(begin: np.uint64, end: np.uint64, size: int) -> int:
    """Return in how many pieces nodes up to `end` are computed; the first one may be cut."""
    return (np.int64(end - begin) + size - 1) // size


@inner_kernel
def piece(number: int, begin: np.uint64, end: np.uint64,
          lanes: tuple[int, int, int]) -> tuple[np.uint64, np.uint64]:
    """Return first and last node, not included, of a thread's part of a piece, from the last."""
    low, high, size = lanes
    start = np.int64(end) - (number + 1) * size
    first = max(start + low, np.int64(begin))
    return np.uint64(first), np.uint64(max(start + high, first))
