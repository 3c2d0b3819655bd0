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

"""The cloth that parameters make, moved from frame to frame while they change."""
from collections.abc import Callable, Mapping
import math

from flag_sim.cloth import Air, energy
from flag_sim.cloth.divergence import Diverged
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.pole_load import pole_load, PoleLoad
from flag_sim.cloth.simulation import Cloth
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.strain import greatest_strain
from flag_sim.declarations.factories import (
    air_of, cloth_of, hang_of, material_of, pole_of, pose_of, stepping_of)
from flag_sim.declarations.kernel_choice import KernelChoice
from flag_sim.declarations.step_report import is_softened, StepReport
from flag_sim.protocol.throttled_log import Entry
import numpy as np

PREROLL_FRAME = 1.0 / 30.0
"""Longest piece of a pre-roll [s], an ordinary frame: `substeps_limit` goes by the frame."""


def _moves_air(values):
    """Return whether kernels with the inertia of the air are needed; not where it is refused."""
    return values['air.added_mass'] > 0.0 and SOLVERS[values['solver']].moves_air


def kernels_of(values: Mapping) -> str:
    """Return in words what the kernels are compiled for."""
    moving = ' with moving air' if _moves_air(values) else ''
    return f'solver {values["solver"]} in {values["precision"]}{moving}'


def warm_up(values: Mapping) -> None:
    """
    Compile or load the kernels before the first frame that needs them.

    Those of one solver and precision only: all would take more memory and a minute more.
    """
    cloth = Cloth(3, 3, pole=(0.0, 0.0, 0.01), solver=values['solver'],
                  precision=values['precision'], air=Air(added_mass=float(_moves_air(values))))
    cloth.advance(1e-3)
    cloth.normals()


CLOTH_KERNELS = KernelChoice(('solver', 'precision', 'air.added_mass'), kernels_of, warm_up)


class MovingCloth:
    """
    A cloth, frame after frame, by the physics node's parameters {name: value}.

    A frame's wind and values apply to the whole time from the previous frame to it (a zero-order
    hold), in which the pole goes to where this frame has it. A cloth that starts over, at a
    restart or when its size changes, first moves for `preroll` seconds in its first frame's wind,
    on a pole that stands where that frame has it.

    values: those of the last frame. time: of the last frame [ns], None before any. gap: the time
    before the last frame that was not simulated, as it was longer than max_gap [s]; else 0.
    divergence: why the last frame could not be simulated, or ''.
    """

    def __init__(self, values: Mapping):
        self.values = dict(values)
        self.time: int | None = None
        self.gap = 0.0
        self.divergence = ''
        self._cloth = cloth_of(values)
        self._is_new = True  # whether the cloth was just laid out, and has not moved since
        self._plan = None    # of the last frame's steps
        self._report = StepReport()

    @property
    def positions(self) -> np.ndarray:
        """Return a copy of the nodes' positions: (rows, columns, 3) float64 [m]."""
        return self._cloth.positions

    @property
    def velocities(self) -> np.ndarray:
        """Return a copy of the nodes' velocities: (rows, columns, 3) float64 [m/s]."""
        return self._cloth.velocities

    def normals(self) -> np.ndarray:
        """Return the nodes' unit normals: (rows, columns, 3)."""
        return self._cloth.normals()

    def pole_load(self, wind) -> PoleLoad:
        """Return what the flag does to its pole at the last frame, in that frame's wind (3,)."""
        return pole_load(self._cloth, wind)

    def restart(self) -> None:
        """Lay the cloth out again."""
        self._cloth.reset()
        self._is_new = True
        self.time = None
        self.divergence = ''

    def advance_to(self, stamp: int, wind, values: Mapping,
                   goes_on: Callable[[], bool] = lambda: True) -> list[Entry]:
        """
        Move the cloth to a frame's time `stamp` [ns]; return what there is to log.

        wind: (3,) [m/s]. A stamp before that of the last frame restarts it. goes_on(): asked
        between the pieces of a pre-roll, which ends where it returns False.
        """
        if self.time is not None and stamp < self.time:
            self.restart()
        if values != self.values:
            self._configure(values)
        entries = []
        if self._is_new:
            self._cloth.pose = pose_of(values)
            entries += self._roll(values['preroll'], wind, goes_on)
        dt = 0.0 if self.time is None else (stamp - self.time) * 1e-9
        self.gap = dt if dt > values['max_gap'] else 0.0
        if 0.0 < dt and not self.gap:
            entries += self._move(dt, wind)
        elif dt:
            self._cloth.pose = pose_of(values)
        self.time = stamp
        return entries

    def _configure(self, values):
        """Bring the cloth to this frame's values; only another size starts it anew."""
        before, self.values = self.values, dict(values)
        self._cloth.start_noise = values['start_noise']
        self._cloth.start_seed = values['start_seed']
        if hang_of(values) != hang_of(before):
            self._cloth.pole = None  # the hoist may be where the old one stood
            self._cloth.hang(*hang_of(values))
            self._is_new = True
        grid = values['grid.rows'], values['grid.columns']
        if grid != (before['grid.rows'], before['grid.columns']):
            self._cloth.regrid(*grid)
        self._cloth.material = material_of(values)
        self._cloth.gravity = values['gravity']
        self._cloth.stepping = stepping_of(values)
        self._cloth.air = VACUUM  # the old solver may not take the new air, nor the new the old
        self._cloth.solver = values['solver']
        self._cloth.air = air_of(values)
        self._cloth.stretch_limit = values['stretch_limit']
        self._cloth.pole = pole_of(values)
        self._cloth.precision = values['precision']

    def _roll(self, seconds, wind, goes_on):
        """Move a cloth that was just laid out for so long in a steady wind."""
        self._is_new = False
        entries = []
        pieces = math.ceil(seconds / PREROLL_FRAME)
        for _ in range(pieces):
            if not goes_on():
                break
            entries += self._move(seconds / pieces, wind)
        return entries

    def _move(self, dt, wind):
        """Move the cloth by dt [s]; return what there is to log."""
        try:
            self._plan = self._cloth.advance(dt, wind, pose_of(self.values))
        except Diverged as error:
            self.divergence = str(error)
            self._cloth.pose = pose_of(self.values)  # the flag stays on its pole
            return []
        self.divergence = ''
        return self._report.update(self._plan, self._cloth.held, self.values, dt,
                                   self._cloth.is_carried)

    def softness(self) -> str:
        """Return in words how the last frame's cloth was not as it is set, or ''."""
        held = self._cloth.held
        return ' and '.join(
            ['the cloth is softer than it is set'] * (
                self._plan is not None and is_softened(self._plan))
            + [f'{held} nodes are held back by stretch_limit'] * bool(held)
            + ['the pole is too fast for the cloth to follow'] * self._cloth.is_carried)

    def figures(self) -> dict[str, float]:
        """Return {name with unit: number} of the cloth and of the last frame's steps."""
        model, positions = self._cloth.model, self._cloth.positions
        figures = {
            'kinetic energy [J]': energy.kinetic_energy(model, self._cloth.velocities),
            'elastic energy [J]': (energy.elastic_energy(model, positions)
                                   + energy.bending_energy(model, positions)),
            'greatest strain': greatest_strain(model.mesh, positions),
            'nodes held by stretch_limit': self._cloth.held}
        if self._plan is not None:
            demanded, granted, stiffness, damping = self._plan
            figures |= {'steps demanded': demanded, 'steps granted': granted,
                        'stiffness factor': stiffness, 'damping factor': damping}
        return figures
