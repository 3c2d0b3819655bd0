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

"""The same equations in Taichi on the CPU: loops over fields, each node gathers its forces."""
from peers_cloth.case import Sheet

import taichi as ti


@ti.data_oriented
class Peer:
    """One kernel a step, a loop after the other in it; Python calls it, as in Taichi's example."""

    precision = 'float64'

    def __init__(self, case):
        ti.init(arch=ti.cpu, default_fp=ti.f64, cpu_max_num_threads=1, offline_cache=False)
        sheet = self._sheet = Sheet(case)
        self.dt, self.wind = case.dt, ti.Vector(case.wind)
        self.rows, self.columns = rows, columns = case.rows, case.columns
        # Every spring from both of its ends.
        self.springs = sheet.springs + [((-row, -column), *numbers)
                                        for (row, column), *numbers in sheet.springs]
        self.x = ti.Vector.field(3, ti.f64, (rows, columns))
        self.v = ti.Vector.field(3, ti.f64, (rows, columns))
        self.force = ti.Vector.field(3, ti.f64, (rows, columns))
        # Forces on faces and, of bending, moments at nodes.
        self.upper = ti.Vector.field(3, ti.f64, (rows - 1, columns - 1))
        self.lower = ti.Vector.field(3, ti.f64, (rows - 1, columns - 1))
        self.across, self.down, self.twist = (
            ti.Vector.field(3, ti.f64, (rows, columns)) for _ in range(3))
        self.mass = ti.field(ti.f64, (rows, columns))
        self.x.from_numpy(sheet.positions)
        self.mass.from_numpy(sheet.mass)

    def run(self, steps):
        for _ in range(steps):
            self._step()
        ti.sync()

    @ti.func
    def _wind_on(self, i, j, k):
        area = 0.5 * (self.x[j] - self.x[i]).cross(self.x[k] - self.x[i])
        flux = (self.wind - 0.5 * self.v[i] - 0.25 * (self.v[j] + self.v[k])).dot(area)
        speed = ti.abs(flux)
        return area * (self._sheet.drag * speed * flux
                       / (area.dot(area) * (1.0 + self._sheet.hold * speed)))

    @ti.kernel
    def _step(self):
        # The wind on the faces.
        for row, column in self.upper:
            i, e = ti.Vector([row, column]), ti.Vector([row, column + 1])
            s, d = ti.Vector([row + 1, column]), ti.Vector([row + 1, column + 1])
            self.upper[row, column] = self._wind_on(i, e, s)
            self.lower[row, column] = self._wind_on(d, s, e)
        # Each node's springs and faces.
        for i in ti.grouped(self.x):
            row, column = i[0], i[1]
            at_edge = row == 0 or row == self.rows - 1
            at_end = column == 0 or column == self.columns - 1
            force = ti.Vector([0.0, 0.0, -self._sheet.gravity * self.mass[i]])
            for offset, k, c, rest in ti.static(self.springs):
                j = i + ti.Vector(offset)
                if 0 <= j[0] < self.rows and 0 <= j[1] < self.columns:
                    share = 1.0
                    if ti.static(offset[0] == 0):
                        share = 0.5 if at_edge else 1.0
                    if ti.static(offset[1] == 0):
                        share = 0.5 if at_end else 1.0
                    along = self.x[j] - self.x[i]
                    length = along.norm()
                    along /= length
                    rate = along.dot(self.v[j] - self.v[i])
                    force += share * (k * (length - rest) + c * rate) * along
            if row < self.rows - 1 and column < self.columns - 1:
                force += 0.5 * self.upper[i]
            if row > 0 and column > 0:
                force += 0.5 * self.lower[row - 1, column - 1]
            if row < self.rows - 1 and column > 0:
                force += 0.25 * (self.upper[row, column - 1] + self.lower[row, column - 1])
            if row > 0 and column < self.columns - 1:
                force += 0.25 * (self.upper[row - 1, column] + self.lower[row - 1, column])
            self.force[i] = force
        if ti.static(self._sheet.bend_stiffness > 0.0):
            b_across, b_down, b_twist = ti.static(self._sheet.bend)
            x = ti.static(self.x)
            for row, column in x:
                i = ti.Vector([row, column])
                if 0 < column < self.columns - 1:
                    share = 0.5 if row == 0 or row == self.rows - 1 else 1.0
                    self.across[i] = share * b_across * (x[row, column - 1] - 2.0 * x[i]
                                                         + x[row, column + 1])
                if 0 < row < self.rows - 1:
                    share = 0.5 if column == 0 or column == self.columns - 1 else 1.0
                    self.down[i] = share * b_down * (x[row - 1, column] - 2.0 * x[i]
                                                     + x[row + 1, column])
                if row < self.rows - 1 and column < self.columns - 1:
                    self.twist[i] = b_twist * (x[i] - x[row, column + 1] - x[row + 1, column]
                                               + x[row + 1, column + 1])
            across, down, twist = ti.static(self.across, self.down, self.twist)
            for row, column in self.x:
                # Where no moment was set it is zero.
                force = twist[row, column] - 2.0 * (across[row, column] + down[row, column])
                if row > 0:
                    force += down[row - 1, column] - twist[row - 1, column]
                if row < self.rows - 1:
                    force += down[row + 1, column]
                if column > 0:
                    force += across[row, column - 1] - twist[row, column - 1]
                if column < self.columns - 1:
                    force += across[row, column + 1]
                if row > 0 and column > 0:
                    force += twist[row - 1, column - 1]
                self.force[row, column] -= force
        for i in ti.grouped(self.x):
            if i[1] > 0:
                self.v[i] += self.dt / self.mass[i] * self.force[i]
                self.x[i] += self.dt * self.v[i]

    def state(self):
        return self.x.to_numpy(), self.v.to_numpy()
