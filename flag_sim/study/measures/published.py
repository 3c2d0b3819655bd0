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
"""What is published of real flags: bands for one of some size and mass, and their sources."""
import math
from typing import NamedTuple

from flag_sim.cloth import Cloth
from flag_sim.parameters import checks

WAVES_ON_FLAG = 1.87  # wavelength by the flag's length (Raynaud and Mulleners)
MASS_RATIO = 0.074  # at which a swing of 0.2 of the length is derived


class Band(NamedTuple):
    """The least and the greatest value that agree with what is published."""

    low: float
    high: float

    def side(self, value: float) -> int:
        """Return -1 for a value below the band, 0 within it, 1 above it."""
        return (value > self.high) - (value < self.low)

    def __str__(self) -> str:
        """Return both ends, to two digits."""
        return f'{self.low:.2g} to {self.high:.2g}'


class Flag(NamedTuple):
    """What the bands depend on: sizes [m], mass per area [kg/m2], air [kg/m3], gravity [m/s2]."""

    length: float
    width: float
    area_density: float
    air_density: float
    gravity: float

    @classmethod
    def of(cls, cloth: Cloth) -> 'Flag':
        """Return the Flag of a cloth; raises ValueError where the wind does not press on it."""
        if cloth.air.drag == 0.0:
            raise ValueError('air.density and air.drag_coefficient must be above zero: without '
                             'the force of the wind no flag flies')
        return cls(cloth.mesh.length, cloth.mesh.width, cloth.material.area_density,
                   checks.finite('air.density', cloth.air.density, above=0.0), cloth.gravity)

    @property
    def mass_ratio(self) -> float:
        """Return M* = m / (rho L), the cloth's mass by that of the air around it."""
        return self.area_density / (self.air_density * self.length)


WAVE_SPEED = Band(0.6, 1.0)
"""Speed of the waves, by the wind's: "close to the incoming flow", lower for narrow flags."""
STROUHAL = Band(WAVE_SPEED.low / WAVES_ON_FLAG, WAVE_SPEED.high / WAVES_ON_FLAG)
"""Frequency f L / U, of one wave of 1.87 L that travels at such a speed."""
LIGHTER = Band(0.8, 1.0)
"""Frequency of a flag half as heavy, by this one's: slightly lower, if the flag is light."""
EXPONENT = Band(1.8, 2.0)
"""The power of the wind that drag grows with."""


def swing(flag: Flag) -> Band:
    """Return how far the free edge swings from side to side, by the length."""
    size = 0.2 * math.sqrt(flag.mass_ratio / MASS_RATIO)
    return Band(0.6 * size, 1.4 * size)


def fluttering(flag: Flag) -> float:
    """Return the part of the drag coefficient that grows with mass in AS 1170.2 and Eurocode."""
    aspect = flag.length / flag.width
    return 0.7 * flag.area_density / (flag.air_density * flag.width) * aspect**-1.25


def drag(flag: Flag) -> Band:
    """
    Return the drag coefficient, of rho U^2 L H / 2.

    From Eurocode's to the higher one of AS 1170.2 and Fairthorne's measurements and their scatter,
    0.06 at L = H and 0.12 at 2 H.
    """
    measured = 0.06 * flag.length / flag.width
    return Band(0.02 + fluttering(flag), max(0.05 + fluttering(flag), 1.3 * measured))


def level_wind(flag: Flag) -> Band | None:
    """
    Return the wind [m/s] from which on a flag is level, without lift; None in no gravity.

    A membrane is held up by its tension alone, and so by its drag: that must be L / H times the
    weight, with the coefficient 0.09. Oblique waves lift a flag, which extends earlier.
    """
    if flag.gravity == 0.0:
        return None
    coefficient = 0.09
    speed = math.sqrt(2.0 * flag.length / flag.width * flag.area_density * flag.gravity
                      / (flag.air_density * coefficient))
    return Band(0.65 * speed, 1.2 * speed)


SOURCES = {
    'flaps': 'Argentina and Mahadevan 2005, abstract: beyond an onset, far below these winds',
    'frequency': 'derived from the wavelength 1.87 L of Raynaud and Mulleners 2026, '
                 'arXiv 2602.06237, abstract, and the wave speed',
    'wave speed': 'Raynaud and Mulleners 2026; Alben 2021, arXiv 2106.14988, abstracts',
    'lighter': 'Alben 2021, abstract',
    'swing': 'root of mass: Alben 2021, abstract; its size is derived from the frequency',
    'drag': 'Eurocode 1-4, 7.12 (not seen); AS 1170.2, F (as engineers quote it); '
            'Fairthorne, ARC R&M 1345, in Hoerner 3-25 (as engineers quote it)',
    'exponent': 'wind tunnel of the US Navy, V^1.9 (as engineers quote it); drag codes, 2',
    'level': 'statics; light flags extend at Beaufort 3',
}
"""Where each band is from, and how far that was seen."""
