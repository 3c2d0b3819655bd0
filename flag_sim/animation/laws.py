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

"""Laws of motion between two neighbouring keys: how a value goes from one to the next."""
import numpy as np


def step(fraction, before, after):
    """Hold the earlier key's value until the later key."""
    del fraction, after
    return before


def linear(fraction, before, after):
    """Go from one value to the next at constant speed; `fraction` of the way, in [0, 1)."""
    return before + (after - before) * fraction


def ease(fraction, before, after):
    """Start and arrive at rest: the smoothstep 3 f^2 - 2 f^3."""
    return linear(fraction * fraction * (3.0 - 2.0 * fraction), before, after)


def cubic(fraction, before, after, slope_before, slope_after):
    """
    Go along the cubic Hermite curve with the given slopes, in values per segment.

    With the slopes of `monotone_slopes` it never overshoots the keys.
    """
    f, g = fraction, 1.0 - fraction
    return (before * (1.0 + 2.0 * f) * g * g + after * (3.0 - 2.0 * f) * f * f
            + slope_before * f * g * g - slope_after * f * f * g)


LAWS = {'step': step, 'linear': linear, 'ease': ease, 'cubic': cubic}
"""Law by name, the common set of glTF, OpenUSD and Blender."""

HOLDS = (bool, np.bool_, str)
"""Types that have no states in between: only `step` can lead from one value to the next."""


def monotone_slopes(times, values):
    """
    Return slopes (n, ...) at n >= 2 keys for which Hermite cubics are monotone where the keys are.

    times: (n,) [s]; values: (n, ...). Within, the weighted harmonic mean of the neighbouring
    secants, zero where they differ in sign; at the ends, one-sided parabolas, limited.
    Fritsch and Butland, A Method for Constructing Local Monotone Piecewise Cubic Interpolants,
    SIAM J. Sci. Stat. Comput. 5, 1984.
    """
    times, values = np.asarray(times, float), np.asarray(values, float)
    widths = np.diff(times).reshape((-1,) + (1,) * (values.ndim - 1))
    secants = np.diff(values, axis=0) / widths
    if len(secants) == 1:
        return np.concatenate([secants, secants])
    slopes = np.zeros_like(values)
    near, far = widths[1:] + 2.0 * widths[:-1], 2.0 * widths[1:] + widths[:-1]
    same = secants[:-1] * secants[1:] > 0.0
    with np.errstate(divide='ignore', invalid='ignore'):
        mean = (near + far) / (far / secants[:-1] + near / secants[1:])
    # The weight of a secant grows with the width of the other segment.
    slopes[1:-1] = np.where(same, mean, 0.0)
    slopes[0] = _end_slope(widths[0], widths[1], secants[0], secants[1])
    slopes[-1] = _end_slope(widths[-1], widths[-2], secants[-1], secants[-2])
    return slopes


def _end_slope(width, next_width, secant, next_secant):
    """Return the slope of the parabola through three keys at its end, kept monotone."""
    slope = ((2.0 * width + next_width) * secant - width * next_secant) / (width + next_width)
    slope = np.where(slope * secant <= 0.0, 0.0, slope)
    too_steep = (secant * next_secant <= 0.0) & (np.abs(slope) > 3.0 * np.abs(secant))
    return np.where(too_steep, 3.0 * secant, slope)
