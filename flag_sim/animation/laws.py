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
Key laws: interpolation between two neighbouring keys, one segment at a time.

Between keys (t0, y0) and (t1, y1) a law is a function of f = (t - t0) / (t1 - t0), in [0, 1), and
of the values `before` = y0 and `after` = y1.

| law    | curve                            | smooth at keys | glTF        | Blender      |
|--------|----------------------------------|----------------|-------------|--------------|
| step   | y0                               | jumps          | STEP        | Constant     |
| linear | y0 + (y1 - y0) f                 | has corners    | LINEAR      | Linear       |
| ease   | y0 + (y1 - y0) (3 f^2 - 2 f^3)   | rests there    |             | ease in, out |
| cubic  | Hermite, monotone slopes (PCHIP) | C1             | CUBICSPLINE | Bezier       |

glTF and Blender store a cubic's slopes with the keys; here they follow from the keys.
"""
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

Value = TypeVar('Value')


def step(fraction: float, before: Value, after: Value) -> Value:
    """Return the earlier key's value, which is kept until the later key."""
    del fraction, after
    return before


def linear(fraction: float, before: float, after: float) -> float:
    """Return the value on the straight line: it changes at constant speed."""
    return before + (after - before) * fraction


def ease(fraction: float, before: float, after: float) -> float:
    """
    Return the value on the smoothstep: it starts and arrives at rest.

    3 f^2 - 2 f^3 is the cubic with value 0 and slope 0 at f = 0, value 1 and slope 0 at f = 1.
    """
    return linear(fraction * fraction * (3.0 - 2.0 * fraction), before, after)


def cubic(fraction: float, before: float, after: float, slope_before: float,
          slope_after: float) -> float:
    """
    Return the value on the cubic Hermite curve with slopes m0 and m1, in values per segment.

    With g = 1 - f: y0 (1 + 2 f) g^2 + y1 (1 + 2 g) f^2 + m0 f g^2 - m1 f^2 g.
    With the slopes of `monotone_slopes` it never overshoots the keys.
    """
    f, g = fraction, 1.0 - fraction
    return (before * (1.0 + 2.0 * f) * g * g + after * (3.0 - 2.0 * f) * f * f
            + slope_before * f * g * g - slope_after * f * f * g)


LAWS = {'step': step, 'linear': linear, 'ease': ease, 'cubic': cubic}
"""Key laws by name."""

STEPPED = (bool, np.bool_, str)
"""Types that have no states in between: only `step` can lead from one value to the next."""


def monotone_slopes(times: Sequence[float], values: Sequence) -> np.ndarray:
    """
    Return slopes (n, ...) at n >= 2 keys for which Hermite cubics are monotone where the keys are.

    times: (n,) [s]; values: (n, ...); the slopes are in values per second. Between segments of
    widths h, H and secants (slopes of the straight lines) d, D it is their weighted harmonic mean
    m = 3 (h + H) / ((h + 2 H) / d + (2 h + H) / D), and 0 where d and D differ in sign: there the
    key is an extremum. At the ends it is that of `_end_slope`. Known as PCHIP (MATLAB, SciPy).
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
    """
    Return the slope at its end of the parabola through the three keys there, kept monotone.

    0 if it points away from the next key; where the secants differ in sign at most 3 times the
    first, the bound of Fritsch and Carlson (1980). Moler, Numerical Computing with MATLAB, ch. 3.
    """
    slope = ((2.0 * width + next_width) * secant - width * next_secant) / (width + next_width)
    slope = np.where(slope * secant <= 0.0, 0.0, slope)
    too_steep = (secant * next_secant <= 0.0) & (np.abs(slope) > 3.0 * np.abs(secant))
    return np.where(too_steep, 3.0 * secant, slope)
