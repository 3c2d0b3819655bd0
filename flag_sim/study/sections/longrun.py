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
import functools

from flag_sim.cloth.solvers import SOLVERS
from flag_sim.declarations.making import cloth_of
from flag_sim.study import plots as drawing
from flag_sim.study.measures import errors, summary, trials
from flag_sim.study.measures.reference import Shot
from flag_sim.study.measures.settings import changed
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
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


def batches(store):
    """Run every setting through the same long shot; compare shapes with the first one's."""
    del store
    right = functools.cache(lambda: _run(next(iter(runs().values()))))
    for number, (name, settings) in enumerate(runs().items()):
        run = right if number == 0 else functools.partial(_run, settings)
        yield Batch(f'{LENGTH:.0f} s with {name}', {name: functools.partial(_row, run, right)},
                    number == 0)


def _run(settings):
    return Shot(settings).long_run(cloth_of(settings), 0, SETTLE, LENGTH)


def _row(run, right):
    found, right = run(), right()
    if found is None:
        return dict.fromkeys(COLUMNS)
    # The standard error of a mean, from the means of blocks longer than the motion's.
    blocks = [np.mean(block) for block in np.array_split(found.energies, 8)]
    return {'energy_j': float(np.mean(found.energies)),
            'energy_error_j': float(np.std(blocks, ddof=1) / np.sqrt(len(blocks))),
            'peak_hz': peak(found.sideways, 1.0 / trials.BASE['rate']),
            'sideways_m_s': float(np.std(found.sideways)),
            'shape_mm': _difference(found.shape, right.shape)}


def peak(motion, dt):
    """Return the frequency [Hz] at which a motion, sampled every dt [s], is strongest."""
    motion = np.asarray(motion) - np.mean(motion)
    power = np.abs(np.fft.rfft(motion * np.hanning(len(motion))))**2
    frequencies = np.fft.rfftfreq(len(motion), dt)
    power[frequencies < SLOWEST] = 0.0
    return float(frequencies[np.argmax(power)])


def _difference(mean, shape):
    """Return the RMS difference [mm] of mean shapes on any two grids, at their common nodes."""
    if mean.shape[0] > shape.shape[0]:
        mean = mean[::2, ::2]
    elif mean.shape[0] < shape.shape[0]:
        shape = shape[::2, ::2]
    return 1e3 * summary.rms(errors.distances(mean, shape))


def text(rows: list[dict]) -> str:
    """Return the statistics."""
    lines = [[row['key'], *(row[name] for name in COLUMNS)] for row in rows]
    missing = ', '.join(name for name in runs() if name not in [row['key'] for row in rows])
    missing = missing and f' For lack of time not run: {missing}.'
    return f"""## Statistics of long runs

{LENGTH:.0f} s of the gusty shot, after {SETTLE:.0f} s that are left out. The standard error says
how far the mean of so short a run can be trusted: energies closer together than twice that are
the same. The frequency is that at which the sideways velocity at two thirds of the length
is strongest, to {1.0 / LENGTH:.2f} Hz; 'sideways' is that velocity (RMS); the
mean shape is compared with rk4's. A dash: the run diverged.{missing}

{table(['run', *COLUMNS.values()], lines)}
"""


def plots(rows, folder):
    """Draw the energies with their errors."""
    some = [row for row in rows if row['energy_j'] is not None]
    with drawing.figure(folder / 'longrun.png') as (_, axes):
        drawing.dot_chart(axes, [row['key'] for row in some], [
            (row['key'], row['energy_j'], 2.0 * row['energy_error_j'],
             {'color': 'black' if row['key'] == 'seed' else 'C0'}) for row in some],
            'mean kinetic energy [J], twice its standard error')
        axes.set_xscale('log')
        drawing.plain(axes)
    return [('longrun.png', 'Methods whose bars overlap move the flag with the same vigour.')]
