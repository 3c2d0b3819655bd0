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
Gusts: turbulence with the Dryden spectrum, as a function of the way that the wind has gone.

Along the mean wind, and across it, the one-sided spectra over the wavenumber W [rad/m] are

    S_u = sigma^2 (2 L / pi) / (1 + (L W)^2)
    S_v = sigma^2 (L / pi) (1 + 3 (L W)^2) / (1 + (L W)^2)^2

(MIL-F-8785C, 3.7.1.2). By Taylor's hypothesis the air carries its eddies along unchanged, so at a
point they are met at W times the distance that has passed. The series is a sum of cosines with
random phases (Shinozuka and Jan, 1972), all of one amplitude: the wavenumbers lie where the
spectrum's integral takes equal steps, so the variance is sigma^2 exactly. A sum has no memory:
it is the same at a given distance whatever the frame rate, and after any jump.
"""
from flag_sim.animation.wind_settings import WindSettings
from flag_sim.parameters import checks
from flag_sim.parameters.closed import constant
import numpy as np

TURN = 2.0 * np.pi


def _quantiles_along(fraction):
    """Return L W below which the given fraction of the variance of S_u lies."""
    return np.tan(0.5 * np.pi * fraction)


def _quantiles_across(fraction):
    """Return L W below which the given fraction of the variance of S_v lies: by table."""
    x = np.concatenate([[0.0], np.geomspace(1e-6, 1e9, 20001)])
    return np.interp(fraction, (2.0 * np.arctan(x) - x / (1.0 + x * x)) / np.pi, x)


@constant
class Gusts:
    """
    Turbulence of unit intensity: u along the mean wind, v across it, w upwards.

    length: the eddies' scale L [m]; seed: of the random phases, which leave the statistics alike.
    Raises ValueError for values that WindSettings refuses.
    """

    COMPONENTS = 256

    def __init__(self, length: float, seed: int):
        length = WindSettings.accepted('gust_length', length, 'length')
        source = np.random.default_rng(WindSettings.accepted('gust_seed', seed, 'seed'))
        steps = np.arange(self.COMPONENTS)
        waves = []
        for quantiles in (_quantiles_along, _quantiles_across, _quantiles_across):
            # Somewhere in each step, so that the sum does not repeat itself.
            fractions = (steps + source.random(self.COMPONENTS)) / self.COMPONENTS
            waves.append(quantiles(fractions) / length)
        self._waves = np.array(waves)
        self._phases = source.uniform(0.0, TURN, self._waves.shape)

    def at(self, distance: float) -> np.ndarray:
        """Return (u, v, w), (3,), each of variance 1, after the wind has gone `distance` [m]."""
        distance = checks.finite('distance', distance, -checks.LARGEST * checks.LARGEST,
                                 checks.LARGEST * checks.LARGEST)
        amplitude = np.sqrt(2.0 / self.COMPONENTS)
        return amplitude * np.cos(self._waves * distance + self._phases).sum(axis=1)
