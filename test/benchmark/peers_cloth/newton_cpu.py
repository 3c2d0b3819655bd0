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
Newton's SolverSemiImplicit on the CPU, float32.

As in Newton's own examples the steps are captured once and replayed. Newton's air knows no wind,
so a Warp kernel adds it to the particles' forces, which Newton leaves to its users.
"""
import newton
import numpy as np

from peers_cloth.case import Sheet

import warp as wp

STEPS = 20
"""Steps in a captured graph; even, so that it ends in the state that it began in."""


@wp.kernel
def push(x: wp.array[wp.vec3], v: wp.array[wp.vec3], triangles: wp.array[wp.vec3i],
         wind: wp.vec3, drag: float, hold: float, force: wp.array[wp.vec3]):
    """Add the wind's force [N] on each face to its corners."""
    corners = triangles[wp.tid()]
    i, j, k = corners[0], corners[1], corners[2]
    area = 0.5 * wp.cross(x[j] - x[i], x[k] - x[i])
    flux = wp.dot(wind - 0.5 * v[i] - 0.25 * (v[j] + v[k]), area)
    speed = wp.abs(flux)
    f = area * (drag * speed * flux / (wp.dot(area, area) * (1.0 + hold * speed)))
    wp.atomic_add(force, i, 0.5 * f)
    wp.atomic_add(force, j, 0.25 * f)
    wp.atomic_add(force, k, 0.25 * f)


def add_springs(builder, sheet):
    """Add the membrane as springs, the same as ours."""
    index = np.arange(sheet.mass.size).reshape(sheet.mass.shape)
    rows, columns = index.shape
    for (row, column), k, c, _ in sheet.springs:
        share = (sheet.share_across if row == 0 else sheet.share_down if column == 0
                 else np.ones((1, 1)))
        begins = index[:rows - row, max(-column, 0):columns - max(column, 0)]
        ends = index[row:, max(column, 0):columns - max(-column, 0)]
        for i, j, part in np.broadcast(begins, ends, share):
            builder.add_spring(int(i), int(j), ke=k * part, kd=c * part, control=0.0)


def add_triangles(builder, sheet):
    """
    Add the membrane as Newton's triangles: C11 = ke + ka, C12 = ka - ke, C66 = ke at small strain.

    Their damping also brakes turning, which dashpots along springs do not.
    """
    corners = sheet.triangles()

    def every(value):
        return [value] * len(corners)

    damping = sheet.springs[-1][2]
    builder.add_triangles(*corners.T, tri_ke=every(sheet.shear_stiffness),
                          tri_ka=every(sheet.stiffness), tri_kd=every(damping),
                          tri_drag=every(0.0), tri_lift=every(0.0))
    if sheet.bend_stiffness > 0.0:
        add_hinges(builder, sheet)


def add_hinges(builder, sheet):
    """
    Add the edges between triangles, which bend as a plate of our stiffness does along the grid.

    A moment of B theta on an edge is a force of B theta / dx on the corner that faces it, which
    Newton writes as ke theta (edge's length)^2.
    """
    index = np.arange(sheet.mass.size).reshape(sheet.mass.shape)
    # The two corners that face the edge, then its two ends: within cells, between them along the
    # rows, between them down the columns.
    hinges = np.concatenate([
        np.stack(corners, axis=-1).reshape(-1, 4) for corners in (
            (index[:-1, :-1], index[1:, 1:], index[:-1, 1:], index[1:, :-1]),
            (index[1:, :-2], index[:-1, 2:], index[:-1, 1:-1], index[1:, 1:-1]),
            (index[:-2, 1:], index[2:, :-1], index[1:-1, 1:], index[1:-1, :-1]))])
    stiffness = sheet.bend_stiffness / sheet.dx**3
    builder.add_edges(*hinges.T, edge_ke=[stiffness] * len(hinges), edge_kd=[0.0] * len(hinges))


class Peer:
    """membrane: 'springs' or 'triangles'."""

    precision = 'float32'

    def __init__(self, case, membrane):
        wp.set_device('cpu')
        sheet = self._sheet = Sheet(case)
        builder = newton.ModelBuilder()
        positions = sheet.positions.reshape(-1, 3)
        mass = sheet.mass.copy()
        mass[:, 0] = 0.0  # Newton's way to pin particles
        builder.add_particles(positions.tolist(), [(0.0, 0.0, 0.0)] * len(positions),
                              mass.ravel().tolist())
        {'springs': add_springs, 'triangles': add_triangles}[membrane](builder, sheet)
        model = builder.finalize()
        model.set_gravity((0.0, 0.0, -sheet.gravity))
        model.particle_grid = None  # no collisions between particles
        self._solver = newton.solvers.SolverSemiImplicit(model, enable_tri_contact=False)
        self._control = model.control()
        self._states = model.state(), model.state()
        self._triangles = wp.array(sheet.triangles(), dtype=wp.vec3i)
        self._wind, self._dt = wp.vec3(*case.wind), case.dt
        self._take_steps()  # compiles
        for state in self._states:
            state.assign(model.state())
        with wp.ScopedCapture() as capture:
            self._take_steps()
        self._graph = capture.graph

    def _take_steps(self):
        now, then = self._states
        for _ in range(STEPS):
            now.clear_forces()
            wp.launch(push, dim=len(self._triangles), inputs=[
                now.particle_q, now.particle_qd, self._triangles, self._wind,
                self._sheet.drag, self._sheet.hold], outputs=[now.particle_f])
            self._solver.step(now, then, self._control, None, self._dt)
            now, then = then, now

    def run(self, steps):
        for _ in range(steps // STEPS):
            wp.capture_launch(self._graph)

    def state(self):
        shape = (*self._sheet.mass.shape, 3)
        now = self._states[0]
        return now.particle_q.numpy().reshape(shape), now.particle_qd.numpy().reshape(shape)
