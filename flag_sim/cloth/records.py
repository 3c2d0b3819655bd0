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
The records that kernels take instead of lists of arrays, each named once.

A field is one flat array (mesh.size,), or three of them for x, y and z; see mesh.Mesh for how the
nodes lie in it. A record of arrays costs a kernel nothing: numba hands over its arrays one by one,
so that LLVM still knows that no two of them overlap.
"""
from typing import NamedTuple

import numpy as np

Field = tuple[np.ndarray, np.ndarray, np.ndarray]
"""x, y and z of a vector at each node: three flat arrays (mesh.size,)."""

Vector = tuple[float, float, float]
"""x, y and z."""

NEXT = np.uint64(1)
"""From a node to the next in its row; unsigned, as the numbers of a band are."""


class Band(NamedTuple):
    """
    The nodes that one thread computes: all from first up to last, which is not included.

    Unsigned: numba then needs no test for negative indices, and loops become vectors.
    """

    first: np.uint64
    last: np.uint64
    stride: np.uint64  # from a node to the one below


class Nodes(NamedTuple):
    """Where the nodes are and how fast they move: what a step reads, and what it writes."""

    position: Field  # [m], measured from the origin of their State
    velocity: Field  # [m/s]


class Weights(NamedTuple):
    """
    Shares of springs, cells and curvatures, each a flat array (mesh.size,), zero where none is.

    Springs and curvatures on a border stand for half as much sheet as those inside, hence 1/2.
    """

    across: np.ndarray       # the spring from a node to the next in its row
    down: np.ndarray         # the spring from a node to the one below
    cell: np.ndarray         # the cell whose upper hoist corner is the node
    bend_across: np.ndarray  # the curvature along the row, centred on the node
    bend_down: np.ndarray    # the curvature along the column, centred on the node


class Sheet(NamedTuple):
    """What each node and each spring stands for; constant while the cloth moves."""

    mass: np.ndarray          # flat (mesh.size,) [kg], zero at ghosts
    inverse_mass: np.ndarray  # flat (mesh.size,) [1/kg], zero where a node does not move
    weights: Weights


class Steps(NamedTuple):
    """The steps that a call takes."""

    dt: float   # the length of each [s], in the precision of the fields
    count: int
