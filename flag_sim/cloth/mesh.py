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

"""The grid of nodes: how it lies in memory, and what share of the sheet each node stands for."""
from dataclasses import dataclass

from flag_sim.cloth.records import Band, Vector, Weights
from flag_sim.parameters import checks
from flag_sim.parameters.closed import constant
from flag_sim.parameters.declared import Declared, declared
import numpy as np

SHORTEST_SIDE, LONGEST_SIDE = 1e-3, 1e4
"""
Of a cloth [m].

Nodes let people set up to 100 m, and a flag that follows its pole is up to 250 m long.
"""

CACHE_LINE = 64
"""Bytes in a cache line. Fields begin on one, so that the vectors that are stored lie in one."""

SMALLEST_BAND = 64
"""Nodes in the smallest band: the most that a loop takes at once, four vectors of 16 float32."""

LEAST_LENGTH2 = 1e-16
LEAST_AREA2 = 1e-30
"""
Squared length [m2] and area [m4] below which springs and faces have no direction.

Less is taken for that much, so that 0 / 0 gives zero and not NaN.
"""

PRECISIONS = ('float64', 'float32')
"""What the numbers of fields may be. Vectors hold twice as many float32."""


@dataclass(frozen=True)
class Grid(Declared):
    """How finely a cloth is cut, and the precision of its numbers, one of PRECISIONS."""

    columns: int = declared(31, 'nodes from hoist to fly', 'nodes', 2, 1001, name='grid.columns')
    rows: int = declared(21, 'nodes from upper to lower edge', 'nodes', 2, 1001, name='grid.rows')
    precision: str = declared(
        'float64', 'of the numbers inside; float32 is twice as fast, to 0.1 mm',
        choices=PRECISIONS)


@constant
class Mesh:
    """
    A rectangle of rows x columns nodes, row 0 the upper edge, column 0 the hoist.

    length, width: of the cloth at rest [m], along the rows and down the columns.
    pinned: whether the hoist is fixed; a cloth without pins flies free.
    precision: of all fields and of the numbers that go with them, one of PRECISIONS.

    In memory a field is one flat array. A ghost node follows each row and a row of ghosts lies
    above and below, so that every node finds its eight neighbours at constant offsets, stride to
    the next row. Ghosts have weight and mass zero: they need no special case.

    Raises ValueError for rows, columns and a precision that Grid refuses, and for a size that is
    not from SHORTEST_SIDE to LONGEST_SIDE.
    """

    def __init__(self, rows: int, columns: int, length: float, width: float, pinned: bool = True,
                 precision: str = Grid.precision):
        self.rows = Grid.accepted('rows', rows)
        self.columns = Grid.accepted('columns', columns)
        self.length = checks.finite('length', length, SHORTEST_SIDE, LONGEST_SIDE)
        self.width = checks.finite('width', width, SHORTEST_SIDE, LONGEST_SIDE)
        self.pinned = checks.boolean('pinned', pinned)
        self.precision = Grid.accepted('precision', precision)
        self._dtype = np.dtype(precision)
        self._largest = np.finfo(self._dtype).max
        self._line = CACHE_LINE // self._dtype.itemsize
        self.dx = self.length / (self.columns - 1)
        self.dy = self.width / (self.rows - 1)

        self.stride = self.columns + 1
        self.first = self._to_line(self.stride + 1)
        # Whole vectors to the end, so that no loop has nodes left over to compute one by one.
        self.last = self.first + self._to_line(self.rows * self.stride)
        self.size = self._to_line(self.last + self.stride + 1)

        row_ones, column_ones = np.ones(self.rows), np.ones(self.columns)
        row_half, column_half = _ends(row_ones, 0.5, 0.5), _ends(column_ones, 0.5, 0.5)
        row_next, column_next = _ends(row_ones, 1.0, 0.0), _ends(column_ones, 1.0, 0.0)
        row_inner, column_inner = _ends(row_ones, 0.0, 0.0), _ends(column_ones, 0.0, 0.0)
        self.weights = Weights(
            across=self.pad(np.outer(row_half, column_next)),
            down=self.pad(np.outer(row_next, column_half)),
            cell=self.pad(np.outer(row_next, column_next)),
            bend_across=self.pad(np.outer(row_half, column_inner)),
            bend_down=self.pad(np.outer(row_inner, column_half)))
        # A quarter of each cell's mass goes to each of its corners.
        self.mass_share = self.pad(np.outer(row_half, column_half))
        self.free = self.pad(np.outer(row_ones, _ends(column_ones, float(not self.pinned), 1.0)))

    def band(self, number: int = 0, count: int = 1) -> Band:
        """
        Return one of so many bands of nodes, which follow one another and are about equal.

        They begin where vectors would begin without them, so that every node is computed by the
        same instructions whatever the number of bands.
        """
        pieces = -(-(self.last - self.first) // SMALLEST_BAND)
        first, last = (min(self.first + SMALLEST_BAND * (pieces * end // count), self.last)
                       for end in (number, number + 1))
        return Band(np.uint64(first), np.uint64(last), np.uint64(self.stride))

    def grid(self, flat: np.ndarray) -> np.ndarray:
        """Return a view (rows, columns) of the nodes of a flat field (mesh.size,), no ghosts."""
        inside = flat[self.first:self.first + self.rows * self.stride]
        return inside.reshape(self.rows, self.stride)[:, :self.columns]

    def fields(self, count: int) -> np.ndarray:
        """Return new flat fields, all zero: (count, mesh.size), each on a cache line's start."""
        memory = np.zeros(count * self.size + self._line, self._dtype)
        start = -(memory.ctypes.data // memory.itemsize) % self._line
        return memory[start:start + count * self.size].reshape(count, self.size)

    def __reduce__(self):
        """Let a copy, also one of a file, have fields that begin where caches like it."""
        return type(self), (self.rows, self.columns, self.length, self.width, self.pinned,
                            self.precision)

    def pad(self, grid: np.ndarray) -> np.ndarray:
        """Return a new flat field (mesh.size,) that holds grid (rows, columns), zero at ghosts."""
        flat = self.fields(1)[0]
        self.grid(flat)[...] = grid
        return flat

    def number(self, value: float | tuple) -> np.floating | tuple:
        """Return value, or a tuple of values, in the fields' precision and within its range."""
        if isinstance(value, tuple):
            return tuple(self.number(one) for one in value)
        return self._dtype.type(min(value, self._largest))

    def hoist(self, hoist_top: Vector) -> np.ndarray:
        """Return the ends of the hoist, the upper one at hoist_top: (2, 3) [m]."""
        return self.rest(hoist_top)[[0, -1], 0]

    def rest(self, hoist_top: Vector) -> np.ndarray:
        """Return the cloth laid flat from hoist_top along +x and down: (rows, columns, 3) [m]."""
        positions = np.empty((self.rows, self.columns, 3))
        positions[..., 0] = hoist_top[0] + np.linspace(0.0, self.length, self.columns)
        positions[..., 1] = hoist_top[1]
        positions[..., 2] = hoist_top[2] - np.linspace(0.0, self.width, self.rows)[:, None]
        return positions

    def _to_line(self, count):
        """Return a count of numbers rounded up to whole cache lines."""
        return -(-count // self._line) * self._line


def _ends(ones, first, last):
    """Return a copy of ones with its first and last entries replaced."""
    result = ones.copy()
    result[0], result[-1] = first, last
    return result


def resample(values: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """
    Carry values (R, C, 3) over to another grid (rows, columns, 3), bilinear over the cloth itself.

    Edges stay edges and corners stay corners, so a running flag does not jump.
    """
    for axis, count in enumerate((rows, columns)):
        at = np.linspace(0.0, values.shape[axis] - 1.0, count)
        low = np.minimum(at.astype(int), values.shape[axis] - 2)
        part = (at - low).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
        values = (1.0 - part) * values.take(low, axis) + part * values.take(low + 1, axis)
    return values
