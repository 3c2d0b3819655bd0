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

"""Each parameter alone, changed from its default: what it costs and what it changes."""
from collections.abc import Iterator
from pathlib import Path

from flag_sim.cloth.solvers import SOLVERS
from flag_sim.declarations.factories import cloth_of
from flag_sim.study import plots as drawing
from flag_sim.study.measures import trials
from flag_sim.study.measures.errors import MOTION, PICTURE
from flag_sim.study.measures.reference import WINDOW
from flag_sim.study.measures.settings import changed
from flag_sim.study.measures.summary import Rows
from flag_sim.study.measures.trials import BEST
from flag_sim.study.report import median_and_quartiles, table
from flag_sim.study.runner import Batch
from flag_sim.study.sections import sweep
from flag_sim.study.store import Store
PLACE, NAME, SHARE = 5, 'parameters', 2.0
COLUMNS = (7, 13, 16, 25, 61, 121)
SOFTER = (0.5, 0.25, 0.1)  # substeps_limit, as parts of the steps that the default asks for
DEFAULT = 'default'
DRAWING = ('samples', 'shading', 'interpolation', 'hidden_surface', 'size', 'drawing threads')
"""Parameters that change the picture only."""


def settings():
    """Return {name: settings}, the parameter's name before the equals sign."""
    demanded = cloth_of(trials.BASE).advance(1.0 / trials.BASE['rate']).demanded
    limits = [max(1, round(part * demanded)) for part in SOFTER]
    changes = {
        DEFAULT: {},
        **{f'solver={name}': {'solver': name} for name in SOLVERS
           if name != trials.BASE['solver']},
        'step_safety=0.45': {'step_safety': 0.45},
        'precision=float32': {'precision': 'float32'},
        'physics threads=2': {'threads': 2},
        **{f'substeps_limit={limit}': {'substeps_limit': limit} for limit in limits},
        **{f'samples={count}': {'samples': count} for count in (4, 8, 16)},
        'shading=flat': {'shading': 'flat'},
        'interpolation=perspective': {'interpolation': 'perspective'},
        'hidden_surface=painter': {'hidden_surface': 'painter'},
        'size=320 x 240': {'width': 320, 'height': 240},
        'size=1280 x 960': {'width': 1280, 'height': 960},
        'drawing threads=2': {'drawing.threads': 2},
    }
    return {**{name: changed(trials.BASE, change) for name, change in changes.items()},
            **{f'grid={columns} x {trials.rows_for(columns)}': trials.with_grid(columns)
               for columns in COLUMNS}}


def batches(store: Store) -> Iterator[Batch]:
    """Run every setting through window after window."""
    return sweep.batches(store, settings(), _measured, trials.window_numbers(store.folder))


def _measured(base, settings, window):
    return base.row(settings, window) | base.still(settings, window)


def _groups(found):
    """Return the names of the settings that change the motion, and of those of the picture."""
    draws = {name: name.partition('=')[0] in DRAWING for name in found}
    return ([name for name in found if not draws[name]],
            [name for name in found if draws[name] or name == DEFAULT])


def text(rows: Rows) -> str:
    """Return a table of all parameters."""
    found = sweep.summarised(rows)

    def lines(names, time, columns, with_rank=False):
        return [[*name.partition('=')[::2], *median_and_quartiles(found[name][time]),
                 *(found[name][column] for column in columns),
                 *([sweep.rank(found[name], rows)] if with_rank else [])] for name in names]

    motions, pictures = _groups(found)
    of_motion = lines(motions, 'physics_ms', (*MOTION, *PICTURE), with_rank=True)
    of_picture = lines(pictures, 'drawing_ms', [f'drawing_{name}' for name in PICTURE])
    motion_titles, picture_titles = ([one.title for one in measures.values()]
                                     for measures in (MOTION, PICTURE))
    return f"""## Each parameter alone

One parameter is changed from its default at a time. Errors after {1e3 * WINDOW:.0f} ms against
the reference. {sweep.noise(rows)}

{table(['parameter', 'value', 'physics ms', 'quartiles', *motion_titles, *picture_titles, ''],
       of_motion)}

PSNR and SSIM here are of the picture of the moved cloth. 'below rank': less than ten times
the reference's own error of {sweep.own_error(rows):.2g} px. A softer cloth
(`substeps_limit`, `xpbd`) may be **nearer** to the reference than a more exact one of the same
grid: the fine sheet yields in folds that are too small for the coarse grid, and a cloth that
yields more is then more like it.

What the drawing alone does, of the reference's own vertices, against the reference's picture
({', '.join(f'{name} {BEST[name]}' for name in ('samples', 'interpolation', 'hidden_surface'))});
other sizes are shown at {trials.BASE['width']} x {trials.BASE['height']}:

{table(['parameter', 'value', 'drawing ms', 'quartiles', *picture_titles], of_picture)}
"""


def plots(rows: Rows, folder: Path) -> Iterator[tuple[str, str]]:
    """Draw what each parameter does to error and cost."""
    found = sweep.summarised(rows)
    with drawing.figure(folder / 'parameters.png', columns=2, rows=2, size=(6.0, 4.2),
                        sharey='row') as (_, axes):
        for (left, right), names, column, label, cost in zip(
                axes, _groups(found), ('rms_px', 'drawing_psnr_db'),
                (f'RMS error after {1e3 * WINDOW:.0f} ms [px]', 'PSNR of the drawing [dB]'),
                ('physics_ms', 'drawing_ms')):
            names = [name for name in names if found[name][cost]]
            styles = [{'color': {DEFAULT: 'C3', 'solver=seed': 'black'}.get(name, 'C0')}
                      for name in names]
            drawing.dot_chart(left, names, [(name, found[name][column], None, style)
                                            for name, style in zip(names, styles)], label)
            drawing.dot_chart(right, names, [
                (name, found[name][cost][1], found[name][cost][::2], style)
                for name, style in zip(names, styles)],
                f'{cost.partition("_")[0]} of a frame [ms], quartiles')
            left.axvline(found[DEFAULT][column], color='C3', alpha=0.3)
            right.axvline(found[DEFAULT][cost][1], color='C3', alpha=0.3)
            right.set_xscale('log')
        axes[0][0].set_xscale('log')
        drawing.decimal_ticks(*axes.flat)
    yield 'parameters.png', ('Each parameter alone, red: the default. Above, parameters of the '
                             'motion: less error is left, less cost is left. Below, parameters '
                             'of the drawing: a better picture is right.')
