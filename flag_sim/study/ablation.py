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

The motion is chaotic: two runs that differ in anything part in a second or two, to wherever they
like. So the change of the motion is taken twice. Over short windows, which begin from the same
states of the run with the term; and, from a long run, of its mean shape and kinetic energy. The
control shows what both are where nothing but the last digits differ.
"""
from flag_sim.dials.settings import look_of
from flag_sim.study import error, gallery, plots as drawing, report
from flag_sim.study.pairs import LONG, Pairs, SPIN_UP, WINDOW, WINDOWS
from flag_sim.study.settings import DEFAULTS, picture_of
from flag_sim.study.terms import settings_of, SHOTS, TERMS
import numpy as np

NAME = 'ablation'
SHARE = 3.0

VISIBLE = 3
"""Levels of 255 by which a channel of a pixel must change for the pixel to count as changed."""
SHORTEST = 0.01
"""Share of pixels [%] at which the plot begins; what is below stands there."""


def run(store, budget):
    """Measure one row for each term and shot, all terms in their first shot first."""
    for place in range(max(len(term.shots) for term in TERMS)):
        for term in TERMS:
            if place >= len(term.shots):
                continue
            shot = term.shots[place]
            key = f'{term.name}/{shot}'
            if store.has(NAME, key):
                continue
            if not budget.allows():
                return
            store.add(NAME, {'key': key, 'term': term.name, 'shot': shot,
                             **measure(term, SHOTS[shot])})
            budget.say(f'{term.name}, {shot}')


def measure(term, scene):
    """
    Return a row of numbers for a term in a scene {dial: value}.

    px_rms, px_worst: at the windows' ends, as the camera sees it; shape_px: RMS distance of the
    mean shapes; energy: mean kinetic energy without, over with; psnr_db, ssim, levels (mean
    absolute), changed (share of pixels): of the pictures at the windows' ends; ms and spread_ms
    with and without: median and interquartile range of a frame's time, of the physics or the
    drawing or both, whichever has other dials. None where the motion is the same, or diverged,
    and for times that tell nothing.
    """
    settings = settings_of(term, scene)
    moves = bool(term.nudge or term.remake) or _differ(*settings, ('physics', 'wind'))
    row = dict.fromkeys(('px_rms', 'px_worst', 'shape_px', 'energy'))
    pairs = Pairs(*settings, term.nudge, term.remake)
    starts = pairs.starts()
    ends = [pairs.ends(start) if moves else (start.positions, start.positions)
            for start in starts]
    camera = look_of(settings[0]).camera
    whole = [end for end in ends if end[1] is not None]
    if moves and whole:
        apart = np.concatenate([error.pixel_distances(off, on, camera) for on, off in
                                (pairs.common(*end) for end in whole)])
        row |= {'px_rms': error.rms(apart), 'px_worst': float(apart.max())}
        row |= pairs.statistics(starts[0], camera)
    row |= pictures(settings, whole)
    times = pairs.times(starts[-1], moves, _differ(*settings, ('renderer',)))
    return row | (dict.fromkeys(times) if term.remake else times)


def _differ(one, other, nodes):
    """Return whether settings differ in a dial of these nodes."""
    return any(one[dial] != other[dial] for node in nodes for dial in DEFAULTS[node])


def pictures(settings, ends):
    """
    Return by how much the pictures of both runs differ at all the windows' ends together.

    ends: pairs of positions (rows, columns, 3) [m].
    """
    row = dict.fromkeys(('psnr_db', 'ssim', 'levels', 'changed'))
    if not ends:
        return row
    on, off = ([picture_of(one).draw(end[which], None, *look_of(one)).colour for end in ends]
               for which, one in enumerate(settings))
    apart = np.abs(np.int16(on) - np.int16(off))
    ssims = [error.ssim(*pair) for pair in zip(off, on)]
    values = (error.psnr(np.concatenate(off), np.concatenate(on)), np.mean(ssims), apart.mean(),
              (apart.max(axis=-1) >= VISIBLE).mean())
    return dict(zip(row, map(float, values)))


def section(rows):
    """Return the text with the table of terms."""
    whys = {term.name: term.why for term in TERMS}
    order = {term.name: place for place, term in enumerate(TERMS)}
    lines = []
    for row in sorted(rows, key=lambda row: order[row['term']]):
        saved = saving(row)
        lines.append([
            row['term'], row['shot'], _pair(row['px_rms'], row['px_worst']), row['shape_px'],
            row['energy'], row['psnr_db'], row['levels'],
            None if row['changed'] is None else 100.0 * row['changed'],
            row['ms_with'], saved and f'{round(saved[0], 2) + 0.0:.2f} ± {saved[1]:.2f}',
            whys[row['term']]])
    head = ['term', 'shot', 'px RMS (worst)', 'mean shape, px', 'energy', 'PSNR, dB', 'levels',
            'pixels changed, %', 'with it, ms', 'saved without, ms', 'by default']
    return TEXT + '\n\n' + report.table(head, lines, 'll' + 'r' * (len(head) - 3) + 'l')


def _pair(middle, worst):
    return None if middle is None else f'{report.number(middle)} ({report.number(worst)})'


def saving(row):
    """
    Return how much shorter [ms] a frame is without the term, and the spread of both times.

    None where the times tell nothing.
    """
    if row['ms_with'] is None:
        return None
    return (row['ms_with'] - row['ms_without'],
            max(row['spread_ms_with'], row['spread_ms_without']))


TEXT = f"""## What a scene requires

Each term of the model and of the light is switched off alone (those that are off by default: on),
and compared with the run that has it. Pixels: of the shot's camera, at the ends of {WINDOWS}
windows of {WINDOW:g} s that begin from the same states. Mean shape and kinetic energy (without,
over with): of a run of {LONG:g} s, but its first {SPIN_UP:g} s; to be compared with those of the
control, "nothing", which are what chaos alone changes. PSNR, mean absolute levels, and pixels
changed by at least {VISIBLE} levels: of the pictures at the windows' ends. Times: medians of
frames taken in turns with and without, of the physics where the motion changes, else of the
drawing, with the larger interquartile range of both: a saving below it is none.

"Wind relative to the cloth" keeps the quadratic law and leaves the cloth's own velocity out of it;
no dial does that, so that it has no time. The two rows of other laws change more than one thing:
the linear law has a density, and the course project's law (`air.law: seed`) a wind, in which it
presses as hard on a face at rest that is square to the shot's mean wind. At other angles and in
gusts their pressures differ."""


def plots(rows, folder):
    """Draw what each term changes and costs, and how the flag looks without it."""
    known = {row['term'] for row in rows}
    terms = [term for term in TERMS if term.name in known]
    _draw_worth(rows, [term.name for term in terms], folder / 'ablation.png')
    gallery.draw(folder / 'ablation-pictures.png', terms)
    return [
        ('ablation.png', 'Left: how much of the picture each term changes. Right: the time that '
         'it costs. Pole collision and more samples cost time and change little in the default '
         'shot; they are off by default.'),
        ('ablation-pictures.png', f'The same moment with each term (left) and without it (right), '
         f'{gallery.APART:g} s after both were in the same state; * marks the default.')]


def _draw_worth(rows, names, path):
    """Draw the share of changed pixels, and the time of a frame that each term takes."""
    shots = [shot for shot in SHOTS if any(row['shot'] == shot for row in rows)]
    with drawing.figure(path, 2, 1, (5.0, 1.0 + 0.27 * len(names)), sharey=True) as (
            figure, (seen, dear)):
        for shot, marker, color in zip(shots, 'os^DvP*', COLORS):
            own = [row for row in rows if row['shot'] == shot and row['changed'] is not None]
            at = [names.index(row['term']) for row in own]
            look = {'marker': marker, 'color': color, 'linestyle': 'none', 'label': shot}
            seen.plot([max(100.0 * row['changed'], SHORTEST) for row in own], at, **look)
            timed = [(saving(row), place) for row, place in zip(own, at) if saving(row)]
            if timed:
                savings, at = zip(*timed)
                dear.errorbar([saved for saved, _ in savings], at,
                              xerr=[0.5 * spread for _, spread in savings], **look)
        seen.set_xscale('log')
        seen.set_xlabel(f'pixels changed [%] ({SHORTEST:g} and less at the edge)')
        dear.set_xscale('symlog', linthresh=0.1)
        dear.set_xlabel('time of a frame with the term less without [ms]')
        dear.axvline(0.0, color='#808080', linewidth=0.8)
        seen.set_yticks(range(len(names)), names)
        seen.invert_yaxis()
        for axes in (seen, dear):
            axes.grid(alpha=0.3)
        figure.legend(*seen.get_legend_handles_labels(), loc='outside lower center', ncols=4,
                      frameon=False)


COLORS = ('#0072b2', '#e69f00', '#000000', '#d55e00', '#009e73', '#cc79a7', '#56b4e9')
"""Okabe and Ito's, apart for the colour-blind; the markers differ too."""
