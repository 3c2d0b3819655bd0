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
The chaotic part of the motion, which only statistics can compare: kinetic energy over 10 s.

Flags that begin a millimetre apart are nowhere alike after a second, whatever the method. So each
method flies the same few flags, and their mean is compared with that of a reference in much
smaller steps. A mean over so few flags is known to its standard error, which the reference's own
spread tells: the tolerance is 5 %, or two standard errors where that is more.
"""
import functools
import math

from flag_sim.cloth import Cloth, Stepping
from flag_sim.cloth.energy import kinetic_energy
import numpy as np
import pytest
from support.cloths import model_of
from support.soak import SOAK

WIND = (6.0, 2.0, 0.0)
REFERENCE = ('verlet', 0.2)
"""Method and step_safety: a step of second order, 4.5 times as short as by default."""


@functools.lru_cache
def mean_kinetic_energies(solver, step_safety, grid, flags):
    """Return the mean kinetic energy [J] of each of so many flags in their first 10 s of wind."""
    means = []
    for seed in range(flags):
        cloth = Cloth(*grid, solver=solver, stepping=Stepping(step_safety=step_safety))
        start = cloth.positions
        start[:, 1:] += 1e-3 * np.random.default_rng(seed).normal(size=start[:, 1:].shape)
        cloth.place(start)
        model = model_of(cloth)
        energies = []
        for _ in range(300):
            assert cloth.advance(1.0 / 30.0, WIND).stiffness_factor == 1.0
            energies.append(kinetic_energy(model, cloth.velocities))
        means.append(np.mean(energies))
    return np.array(means)


@pytest.mark.parametrize('solver', ['symplectic', 'verlet', 'rk4'])
@pytest.mark.parametrize('grid, flags', [
    ((11, 16), 6),
    pytest.param((21, 31), 12, marks=pytest.mark.skipif(not SOAK, reason='left to make soak'))])
def test_mean_kinetic_energy_is_that_of_a_reference(solver, grid, flags, record_property):
    """Within 5 % or two standard errors, whichever is more; the report says which."""
    reference = mean_kinetic_energies(*REFERENCE, grid, flags)
    found = mean_kinetic_energies(solver, 0.9, grid, flags)
    error = found.mean() / reference.mean() - 1.0
    noise = 2.0 * reference.std(ddof=1) / math.sqrt(flags) / reference.mean()
    report = (f'{solver}, {grid[1]} x {grid[0]}, {flags} flags: {found.mean():.3f} J, '
              f'{100 * error:+.1f} % of {reference.mean():.3f} J; tolerance '
              + (f'two standard errors, {100 * noise:.1f} %' if noise > 0.05 else
                 f'5 % (two standard errors: {100 * noise:.1f} %)'))
    record_property('mean kinetic energy', report)
    print(report)
    assert abs(error) < max(0.05, noise), report
