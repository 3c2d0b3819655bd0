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

"""Part: each dial alone, turned away from its default: what it costs and what it changes."""
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.dials.settings import cloth_of
from flag_sim.study import plots as drawing, report, scene, sweep
from flag_sim.study.reference import WINDOW
from flag_sim.study.settings import changed
from flag_sim.study.trial import BEST

NAME = 'dials'
SHARE = 2.0
COLUMNS = (7, 13, 16, 25, 61, 121)
SOFTER = (0.5, 0.25, 0.1)
"""substeps_limit, as parts of the steps that the default asks for."""
DEFAULT = 'default'
DRAWING = ('samples', 'shading', 'interpolation', 'hidden_surface', 'size', 'drawing threads')
"""Dials that change the picture only."""


def settings():
    """Return {name: settings}, the dial's name before the equals sign."""
    demanded = cloth_of(scene.BASE).advance(1.0 / scene.BASE['rate']).demanded
    changes = {
        DEFAULT: {},
        **{f'solver={name}': {'solver': name} for name in SOLVERS
           if name != scene.BASE['solver']},
        'step_safety=0.45': {'step_safety': 0.45},
        'precision=float32': {'precision': 'float32'},
        'physics threads=2': {'threads': 2},
        **{f'substeps_limit={max(1, round(part * demanded))}':
           {'substeps_limit': max(1, round(part * demanded))} for part in SOFTER},
        **{f'samples={count}': {'samples': count} for count in (4, 8, 16)},
        'shading=flat': {'shading': 'flat'},
        'interpolation=perspective': {'interpolation': 'perspective'},
        'hidden_surface=painter': {'hidden_surface': 'painter'},
        'size=320 x 240': {'width': 320, 'height': 240},
        'size=1280 x 960': {'width': 1280, 'height': 960},
        'drawing threads=2': {'drawing.threads': 2},
    }
    return {**{name: changed(scene.BASE, change) for name, change in changes.items()},
            **{f'grid={columns} x {one["grid.rows"]}': one
               for columns in COLUMNS for one in [scene.with_grid(columns)]}}


def run(store, budget):
    """Run every setting through window after window."""
    sweep.run(store, budget, NAME, settings(), _row, scene.windows(store))


def _row(own, settings, window):
    row, positions = own.motion(settings, window)
    return {**row, **own.picture(settings, positions, window), **own.still(settings, window)}


def section(rows):
    """Return a table of all dials."""
    found = sweep.summarised(rows)
    own = sweep.own_of(rows)
    motion, picture = [], []
    for name, one in found.items():
        dial, _, value = name.partition('=')
        if dial not in DRAWING:
            motion.append([dial, value, *_times(one, 'physics_ms'), one['rms_mm'],
                           one['worst_mm'], one['rms_px'], one['worst_px'], one['psnr_db'],
                           one['ssim'], '' if one['rms_px'] >= 10.0 * own else 'below rank'])
        if dial in DRAWING or name == DEFAULT:
            picture.append([dial, value, *_times(one, 'drawing_ms'), one['drawing_psnr_db'],
                            one['drawing_ssim']])
    return f"""## Each dial alone

One dial is turned away from its default at a time. Errors after {1e3 * WINDOW:.0f} ms against
the reference. {sweep.noise(rows)}

{report.table(['dial', 'value', 'physics ms', 'quartiles', 'RMS mm', 'worst mm', 'RMS px',
               'worst px', 'PSNR dB', 'SSIM', ''], motion, 'llrlrrrrrrl')}

PSNR and SSIM here are of the picture of the moved cloth. 'below rank': less than ten times
the reference's own error of {own:.2g} px. A softer or limper cloth (`substeps_limit`, `xpbd`)
may come out **nearer** to the reference than a more exact one of the same grid: the fine sheet
gives way in folds that the coarse grid has no room for, and what yields more is then more alike.

What the drawing alone does, of the reference's own vertices, against the reference's picture
({', '.join(f'{name} {value}' for name, value in _best())}); other sizes are shown at
{scene.BASE['width']} x {scene.BASE['height']}:

{report.table(['dial', 'value', 'drawing ms', 'quartiles', 'PSNR dB', 'SSIM'], picture,
              'llrlrr')}
"""


def _best():
    return [(name, BEST[name]) for name in ('samples', 'interpolation', 'hidden_surface')]


def _times(one, column):
    """Return the median and the quartiles in words."""
    found = one[column]
    return [None, None] if found is None else [found[1], f'{found[0]:.3g} to {found[2]:.3g}']


def plots(rows, folder):
    """Draw what each dial does to error and cost."""
    found = sweep.summarised(rows)
    groups = [[name for name in found if name.partition('=')[0] not in DRAWING],
              [name for name in found
               if name == DEFAULT or name.partition('=')[0] in DRAWING]]
    with drawing.figure(folder / 'dials.png', columns=2, rows=2, size=(6.0, 4.2),
                        sharey='row') as (_, axes):
        for (left, right), names, column, label, cost in (
                (axes[0], groups[0], 'rms_px', f'RMS error after {1e3 * WINDOW:.0f} ms [px]',
                 'physics_ms'),
                (axes[1], groups[1], 'drawing_psnr_db', 'PSNR of the drawing [dB]',
                 'drawing_ms')):
            names = [name for name in names if found[name][cost]]
            for place, name in enumerate(names):
                look = {'color': {DEFAULT: 'C3', 'solver=seed': 'black'}.get(name, 'C0')}
                low, middle, high = found[name][cost]
                left.plot(found[name][column], place, 'o', **look)
                right.errorbar(middle, place, xerr=[[middle - low], [high - middle]], fmt='o',
                               capsize=3, **look)
            left.axvline(found[DEFAULT][column], color='C3', alpha=0.3)
            right.axvline(found[DEFAULT][cost][1], color='C3', alpha=0.3)
            left.set_yticks(range(len(names)), names, fontsize='small')
            left.invert_yaxis()
            left.set(xlabel=label)
            right.set(xlabel=f'{cost.partition("_")[0]} of a frame [ms], quartiles',
                      xscale='log')
        axes[0][0].set_xscale('log')
        drawing.plain(*axes.flat)
    return [('dials.png', 'Each dial alone, red: the default. Above, dials of the motion: less '
                          'error is left, less cost is left. Below, dials of the drawing: a '
                          'better picture is right.')]
