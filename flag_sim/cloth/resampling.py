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
From grid to grid: the same sheet on other nodes, with its strain and its momentum.

Nodes that are sampled from a finer grid cut folds short: between two of them lies more cloth than
their distance, so that springs would be pressed together and would throw the sheet apart. So after
they are sampled they are moved until their springs are stretched as those of the old grid were.
"""
from flag_sim.cloth.energy import bending_energy, elastic_energy
from flag_sim.cloth.mesh import resample
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Vector
import numpy as np

MAX_ITERATIONS = 800
"""Of the search for positions: what the deepest folds on the coarsest grids need."""
CHECK_PERIOD = 10
"""Iterations between two checks of the energy, each of which costs as much as an iteration."""
MOMENTUM = 0.985
"""Fraction of the last iteration's displacement that is added (Polyak's heavy ball)."""


def carry_over(old: Model, positions: np.ndarray, velocities: np.ndarray, new: Model,
               origin: Vector) -> tuple[np.ndarray, np.ndarray]:
    """
    Return (positions, velocities) (rows, columns, 3) [m], [m/s] on another grid.

    old, new: models of one material. Edges stay edges, and the corners stay where they are unless
    the grid is too coarse to keep the cloth between them without pressing it together. The energy
    of springs and bending is no greater than it was, or as near to that as the grid comes. Linear
    momentum and that about the origin (3,), where the hoist is [m], are kept where nodes but
    corners are free.
    """
    at = _relaxed(old, positions, new)
    mesh = new.mesh
    v = resample_mean(velocities, mesh.rows, mesh.columns)
    v *= mesh.grid(mesh.free)[..., None]
    return at, _with_momentum(old, positions, velocities, new, at, v, np.asarray(origin))


def resample_mean(values: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """
    Carry values (R, C, 3) over to another grid (rows, columns, 3): the nearest in the mean square.

    Bilinear fields nearest to a bilinear field, with the same corners, over the whole cloth.
    """
    for axis, count in ((0, rows), (1, columns)):
        values = np.moveaxis(np.tensordot(_fit(values.shape[axis], count), values, (1, axis)), 0,
                             axis)
    return values


def _fit(old, new):
    """Return the matrix (new, old) that fits piecewise linear functions on (0, 1), ends fixed."""
    # The product of two such functions is quadratic between the knots of both: Simpson is exact.
    knots = np.union1d(np.linspace(0.0, 1.0, old), np.linspace(0.0, 1.0, new))
    points = np.concatenate([knots, 0.5 * (knots[1:] + knots[:-1])])
    steps = np.diff(knots)
    weights = np.zeros(len(points))
    weights[:len(steps)] += steps / 6.0
    weights[1:len(knots)] += steps / 6.0
    weights[len(knots):] = 4.0 / 6.0 * steps
    hats, given = _hats(points, new), _hats(points, old)
    fit = np.zeros((new, old))
    fit[0, 0] = fit[-1, -1] = 1.0
    inner = hats[:, 1:-1] * weights[:, None]
    fit[1:-1] = np.linalg.solve(inner.T @ hats[:, 1:-1],
                                inner.T @ (given - hats[:, [0, -1]] @ fit[[0, -1]]))
    return fit


def _hats(points, count):
    """Return the values (points, count) of the linear elements on an even grid of (0, 1)."""
    nodes = np.linspace(0.0, 1.0, count)
    return np.maximum(0.0, 1.0 - np.abs(points[:, None] - nodes) * (count - 1))


def _energy(model, positions):
    return elastic_energy(model, positions) + bending_energy(model, positions)


def _relaxed(old, positions, new):
    """Return positions on the new grid with about the old one's strain."""
    mesh = new.mesh
    at = resample(positions, mesh.rows, mesh.columns)
    most = _energy(old, positions)
    best, least = at, _energy(new, at)
    if least <= most:
        return at
    springs = _springs(new, _strain(old, positions))
    moves = mesh.grid(mesh.free).copy()
    for corner in (0.0, 1.0):  # they stay where that is enough
        moves[[0, 0, -1, -1], [0, -1, 0, -1]] *= corner
        found, energy = _stretched(new, at, springs, moves, most)
        if energy < least:
            best, least = found, energy
        if least <= most:
            break
        moves = mesh.grid(mesh.free).copy()
    return best


def _stretched(model, at, springs, moves, enough):
    """Return (positions, energy) near the ones at, of the least energy or of enough [J]."""
    load = sum(_spread(ends, stiff * np.ones_like(length), 1.0, moves.shape)
               for ends, stiff, length in springs)
    part = (moves / np.where(load > 0.0, load, 1.0))[..., None]
    best, least = at, np.inf
    way = np.zeros_like(at)
    for number in range(1, MAX_ITERATIONS + 1):
        way = MOMENTUM * way + part * sum(_spring_forces(at, *spring) for spring in springs)
        at = at + way
        if number % CHECK_PERIOD == 0:
            energy = _energy(model, at)
            if energy < least:
                best, least = at, energy
            if least <= enough:
                break
    return best, least


def _strain(model, positions):
    """
    Return Green's strain (rows - 1, columns - 1, 3) of the cells: along rows, columns, and shear.

    From the lengths of a cell's springs, so that a fold is no strain.
    """
    mesh, p = model.mesh, positions
    across, down, falling, rising = (
        np.sum(ends**2, axis=-1) for ends in (
            p[:, 1:] - p[:, :-1], p[1:] - p[:-1], p[1:, 1:] - p[:-1, :-1],
            p[1:, :-1] - p[:-1, 1:]))
    return np.stack([0.5 * (0.5 * (across[1:] + across[:-1]) / mesh.dx**2 - 1.0),
                     0.5 * (0.5 * (down[:, 1:] + down[:, :-1]) / mesh.dy**2 - 1.0),
                     (falling - rising) / (8.0 * mesh.dx * mesh.dy)], axis=-1)


def _overlaps(old, new):
    """Return the share (new, old) of each of the old equal parts of (0, 1) in each new one."""
    a, b = np.linspace(0.0, 1.0, old + 1), np.linspace(0.0, 1.0, new + 1)
    shared = np.minimum(b[1:, None], a[1:]) - np.maximum(b[:-1, None], a[:-1])
    return np.maximum(shared, 0.0) * new


def _springs(model, strain):
    """Return (ends, stiffness, length) of the springs of a model in a strain of other cells."""
    mesh, weights = model.mesh, model.mesh.weights
    cells = np.einsum('ir,jc,rck->ijk', _overlaps(strain.shape[0], mesh.rows - 1),
                      _overlaps(strain.shape[1], mesh.columns - 1), strain)
    beside = np.pad(cells, ((1, 1), (1, 1), (0, 0)), mode='edge')
    by_rows, by_columns = 0.5 * (beside[1:, 1:-1] + beside[:-1, 1:-1]), \
        0.5 * (beside[1:-1, 1:] + beside[1:-1, :-1])

    def length(strain, dx, dy):
        squared = (dx * dx * (1.0 + 2.0 * strain[..., 0]) + dy * dy * (1.0 + 2.0 * strain[..., 1])
                   + 4.0 * dx * dy * strain[..., 2])
        return np.sqrt(np.maximum(squared, 0.0))

    every, but_last, but_first = slice(None), slice(None, -1), slice(1, None)
    k_across, k_down, k_diagonal = model.spring_k
    cell = np.full(cells.shape[:2], k_diagonal)
    return (
        (((every, but_last), (every, but_first)),
         k_across * mesh.grid(weights.across)[:, :-1], length(by_rows, mesh.dx, 0.0)),
        (((but_last, every), (but_first, every)),
         k_down * mesh.grid(weights.down)[:-1], length(by_columns, 0.0, mesh.dy)),
        (((but_last, but_last), (but_first, but_first)), cell, length(cells, mesh.dx, mesh.dy)),
        (((but_first, but_last), (but_last, but_first)), cell, length(cells, mesh.dx, -mesh.dy)))


def _spread(ends, at_first, sign, shape):
    """Return a field of that shape with values of springs summed at both ends, with a sign."""
    field = np.zeros(shape)
    field[ends[0]] += at_first
    field[ends[1]] += sign * at_first
    return field


def _spring_forces(at, ends, stiffness, length):
    """Return the force (rows, columns, 3) [N] of springs that would have that length."""
    between = at[ends[1]] - at[ends[0]]
    distance = np.maximum(np.linalg.norm(between, axis=-1), 1e-12)
    tension = stiffness * (1.0 - length / distance)
    return _spread(ends, tension[..., None] * between, -1.0, at.shape)


def _with_momentum(old, positions, velocities, new, at, v, origin):
    """
    Return velocities v with the momentum of the old grid, linear and about the origin.

    Free nodes but corners are given the motion of a rigid body, the least that does it.
    """
    mesh = new.mesh
    moves = mesh.grid(mesh.free).copy()
    moves[[0, 0, -1, -1], [0, -1, 0, -1]] = 0.0
    weight = moves * mesh.grid(new.mass)
    missing = (_momentum(old, positions - origin, velocities)
               - _momentum(new, at - origin, v))
    system = np.empty((6, 6))
    rigid = []
    for axis in range(6):
        unit = np.zeros(3)
        unit[axis % 3] = 1.0
        field = np.broadcast_to(unit, at.shape) if axis < 3 else np.cross(unit, at - origin)
        rigid.append(field * moves[..., None])
        system[:, axis] = _momentum(new, at - origin, rigid[axis])
    # Fewer than three free nodes in general place cannot have every motion: the nearest then.
    amounts = np.linalg.lstsq(system, missing, rcond=1e-9)[0] if weight.any() else np.zeros(6)
    return v + sum(amount * field for amount, field in zip(amounts, rigid))


def _momentum(model, places, velocities):
    """Return the momentum [kg m/s] and that about the places' origin [kg m2/s]: (6,)."""
    carried = model.mesh.grid(model.mass)[..., None] * velocities
    return np.concatenate([carried.sum((0, 1)), np.cross(places, carried).sum((0, 1))])
