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
"""Eight tests of a flag against real ones: what is published, what was found, and the verdict."""
from collections.abc import Callable
import math
from typing import NamedTuple

from flag_sim.study.measures import published
from flag_sim.study.measures.flapping import SMALLEST
from flag_sim.study.measures.published import Band, Flag, SOURCES
import numpy as np

FLIES = 15.0  # sag up to which a flag flies, as flags in experiments do, and does not hang [deg]
LEVEL = 10.0  # sag from which on it is level [deg]
RIGHT, PARTLY, WRONG, OPEN = 'right', 'partly right', 'wrong', 'not tested'


class Comparison(NamedTuple):
    """One test: its name, what is published and what was found, in words, and the verdict."""

    name: str
    published: str
    found: str
    verdict: str  # RIGHT, PARTLY, WRONG or OPEN
    says: str     # a sentence
    source: str


def flying(rows: list[dict]) -> list[dict]:
    """Return the rows (see flapping) in which a flag flies, from weak to strong wind."""
    return sorted((row for row in rows if row['sag_deg'] is not None
                   and row['sag_deg'] < FLIES), key=lambda row: row['speed'])


def strouhal(row: dict, flag: Flag) -> float | None:
    """Return f L / U of a row; None where the flag stays still."""
    return row['frequency_hz'] and row['frequency_hz'] * flag.length / row['speed']


def compare(flag: Flag, rows: list[dict], lighter: list[dict]) -> list[Comparison]:
    """
    Return the eight tests of a flag.

    rows: of flapping, each with its wind `speed` [m/s]; lighter: of the same flag, half as heavy.
    """
    own, light = flying(rows), flying(lighter)
    return [
        _starts(own),
        _in_band('frequency, f L / U', own, lambda row: strouhal(row, flag), published.STROUHAL,
                 SOURCES['frequency']),
        _in_band('speed of waves, by the wind', own, lambda row: row['wave_speed'],
                 published.WAVE_SPEED, SOURCES['wave speed']),
        _lighter(own, light),
        _in_band('swing of the free edge, by the length', own, lambda row: row['swing'],
                 published.swing(flag), SOURCES['swing']),
        _in_band('drag coefficient', own, lambda row: row['drag'], published.drag(flag),
                 SOURCES['drag']),
        _number('power of the wind that drag grows with', exponent(own), published.EXPONENT,
                SOURCES['exponent']),
        _number(f'wind from which it sags by less than {LEVEL:g} degrees, m/s',
                level_wind(rows), published.level_wind(flag), SOURCES['level'])]


def _untested(name, band, source):
    """Return the Comparison of a test for which nothing was found."""
    return Comparison(name, '–' if band is None else str(band), '–', OPEN,
                      'there is nothing to compare.', source)


def _starts(own):
    """Return whether the flag flaps in a wind along it."""
    name = 'flaps in wind exactly along it'
    if not own:
        return _untested(name, 'always', SOURCES['flaps'])
    still = [row['speed'] for row in own if row['swing'] < SMALLEST]
    says = (f'it stays still at {_winds(still)}.' if still else
            'it flaps in every wind in which it flies.')
    return Comparison(name, 'always', f'in {len(own) - len(still)} of {len(own)} winds',
                      _verdict(len(own) - len(still), len(own)), says, SOURCES['flaps'])


def _in_band(name: str, own: list[dict], of: Callable, band: Band, source: str) -> Comparison:
    """Return how a value of each row lies to a band."""
    values = [(row['speed'], of(row)) for row in own if of(row) is not None]
    if not values:
        return _untested(name, band, source)
    sides = [(speed, band.side(value)) for speed, value in values]
    wrong = [f'too {word} at {_winds(winds)}' for word, which in (('low', -1), ('high', 1))
             if (winds := [speed for speed, side in sides if side == which])]
    found = ', '.join(f'{value:.2g}' for _, value in values)
    winds = _winds([speed for speed, _ in values])
    return Comparison(name, str(band), f'{found} at {winds}',
                      _verdict(sum(side == 0 for _, side in sides), len(sides)),
                      (' and '.join(wrong) or 'within the band in every wind') + '.', source)


def _number(name: str, value: float | None, band: Band | None, source: str) -> Comparison:
    """Return how one number lies to a band."""
    if value is None or band is None:
        return _untested(name, band, source)
    side = band.side(value)
    return Comparison(name, str(band), f'{value:.2g}', WRONG if side else RIGHT,
                      ('too low.', 'within the band.', 'too high.')[side + 1], source)


def _lighter(own, light):
    """Return by which factor the frequency changes when the flag is half as heavy."""
    name = 'frequency of a flag half as heavy, by this one'
    by_speed = {row['speed']: row['frequency_hz'] for row in own}
    ratios = [row['frequency_hz'] / by_speed[row['speed']] for row in light
              if row['frequency_hz'] and by_speed.get(row['speed'])]
    if not ratios:
        return _untested(name, published.LIGHTER, SOURCES['lighter'])
    return _number(name, math.exp(float(np.log(ratios).mean())), published.LIGHTER,
                   SOURCES['lighter'])


def exponent(own: list[dict]) -> float | None:
    """Return the power of the wind that the drag [N] of rows grows with; None for one row."""
    rows = [row for row in own if row['drag'] > 0.0]
    if len(rows) < 2:
        return None
    speeds = np.log([row['speed'] for row in rows])
    return 2.0 + float(np.polyfit(speeds, np.log([row['drag'] for row in rows]), 1)[0])


def level_wind(rows: list[dict]) -> float | None:
    """Return the wind [m/s] from which on a flag sags by less than LEVEL; None if not in rows."""
    sags = sorted((row['speed'], row['sag_deg']) for row in rows if row['sag_deg'] is not None)
    for (weak, low), (strong, high) in zip(sags, sags[1:]):
        if low >= LEVEL > high:
            return weak + (strong - weak) * (low - LEVEL) / (low - high)
    return None


def _winds(speeds):
    """Return winds in words."""
    return ', '.join(f'{speed:g}' for speed in speeds) + ' m/s'


def _verdict(inside, count):
    """Return the verdict for so many winds of all in which the flag is right."""
    return {0: WRONG, count: RIGHT}.get(inside, PARTLY)
