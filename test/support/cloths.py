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

"""Cloths in simple places, and the numbers that theory speaks of."""
import math

from flag_sim.cloth import Cloth, Stepping
from flag_sim.cloth.energy import bending_energy, elastic_energy, kinetic_energy
from flag_sim.cloth.model import Model
from flag_sim.cloth.stability import frequency_bound
import numpy as np

SMALL_STEPS = {
    'xpbd': 0.1,    # one sweep is backward Euler only where springs do not feel one another
    'euler': 0.05,  # or its growth of the shortest waves drowns the one that is looked at
}
"""Steps times the highest frequency, for methods that are not tried at their largest step."""

SAMPLES = 5
"""Frames that a mode is let ring for."""

WIND = (5.0, 2.0, 0.5)
"""In which `running` cloths fly [m/s]."""


def running(frames=10, **parameters):
    """Return a small cloth that has been in the wind for some frames."""
    cloth = Cloth(9, 13, **parameters)
    for _ in range(frames):
        cloth.advance(0.02, WIND)
    return cloth


def _symplectic(z):
    """Solve l^2 - (2 - z^2) l + 1 = 0, which is sin(omega' dt / 2) = omega dt / 2."""
    return 1.0 - 0.5 * z**2 + 1j * z * np.sqrt(1.0 - 0.25 * z**2)


FACTORS = {
    'symplectic': _symplectic, 'verlet': _symplectic, 'seed': _symplectic,
    'rk4': lambda z: sum((1j * z)**n / math.factorial(n) for n in range(5)),
    'euler': lambda z: 1.0 + 1j * z,
    'xpbd': lambda z: 1.0 / (1.0 - 1j * z),
    'implicit': lambda z: 1.0 / (1.0 - 1j * z),
}
"""By what a step multiplies an undamped mode, given z = omega dt."""


def flat(*arguments, **options):
    """Return a cloth that starts exactly flat, where theory begins."""
    return Cloth(*arguments, start_noise=0.0, **options)


def hanging(cloth):
    """Return positions that let the cloth hang down from its hoist: columns become heights."""
    flat = cloth.positions - cloth.hoist_top
    return np.stack([-flat[..., 2], flat[..., 1], -flat[..., 0]], axis=-1) + cloth.hoist_top


def model_of(cloth):
    """Return the mesh and material of a cloth, neither softened."""
    return Model(cloth.mesh, cloth.material)


def highest_frequency(cloth):
    """Return the bound of the cloth's angular frequencies [rad/s]."""
    return frequency_bound(model_of(cloth))


def potential_energy(model, positions, gravity):
    """Return the energy [J] of height above z = 0 in gravity [m/s2] (eq. 1.1)."""
    return gravity * float(np.sum(model.mesh.grid(model.mass) * positions[..., 2]))


def energy(cloth, gravity):
    """Return all the energy that the cloth has [J]."""
    model = model_of(cloth)
    return (kinetic_energy(model, cloth.velocities) + elastic_energy(model, cloth.positions)
            + bending_energy(model, cloth.positions)
            + potential_energy(model, cloth.positions, gravity))


def ring(cloth, shape, omega, count=None):
    """
    Let a mode ring; return what a frame multiplies it by, and the steps of a frame with their z.

    shape: (rows, columns, 3) of the mode, in which the cloth has been placed; weighed by the mass
    it is orthogonal to all other modes. count: steps of a frame, 0 for the method's own; by
    default as SMALL_STEPS says. A mode's samples obey y'' = a y' + b y, whose roots are the factor
    and its conjugate.
    """
    frame = 1.5 / omega
    small = SMALL_STEPS.get(cloth.solver)
    if count is None:
        count = math.ceil(frame * highest_frequency(cloth) / small) if small else 0
    cloth.stepping = Stepping(substeps=count, substeps_limit=count or 10**5)
    start = cloth.positions
    weighed = shape * cloth.mesh.grid(cloth.mesh.mass_share)[..., None]
    rest = np.sum(weighed * start) - np.sum(weighed * shape)
    amplitudes = [1.0]
    for _ in range(SAMPLES):
        steps = cloth.advance(frame)
        amplitudes.append((np.sum(weighed * cloth.positions) - rest) / np.sum(weighed * shape))
    y = np.array(amplitudes)
    a, b = np.linalg.lstsq(np.stack([y[1:-1], y[:-2]], axis=1), y[2:], rcond=None)[0]
    return 0.5 * a + 1j * math.sqrt(-b - 0.25 * a**2), steps.granted, omega * frame / steps.granted
