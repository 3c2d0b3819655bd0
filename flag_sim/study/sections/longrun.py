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

"""Statistics of long runs, which are what is left to compare beyond the horizon."""
from collections.abc import Iterator
import functools
from pathlib import Path

from flag_sim.cloth.mesh import resample
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.declarations.factories import cloth_of
from flag_sim.study import plots as drawing
from flag_sim.study.measures import errors, summary, trials
from flag_sim.study.measures.reference import Shot
from flag_sim.study.measures.settings import changed
from flag_sim.study.measures.summary import Rows
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
from flag_sim.study.store import Store
import numpy as np

PLACE, NAME, SHARE = 4, 'longrun', 1.0
SETTLE = 3.0  # time that is left out [s]
LENGTH = 20.0  # time that is measured [s]
SLOWEST = 0.3  # least frequency of a peak [Hz]; slower are the gusts
COLUMNS = {'energy_j': 'kinetic energy J', 'energy_error_j': 'its standard error J',
           'peak_hz': 'peak Hz', 'sideways_m_s': 'sideways m/s', 'shape_mm': 'mean shape mm'}
"""{column: its title in the table}."""


def runs():
    """Return {name: settings}: every method on the default grid, and the default on others."""
    return {'rk4': changed(trials.BASE, {'solver': 'rk4', 'step_safety': 0.5}),
            **{name: changed(trials.BASE, {'solver': name}) for name in SOLVERS if name != 'rk4'},
            'a grid half as fine': trials.coarser(), 'a grid twice as fine': trials.finer()}


def batches(store: Store) -> Iterator[Batch]:
    """Run every setting through the same long shot; compare shapes with rk4's."""
    del store
    settings = runs()

    @functools.cache
    def long_run(name):
        return Shot(settings[name]).long_run(cloth_of(settings[name]), 0, SETTLE, LENGTH)

    def measure(run):
        return _statistics(long_run(run), long_run('rk4').shape)

    for name in settings:
        yield Batch(f'{LENGTH:.0f} s with {name}', [{'run': name}], measure, name == 'rk4')


def _statistics(run, right):
    """Return the numbers of a LongRun, None where it is None; right: mean shape to compare."""
    if run is None:
        return dict.fromkeys(COLUMNS)
    # The standard error of a mean, from the means of blocks longer than the motion's.
    blocks = [np.mean(block) for block in np.array_split(run.energies, 8)]
    rows, columns = np.minimum(run.shape.shape, right.shape)[:2]
    shapes = [resample(shape, rows, columns) for shape in (run.shape, right)]
    return {'energy_j': float(np.mean(run.energies)),
            'energy_error_j': float(np.std(blocks, ddof=1) / np.sqrt(len(blocks))),
            'peak_hz': peak(run.sideways, 1.0 / trials.BASE['rate']),
            'sideways_m_s': float(np.std(run.sideways)),
            'shape_mm': 1e3 * summary.rms(errors.distances(*shapes))}


def peak(motion, dt):
    """Return the frequency [Hz] at which a motion, sampled every dt [s], is strongest."""
    motion = np.asarray(motion) - np.mean(motion)
    power = np.abs(np.fft.rfft(motion * np.hanning(len(motion))))**2
    frequencies = np.fft.rfftfreq(len(motion), dt)
    power[frequencies < SLOWEST] = 0.0
    return float(frequencies[np.argmax(power)])


def text(rows: Rows) -> str:
    """Return the statistics."""
    lines = [[row['run'], *(row[name] for name in COLUMNS)] for row in rows]
    missing = ', '.join(name for name in runs() if name not in [row['run'] for row in rows])
    missing = missing and f' Not run for lack of time: {missing}.'
    return f"""## Statistics of long runs

{LENGTH:.0f} s of the gusty shot, after {SETTLE:.0f} s that are left out. The standard error says
how far the mean of so short a run can be trusted: energies closer together than twice that are
the same. The frequency is that at which the sideways velocity at two thirds of the length
is strongest, to {1.0 / LENGTH:.2f} Hz; 'sideways' is that velocity (RMS); the
mean shape is compared with rk4's. A dash: the run diverged.{missing}

{table(['run', *COLUMNS.values()], lines)}
"""


def plots(rows: Rows, folder: Path) -> Iterator[tuple[str, str]]:
    """Draw the energies with their errors."""
    some = [row for row in rows if row['energy_j'] is not None]
    with drawing.figure(folder / 'longrun.png') as (_, axes):
        drawing.dot_chart(axes, [row['run'] for row in some], [
            (row['run'], row['energy_j'], 2.0 * row['energy_error_j'],
             {'color': 'black' if row['run'] == 'seed' else 'C0'}) for row in some],
            'mean kinetic energy [J], twice its standard error')
        axes.set_xscale('log')
        drawing.decimal_ticks(axes)
    yield 'longrun.png', 'Methods whose bars overlap move the flag with the same energy.'
