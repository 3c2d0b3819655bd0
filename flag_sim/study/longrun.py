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

"""Part: statistics of long runs, which are what is left to compare beyond the horizon."""
from flag_sim.cloth import Diverged
from flag_sim.cloth.energy import kinetic_energy
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.dials.settings import cloth_of
from flag_sim.study import error, plots as drawing, report, scene
from flag_sim.study.settings import changed
from flag_sim.study.shot import Shot
import numpy as np

NAME = 'longrun'
SHARE = 1.0
SETTLE = 3.0
"""Time that is left out [s]."""
LENGTH = 20.0
"""Time that is measured [s]."""
CORNER = 1.0 / 3.0, 2.0 / 3.0
"""Place of the node whose sideways motion is listened to: parts of height and length."""
SLOWEST = 0.3
"""Least frequency of a peak [Hz]; slower are the gusts."""


def runs():
    """Return {name: settings}: every method on the default grid, and the default on others."""
    return {'rk4': changed(scene.BASE, {'solver': 'rk4', 'step_safety': 0.5}),
            **{name: changed(scene.BASE, {'solver': name}) for name in SOLVERS if name != 'rk4'},
            'a grid half as fine': scene.coarser(), 'a grid twice as fine': scene.finer()}


def run(store, budget):
    """Run every setting through the same long shot."""
    shape = None
    for name, settings in runs().items():
        if store.has(NAME, name):
            continue
        if store.rows(NAME) and not budget.allows():
            return
        budget.say(f'{LENGTH:.0f} s with {name}')
        if shape is None:
            first, own = next(iter(runs().items()))
            shape = _statistics(own)[1]
        row, mean = _statistics(settings)
        row['shape_mm'] = None if mean is None else _difference(mean, shape)
        store.add(NAME, {'key': name, **row})


def _statistics(settings):
    """Return a row of numbers and the mean shape (rows, columns, 3) [m]."""
    shot, cloth = Shot(settings), cloth_of(settings)
    model = Model(cloth.mesh, cloth.material)
    first, last = round(SETTLE / shot.dt), round((SETTLE + LENGTH) / shot.dt)
    energies, sideways, mean = [], [], 0.0
    node = tuple(round(part * (count - 1)) for part, count in zip(
        CORNER, (cloth.mesh.rows, cloth.mesh.columns)))
    empty = dict.fromkeys(('energy_j', 'energy_error_j', 'peak_hz', 'sideways_m_s'))
    for frame in range(1, last + 1):
        try:
            cloth.advance(shot.dt, shot.wind(frame))
        except Diverged:
            return empty, None
        if frame > first:
            energies.append(kinetic_energy(model, cloth.velocities))
            sideways.append(cloth.velocities[node][1])
            mean = mean + cloth.positions / (last - first)
    return {'energy_j': float(np.mean(energies)), 'energy_error_j': _standard_error(energies),
            'peak_hz': peak(sideways, shot.dt), 'sideways_m_s': float(np.std(sideways))}, mean


def _standard_error(values, blocks=8):
    """Return the standard error of a mean, from the means of blocks longer than the motion's."""
    means = [np.mean(block) for block in np.array_split(values, blocks)]
    return float(np.std(means, ddof=1) / np.sqrt(blocks))


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
    return 1e3 * error.rms(error.distances(mean, shape))


def section(rows):
    """Return the statistics."""
    table = [[row['key'], *(row[name] for name in (
        'energy_j', 'energy_error_j', 'peak_hz', 'sideways_m_s', 'shape_mm'))] for row in rows]
    missing = ', '.join(name for name in runs() if name not in [row['key'] for row in rows])
    missing = missing and f' For lack of time not run: {missing}.'
    return f"""## Statistics of long runs

{LENGTH:.0f} s of the gusty shot, after {SETTLE:.0f} s that are left out. The standard error says
how far the mean of so short a run can be trusted: energies closer together than twice that are
the same. The frequency is that at which the sideways velocity at two thirds of the length
is strongest, to {1.0 / LENGTH:.2f} Hz; 'sideways' is that velocity (RMS); the
mean shape is compared with rk4's. A dash: the run diverged.{missing}

{report.table(['run', 'kinetic energy J', 'its standard error J', 'peak Hz', 'sideways m/s',
               'mean shape mm'], table)}
"""


def plots(rows, folder):
    """Draw the energies with their errors."""
    some = [row for row in rows if row['energy_j'] is not None]
    with drawing.figure(folder / 'longrun.png') as (_, axes):
        for place, row in enumerate(some):
            axes.errorbar(row['energy_j'], place, xerr=2.0 * row['energy_error_j'], fmt='o',
                          color='black' if row['key'] == 'seed' else 'C0', capsize=3)
        axes.set_yticks(range(len(some)), [row['key'] for row in some])
        axes.invert_yaxis()
        axes.set(xlabel='mean kinetic energy [J], twice its standard error', xscale='log')
        drawing.plain(axes)
    return [('longrun.png', 'Methods whose bars overlap move the flag with the same vigour.')]
