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

"""What a person types into a box, read as a value. No Qt."""

from flag_sim.parameters.checks import shown


def number(text: str, is_whole: bool = False) -> float | int:
    """
    Return the number that a text is, with a decimal point or a decimal comma.

    is_whole: return an int where it is one. Raises ValueError for anything else.
    """
    plain = text.strip()
    if plain.count(',') == 1 and '.' not in plain:
        plain = plain.replace(',', '.')
    try:
        value = float(plain)
    except ValueError:
        raise ValueError(f'{shown(text)} is no number') from None
    return int(value) if is_whole and value.is_integer() else value


def like(text: str, before: object) -> object:
    """
    Return what is typed in place of a value, which is of the same type.

    In a list commas stand between numbers. Raises ValueError for what is no such value.
    """
    if isinstance(before, str):
        return text
    if isinstance(before, list):
        return [number(part) for part in text.strip().strip('[]').split(',')]
    if isinstance(before, bool):
        try:
            return {'true': True, 'false': False}[text.strip().lower()]
        except KeyError:
            raise ValueError(f'{shown(text)} is neither true nor false') from None
    return number(text, isinstance(before, int))
