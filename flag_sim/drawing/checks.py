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

"""Refusals that several of the drawing's dataclasses share; each names the rule and the value."""
import math


def require(holds, name, rule, value):
    """Raise ValueError('<name> must be <rule>, not <value>') unless `holds`."""
    if not holds:
        raise ValueError(f'{name} must be {rule}, not {value!r}')


def finite(name, value):
    """Return `value` as a float; raise ValueError unless it is a finite number."""
    require(_is_finite(value), name, 'a finite number', value)
    return float(value)


def positive(name, value):
    """Return `value` as a float; raise ValueError unless it is finite and above zero."""
    require(_is_finite(value) and value > 0.0, name, 'a finite number above 0', value)
    return float(value)


def not_negative(name, value):
    """Return `value` as a float; raise ValueError unless it is finite and at least zero."""
    require(_is_finite(value) and value >= 0.0, name, 'a finite number of at least 0', value)
    return float(value)


def one_of(name, value, choices):
    """Return `value`; raise ValueError unless it is one of the strings `choices`."""
    require(value in choices, name, 'one of ' + ', '.join(choices), value)
    return value


def vector(name, value):
    """Return `value` as a tuple of three floats; raise ValueError unless it is that and finite."""
    value = tuple(value)
    require(len(value) == 3 and all(map(_is_finite, value)), name, 'three finite numbers', value)
    return tuple(map(float, value))


def color(name, value):
    """Return `value` as a tuple of three floats; raise ValueError unless all are in 0..255."""
    value = tuple(value)
    require(len(value) == 3 and all(_is_finite(c) and 0 <= c <= 255 for c in value),
            name, 'three numbers from 0 to 255', value)
    return tuple(map(float, value))


def _is_finite(value):
    try:
        return math.isfinite(value)
    except (TypeError, OverflowError):
        return False
