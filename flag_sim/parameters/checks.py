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
Refusal of bad values, with a message that names the rule and the value.

For what is no parameter: those are checked by their declarations.
"""
from collections.abc import Collection
from decimal import Context, ROUND_DOWN
import functools
import math
from pathlib import Path

import numpy as np

LARGEST = 1e12
"""Beyond any physical value; its products and roots are far from overflow."""

SHOWN = 120
"""The most letters of a value that a message shows."""

DIGITS = range(4, 17)
"""With how many digits a limit may be printed, and then typed by a user."""


def text(number: float) -> str:
    """Return a number as short as `:g` where that is exact, and else with all its digits."""
    short = f'{number:g}'
    return short if float(short) == number else repr(float(number))


def rounded_down(limit: float, digits: int = 3) -> str:
    """Return a positive limit with few digits, none of them above it, as a text."""
    return f'{float(Context(digits, ROUND_DOWN).create_decimal(limit)):g}'


@functools.lru_cache(maxsize=256)
def _roundings(limit):
    """Return the least and the greatest number that a limit, rounded, may be printed as."""
    printed = [float(f'{limit:.{digits}g}') for digits in DIGITS]
    return min(limit, *printed), max(limit, *printed)


def within(number: float, low: float, high: float) -> float | None:
    """
    Return a number if it is from low to high, else None.

    What is beyond a limit only because the limit is printed with fewer digits than it has, as
    1.571 for half of pi, is the limit itself.
    """
    if _roundings(low)[0] <= number <= _roundings(high)[1]:
        return min(max(number, low), high)
    return None


def shown(value: object) -> str:
    """Return a value as a message shows it: its repr on one line, of at most SHOWN letters."""
    try:
        words = ' '.join(repr(value).split())
    except Exception:  # whole numbers of thousands of digits, and whatever a class's repr does
        words = f'a value of class {type(value).__name__}'
    return words if len(words) <= SHOWN else words[:SHOWN - 3] + '...'


def require(holds: bool, name: str, rule: str, value: object) -> None:
    """Raise ValueError('<name> must be <rule>, not <value>') unless it holds."""
    if not holds:
        raise ValueError(f'{name} must be {rule}, not {shown(value)}')


def path(name: str, value: str | Path) -> Path:
    """
    Return value as a Path, with `~` and `~user` at its beginning expanded as by a shell.

    A shell itself does so only where they begin a word, not in `path:=~/bag` or `--out=~/out`.
    Raises ValueError for a user that is not known here.
    """
    try:
        return Path(value).expanduser()
    except RuntimeError:
        raise ValueError(f'{name} {value}: no home is known of such a user') from None


def finite(name: str, value: object, low: float = -math.inf, high: float = math.inf,
           above: float = -math.inf) -> float:
    """
    Return value as a float.

    Raises ValueError unless it is a finite number, low <= value <= high and value > above.
    """
    try:
        if isinstance(value, (bool, np.bool_)) or np.ndim(value):  # Python takes True for 1
            raise TypeError
        is_finite = math.isfinite(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f'{name} must be a number, not {shown(value)}') from None
    number = float(value)
    if not is_finite:
        raise ValueError(f'{name} must be finite, not {number}')
    if not number > above:
        rule = f'greater than {text(above)}'
        rule += f' and at most {high:g}' if high < math.inf else ''
        raise ValueError(f'{name} must be {rule}, not {text(number)}')
    kept = within(number, low, high)
    if kept is None:
        least = f'at least {low:g}' if above == -math.inf else f'greater than {text(above)}'
        rule = (least if high == math.inf else f'between {low:g} and {high:g}'
                if above == -math.inf else f'{least} and at most {high:g}')
        raise ValueError(f'{name} must be {rule}, not {text(number)}')
    return kept


def moment(name: str, value: object) -> float:
    """Return a time [s] as a float; raises ValueError unless it is finite and within LARGEST."""
    if type(value) is float and -LARGEST <= value <= LARGEST:  # asked for with every frame
        return value
    return finite(name, value, -LARGEST, LARGEST)


def listed(name: str, values: object) -> list:
    """Return values as a list; raises ValueError for what is not one, such as a text."""
    if isinstance(values, (str, bytes, dict)) or not hasattr(values, '__iter__'):
        require(False, name, 'a list', values)
    try:
        return list(values)
    except (TypeError, NotImplementedError):  # arrays and memoryviews that only look like lists
        raise ValueError(f'{name} must be a list, not {shown(values)}') from None


def whole(name: str, value: object, low: int, high: int) -> int:
    """Return value as an int; raises ValueError unless it is whole and low <= value <= high."""
    number = finite(name, value)
    if number != int(number):
        raise ValueError(f'{name} must be a whole number, not {text(number)}')
    exact = int(value)  # a float has not all digits of a large one
    if not low <= exact <= high:
        raise ValueError(f'{name} must be between {low} and {high}, not {exact}')
    return exact


def boolean(name: str, value: object) -> bool:
    """Return value as a bool; raises ValueError unless it is True or False."""
    require(isinstance(value, (bool, np.bool_)), name, 'True or False', value)
    return bool(value)


def instance(name: str, value: object, kind: type) -> object:
    """Return value; raises ValueError unless it is of the kind, a class."""
    if not isinstance(value, kind):
        require(False, name, f'of class {kind.__name__}', value)
    return value


def choice(name: str, value: object, choices: Collection[str]) -> str:
    """Return value; raises ValueError unless it is one of the choices, which are words."""
    require(isinstance(value, str) and value in choices, name,
            'one of ' + ', '.join(choices), value)
    return value


def vector(name: str, value: object, largest: float = math.inf) -> tuple:
    """Return value as three finite floats; raises ValueError unless of at most largest size."""
    numbers = array(name, value, (3,), largest)
    if any(isinstance(one, (bool, np.bool_)) for one in value):
        raise ValueError(f'{name} must hold numbers, not {shown(value)}')
    return tuple(float(number) for number in numbers)


def array(name: str, value: object, shape: tuple, largest: float = math.inf) -> np.ndarray:
    """
    Return value as a float64 array.

    Raises ValueError unless it has the shape and all its numbers are finite and at most largest
    in size.
    """
    numbers = _numbers(name, value)
    if numbers.shape != shape:
        raise ValueError(f'{name} must have shape {shape}, not {numbers.shape}')
    bad = numbers[~(np.isfinite(numbers) & (np.abs(numbers) <= largest))]
    if bad.size:
        rule = f'finite and at most {largest:g} in size' if largest < math.inf else 'finite'
        raise ValueError(f'{name} must be {rule}, not {text(bad[0])}')
    return numbers


def grid(name: str, value: object) -> np.ndarray:
    """
    Return vectors at the nodes of a grid as a contiguous float64 array (rows, columns, 3).

    They may be nan or infinite. Raises ValueError for other shapes and types, and for fewer than
    two rows or columns.
    """
    numbers = _numbers(name, value)
    require(numbers.ndim == 3 and numbers.shape[2] == 3 and min(numbers.shape[:2]) >= 2, name,
            'of shape (rows, columns, 3), of at least 2 x 2 nodes', numbers.shape)
    return np.ascontiguousarray(numbers)


def _numbers(name, value):
    """Return value as a float64 array; raises ValueError for what does not hold numbers."""
    try:
        numbers = np.asarray(value)
        if numbers.dtype.kind == 'b':
            raise TypeError
        return numbers.astype(np.float64, casting='same_kind', copy=False)
    except (TypeError, ValueError):
        raise ValueError(f'{name} must hold numbers, not {shown(value)}') from None
