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

"""The same equations in numpy: whole grids at a time, neighbours by slices."""
import numpy as np

from peers_cloth.case import Sheet

ALL, LOW, HIGH = slice(None), slice(None, -1), slice(1, None)
# The corners of all cells: upper and lower on the hoist's side (I, S), and away from it (E, D).
I, E, S, D = (ALL, LOW, LOW), (ALL, LOW, HIGH), (ALL, HIGH, LOW), (ALL, HIGH, HIGH)


def dot(a, b):
    """Return the product of vectors (3, rows, columns)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    """Return the vector product of vectors (3, rows, columns)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                     a[0] * b[1] - a[1] * b[0]])


def add_wind(force, x, v, wind, drag, hold):
    """Add to force (3, rows, columns) [N] the wind's on all faces; see Sheet for drag and hold."""
    for i, j, k in ((I, E, S), (D, S, E)):
        area = 0.5 * cross(x[j] - x[i], x[k] - x[i])
        flux = dot(wind - 0.5 * v[i] - 0.25 * (v[j] + v[k]), area)
        speed = np.abs(flux)
        push = area * (drag * speed * flux / (dot(area, area) * (1.0 + hold * speed)))
        force[i] += 0.5 * push
        push *= 0.25
        force[j] += push
        force[k] += push


class Peer:
    """Arrays (3, rows, columns), so that every operation runs over memory in order."""

    precision = 'float64'

    def __init__(self, case):
        sheet = self._sheet = Sheet(case)
        self._dt = case.dt
        self._wind = np.array(case.wind)[:, None, None]
        self._x = np.moveaxis(sheet.positions, -1, 0).copy()
        self._v = np.zeros_like(self._x)
        self._weight = np.zeros_like(self._x)
        self._weight[2] = -sheet.gravity * sheet.mass
        self._inverse_mass = 1.0 / sheet.mass
        self._inverse_mass[:, 0] = 0.0
        across, down, falling, rising = (numbers for _, *numbers in sheet.springs)
        self._springs = [
            ((ALL, ALL, LOW), (ALL, ALL, HIGH), *across, sheet.share_across),
            ((ALL, LOW, ALL), (ALL, HIGH, ALL), *down, sheet.share_down),
            (I, D, *falling, 1.0), (E, S, *rising, 1.0)]

    def run(self, steps):
        for _ in range(steps):
            self._step()

    def _step(self):
        x, v, sheet = self._x, self._v, self._sheet
        force = self._weight.copy()
        for a, b, k, c, rest, share in self._springs:
            along = x[b] - x[a]
            length2 = dot(along, along)
            along *= share * (k - k * rest / np.sqrt(length2)
                              + c * dot(along, v[b] - v[a]) / length2)
            force[a] += along
            force[b] -= along
        add_wind(force, x, v, self._wind, sheet.drag, sheet.hold)
        if sheet.bend_stiffness > 0.0:
            self._bend(force)
        v += force * (self._dt * self._inverse_mass)
        x += self._dt * v

    def _bend(self, force):
        x, sheet = self._x, self._sheet
        across, down, twist = sheet.bend
        moment = across * sheet.share_across * (x[:, :, 2:] - 2.0 * x[:, :, 1:-1] + x[:, :, :-2])
        force[:, :, 2:] -= moment
        force[:, :, :-2] -= moment
        force[:, :, 1:-1] += 2.0 * moment
        moment = down * sheet.share_down * (x[:, 2:] - 2.0 * x[:, 1:-1] + x[:, :-2])
        force[:, 2:] -= moment
        force[:, :-2] -= moment
        force[:, 1:-1] += 2.0 * moment
        moment = twist * (x[I] - x[E] - x[S] + x[D])
        force[I] -= moment
        force[D] -= moment
        force[E] += moment
        force[S] += moment

    def state(self):
        return np.moveaxis(self._x, 0, -1), np.moveaxis(self._v, 0, -1)
