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
What each term is worth: the motion, the picture and the time without it.

By the same three measures as settings, with the default run, which has the term, as the reference.
The control shows what they are where nothing but the last digits differ.
"""
from collections.abc import Iterator

from flag_sim.study import plots as drawing
from flag_sim.study.measures import errors
from flag_sim.study.measures.ablation_runs import AblationRuns, VISIBLE, WINDOW, WINDOWS
from flag_sim.study.measures.ablation_terms import SHOTS, TERMS
from flag_sim.study.measures.settings import rendered
from flag_sim.study.report import number, table
from flag_sim.study.runner import Batch
from flag_sim.study.store import Store
import numpy as np

PLACE, NAME, SHARE = 4, 'ablation', 4.0
SHORTEST = 0.01  # share of pixels [%] at which the plot begins; what is below stands there
APART = 1.0  # time since both runs of two pictures were in the same state [s]
COLUMNS = 4  # of the sheet of pictures
SHRUNK = 2  # pixels of a picture that one of the sheet stands for, along each side
GAP = 4  # between two pictures [pixel]
BY_NAME = {term.name: term for term in TERMS}


def batches(store: Store) -> Iterator[Batch]:
    """Measure one row for each term and shot, all terms in their first shot first."""
    del store
    for place in range(max(len(term.shots) for term in TERMS)):
        for term in TERMS:
            for shot in term.shots[place:place + 1]:
                yield Batch(f'{term.name}, {shot}', [{'term': term.name, 'shot': shot}], measured)


def measured(term, shot):
    """Return the numbers of a term in a shot, by their names: see AblationRuns."""
    return AblationRuns(BY_NAME[term], SHOTS[shot]).measured()


def text(store: Store) -> str:
    """Return the text with the table of terms."""
    rows, lines = store.rows(NAME), []
    for row in sorted(rows, key=lambda row: list(BY_NAME).index(row['term'])):
        saved = saving(row)
        lines.append([
            row['term'], row['shot'], row['px_rms'] if row['px_rms'] is None else
            f'{number(row["px_rms"])} ({number(row["px_worst"])})', row['behaves'],
            row['rests'], None if row['changed'] is None else 100.0 * row['changed'],
            row['ms_with'], saved and f'{round(saved[0], 2) + 0.0:.2f} ± {saved[1]:.2f}',
            BY_NAME[row['term']].why])
    known = {(row['term'], row['shot']) for row in rows}
    missing = [f'{term.name} ({", ".join(shots)})' for term in TERMS if (
        shots := [shot for shot in term.shots if (term.name, shot) not in known])]
    return TEXT + '\n\n' + table(
        ['term', 'shot', 'follows: px RMS (worst)', 'behaves', 'rests: mm/s', 'pixels changed, %',
         'with it, ms', 'saved without, ms', 'by default'], lines) + (
        f'\n\nNot measured for lack of time: {", ".join(missing)}.' if missing else '')\
        if rows else ''


def saving(row):
    """
    Return how much shorter [ms] a frame is without the term, and the spread of both times.

    None where the times tell nothing.
    """
    if row['ms_with'] is None:
        return None
    return (row['ms_with'] - row['ms_without'],
            max(row['spread_ms_with'], row['spread_ms_without']))


TEXT = f"""## What each effect is worth

Each term of the model and of the light is switched off alone (those that are off by default: on),
and measured as above, with the run that has it as the reference. Follows: pixels after
{WINDOW:g} s, at the ends of {WINDOWS} windows that begin from the same states. Behaves: 1 is what
other gusts change, which are of 0.3 where the shot has none; the control, "nothing", begins a
nanometre aside. Rests: without the term.
Pixels changed by at least {VISIBLE} levels: of the pictures at the windows' ends. Times: processor
time of frames taken in turns with and without, of the physics where the motion changes, else of
the drawing, with the larger interquartile range of both: a saving below it is none.

"Wind relative to the cloth" keeps the quadratic law and leaves the cloth's own velocity out of
it; no parameter does that, so that it has no time. The two rows of other laws have a density, or a
wind, in which they press as hard on a face at rest that is square to the shot's mean wind; at
other angles and in gusts their pressures differ."""


def plots(store: Store) -> Iterator[tuple[str, str]]:
    """Draw what each term changes and costs, and how the flag looks without it."""
    rows, folder = store.rows(NAME), store.folder
    known = {row['term'] for row in rows}
    terms = [term for term in TERMS if term.name in known]
    if len(terms) < 2:
        return
    _draw_worth(rows, [term.name for term in terms], folder / 'ablation.png')
    yield 'ablation.png', (
        'Left: how much of the picture each term changes. Right: the time that it costs. More '
        'samples cost time and change little in the default shot; they are off by default.')
    _draw_pictures(folder / 'ablation-pictures.png', terms)
    yield 'ablation-pictures.png', (
        f'The same moment with each term (left) and without it (right), {APART:g} s after both '
        'were in the same state; * marks the default.')


def _draw_worth(rows, names, path):
    """Draw the share of changed pixels, and the time of a frame that each term takes."""
    with drawing.figure(path, 2, 1, (5.0, 1.0 + 0.27 * len(names)), sharey=True) as (
            figure, (left, right)):
        changed, costs, markers = [], [], dict(zip(SHOTS, zip('os^DvP*', drawing.COLORS)))
        for row in sorted(rows, key=lambda row: list(SHOTS).index(row['shot'])):
            marker, color = markers[row['shot']]
            style = {'fmt': marker, 'color': color, 'label': row['shot']}
            if row['changed'] is not None:
                percent = max(100.0 * row['changed'], SHORTEST)
                changed.append((row['term'], percent, None, style))
                if saving(row):
                    saved, spread = saving(row)
                    costs.append((row['term'], saved, 0.5 * spread, {**style, 'capsize': 0}))
        drawing.dot_chart(left, names, changed,
                          f'pixels changed [%] ({SHORTEST:g} and less at the edge)')
        drawing.dot_chart(right, names, costs, 'time of a frame with the term less without [ms]')
        left.set_xscale('log')
        right.set_xscale('symlog', linthresh=0.1)
        right.axvline(0.0, color='#808080', linewidth=0.8)
        for axes in (left, right):
            axes.grid(alpha=0.3)
        handles, labels = left.get_legend_handles_labels()
        by_label = dict(zip(labels, handles))  # one for each shot
        figure.legend(by_label.values(), by_label, loc='outside lower center', ncols=4,
                      frameon=False)


def _draw_pictures(path, terms):
    """Draw the terms with and without side by side, each in the shot where it matters most."""
    rows = -(-len(terms) // COLUMNS)
    with drawing.figure(path, COLUMNS, rows, (3.4, 1.5), squeeze=False) as (_, grid):
        for axes in grid.flat:
            axes.set_axis_off()
        for axes, term in zip(grid.flat, terms):
            axes.imshow(_pair(term))
            words = 'on | off*' if term.on else 'on* | off'
            axes.set_title(f'{term.name}, {term.shots[-1]}: {words}', fontsize='small')


def _pair(term):
    """Return both pictures, side by side with a gap, (height, ..., 3) uint8; white if diverged."""
    runs = AblationRuns(term, SHOTS[term.shots[-1]])
    found = []
    for settings, positions in zip(runs.settings, runs.ends(runs.starts(1)[0], APART)):
        height, width = (settings[side] // SHRUNK for side in ('height', 'width'))
        found.append(np.full((height, width, 3), 255, np.uint8) if positions is None else
                     errors.resized(rendered(settings, positions), height, width))
    gap = np.full((height, GAP, 3), 255, np.uint8)
    return np.concatenate([found[0], gap, found[1]], axis=1)
