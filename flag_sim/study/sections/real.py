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
"""How near a flag is to real ones: eight tests beside what is published."""
from collections.abc import Iterator

from flag_sim.declarations.factories import cloth_of
from flag_sim.study import plots as drawing
from flag_sim.study.measures import published
from flag_sim.study.measures.flapping import COLUMNS, flapping, pictures, Trial
from flag_sim.study.measures.published import Flag
from flag_sim.study.measures.realism import compare, FLIES, flying, PARTLY, RIGHT, WRONG
from flag_sim.study.measures.settings import changed, Settings
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
from flag_sim.study.store import Store
import numpy as np

TITLE = """# How near this flag is to real ones

Measured in steady wind, beside what is published of real flags, and of exact solutions."""
WINDS = (6.0, 10.0, 15.0, 4.0, 3.0, 2.0)  # the most telling first [m/s]
OWN, LIGHTER = 'this flag', 'half as heavy'
SHOWN = 10.0  # wind of the pictures of the flag [m/s]
APART, COUNT = 1.0 / 6.0, 6  # of the pictures [s]
GAP = 4  # between two pictures [pixels]


class Real:
    """
    The section of a report on the flag of settings (see sections.Section).

    trial: how long each wind is watched; winds: in which [m/s]. Raises ValueError for a flag that
    no wind moves.
    """

    PLACE, NAME, SHARE = 0.0, 'real', 1.0

    def __init__(self, settings: Settings, trial: Trial = Trial(),
                 winds: tuple[float, ...] = WINDS):
        lighter = changed(settings, {'area_density': 0.5 * settings['area_density']})
        self.settings = {OWN: settings, LIGHTER: lighter}
        self.flags = {name: _flag_of(name, one) for name, one in self.settings.items()}
        self.trial, self.winds = trial, winds

    def batches(self, store: Store) -> Iterator[Batch]:
        """Fly the flag, and one half as heavy, in every wind."""
        del store
        for name in self.settings:
            for speed in self.winds:
                yield Batch(f'{name} in {speed:g} m/s', [{'flag': name, 'speed': speed}],
                            self._measured, (name, speed) == (OWN, self.winds[0]))

    def _measured(self, flag, speed):
        return flapping(self.settings[flag], speed, self.trial)

    def rows(self, store: Store) -> dict[str, list[dict]]:
        """Return {flag: rows}, from weak to strong wind."""
        return {name: sorted((row for row in store.rows(self.NAME) if row['flag'] == name),
                             key=lambda row: row['speed']) for name in self.settings}

    def tests(self, store: Store) -> str:
        """Return the table of the eight tests, and in words what is right and what is not."""
        rows = self.rows(store)
        found = compare(self.flags[OWN], rows[OWN], rows[LIGHTER])
        words = [f'- {verdict}: ' + ('; '.join(
            one.name if verdict == RIGHT else f'{one.name}: {one.says.rstrip(".")}'
            for one in found if one.verdict == verdict) or 'none') + '.'
            for verdict in (RIGHT, PARTLY, WRONG)]
        return table(['test', 'published', 'found', 'verdict'],
                     [[f'{number}. {one.name}', one.published, one.found, one.verdict]
                      for number, one in enumerate(found, 1)]) + '\n\n' + '\n'.join(words)

    def text(self, store: Store) -> str:
        """Return the tests, their sources, and all that was measured."""
        rows, flag = self.rows(store), self.flags[OWN]
        if not rows[OWN]:
            return ''
        sources = '\n'.join(f'{number}. {one.name}: {one.source}.' for number, one in enumerate(
            compare(flag, rows[OWN], rows[LIGHTER]), 1))
        lines = [[name, row['speed'], *(row[column] for column in COLUMNS)]
                 for name in rows for row in rows[name]]
        missing = [f'{name} in {speed:g} m/s' for name in rows for speed in self.winds
                   if speed not in {row['speed'] for row in rows[name]}]
        return f"""## Eight tests

The flag is {flag.length:.3g} x {flag.width:.3g} m, of {flag.area_density:.3g} kg/m2 in air of
{flag.air_density:.3g} kg/m3: its mass ratio m / (rho L) is {flag.mass_ratio:.2g}. It starts along
a steady wind without gusts, settles for {self.trial.settle:g} s and is watched for
{self.trial.seconds:g} s. It is compared in the winds in which it flies: in which the line from the
hoist's middle to its centre of mass sags by less than {FLIES:g} degrees.

{self.tests(store)}

## Where the bands are from

{sources}

## What was measured

Frequency: the peak of the spectrum of the free edge's middle, across the wind; crossings: how
often it comes back to its mean. Swing: from side to side, by the length. Wave speed: by the wind,
from the lag between 50 and 85 % of the length; – where the flag swings as a whole. Drag: of the
mean load on the pole, by rho U^2 L H / 2. Lift: by the weight.

{table(['flag', 'wind, m/s', 'frequency, Hz', 'crossings, Hz', 'swing', 'wave speed',
        'sag, degrees', 'drag', 'lift'], lines)}
""" + (f'\nNot measured for lack of time: {"; ".join(missing)}.' if missing else '')

    def plots(self, store: Store) -> Iterator[tuple[str, str]]:
        """Draw frequency, drag, wave speed and swing against the wind; and the flag itself."""
        yield from self._plot(store)
        shown = pictures(self.settings[OWN], SHOWN, self.trial.settle, APART, COUNT)
        if shown:
            gap = np.full((len(shown[0]), GAP, 3), 255, np.uint8)
            strip = np.concatenate([part for one in shown for part in (gap, one)][1:], axis=1)
            drawing.save(strip, store.folder / 'flag.png')
            yield 'flag.png', (f'The flag in a wind of {SHOWN:g} m/s, after {self.trial.settle:g} '
                               f's; from one picture to the next {APART:.2g} s.')

    def _plot(self, store):
        rows = {name: flying(found) for name, found in self.rows(store).items()}
        if len(rows[OWN]) < 2:
            return
        with drawing.figure(store.folder / 'real.png', 2, 2, (5.0, 3.4), sharex=True) as (
                figure, grid):
            for axes, (label, of, band) in zip(grid.flat, self._panels()):
                self._draw(axes, rows, of, band)
                axes.set_ylabel(label)
            for axes in grid[1]:
                axes.set_xlabel('wind [m/s]')
            handles, labels = grid[0, 0].get_legend_handles_labels()
            figure.legend(handles, labels, loc='outside lower center', ncols=3, frameon=False)
        yield 'real.png', (
            'The grey bands are what is published of a flag of this mass; a line in one agrees '
            'with it. A line that rises less steeply than its band grows too slowly with the '
            'wind.')

    def _panels(self):
        """Return (label, value of a row, band of a wind) of the four quantities."""
        flag = self.flags[OWN]
        area = 0.5 * flag.air_density * flag.length * flag.width
        drag, swing = published.drag(flag), published.swing(flag)

        def times(band, of):
            return lambda speed: [end * of(speed) for end in band]

        return (
            ('frequency [Hz]', lambda row: row['frequency_hz'],
             times(published.STROUHAL, lambda speed: speed / flag.length)),
            ('drag [N]', lambda row: row['drag'] * area * row['speed']**2,
             times(drag, lambda speed: area * speed**2)),
            ('speed of waves [m/s]',
             lambda row: row['wave_speed'] and row['wave_speed'] * row['speed'],
             times(published.WAVE_SPEED, lambda speed: speed)),
            ('swing of the free edge [m]', lambda row: row['swing'] * flag.length,
             times(swing, lambda speed: flag.length)))

    @staticmethod
    def _draw(axes, rows, of, band):
        """Draw a value of both flags' rows, over its band."""
        speeds = np.linspace(*sorted(row['speed'] for row in rows[OWN])[::len(rows[OWN]) - 1])
        low, high = np.array([band(speed) for speed in speeds]).T
        axes.fill_between(speeds, low, high, color='#c0c0c0', label='published')
        for style, (name, found) in zip(drawing.LINES, rows.items()):
            points = [(row['speed'], of(row)) for row in found if of(row) is not None]
            if points:
                axes.plot(*zip(*points), label=name, **style)
        axes.set_ylim(bottom=0.0)
        axes.grid(alpha=0.3)


def _flag_of(name, settings):
    try:
        return Flag.of(cloth_of(settings))
    except ValueError as error:
        raise ValueError(f'{name}: {error}') from None
