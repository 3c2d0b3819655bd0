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

"""Drawing of stability maps: a panel for each method, with the line of theory over it."""
import math

from flag_sim.study import plots
from flag_sim.study.measures import stability_trial as trial
import numpy as np

LETTERS = {trial.STABLE: 's', trial.SOFTENED: 'l', trial.REACH: 'r', trial.HELD: 'h',
           trial.DIVERGING: 'd'}
"""What stands for an outcome in a row of a map."""
BROKEN = {LETTERS[trial.HELD], LETTERS[trial.DIVERGING]}

# Okabe and Ito's colours, apart for the colour-blind, and also in grey from light to dark.
COLORS = {trial.STABLE: '#f2f2f2', trial.SOFTENED: '#56b4e9', trial.REACH: '#f0e442',
          trial.HELD: '#d55e00', trial.DIVERGING: '#000000'}
LINE = '#cc79a7'
REFUSED = {'color': 'black', 'linestyle': ':', 'linewidth': 1.5}  # the line of max_gap
LINE_LEVEL = 4  # of refinement, for the line


def draw(path, chart, panels, longest=None):
    """
    Draw a Map's panels {solver: rows, by y} to a file, with a line where its bound is one.

    longest: the y [s] beyond which the physics node refuses frames, drawn if given.
    """
    columns = min(len(panels), 3 if len(panels) <= 6 else 4)
    rows = -(-len(panels) // columns)
    with plots.figure(path, columns, rows, (3.5, 3.1), squeeze=False, sharex=True,
                      sharey=True) as (figure, grid):
        seen = set()
        for axes, (solver, lines) in zip(grid.flat, panels.items()):
            seen |= _panel(axes, chart, lines)
            _theory(axes, chart, solver)
            if longest:
                axes.axhline(math.log10(longest), **REFUSED)
            axes.set_title(solver)
        for axes in grid.flat[len(panels):]:
            axes.set_visible(False)
        for axes in grid.flat[max(0, len(panels) - columns):len(panels)]:
            axes.set_xlabel(chart.x.label)
            axes.tick_params(labelbottom=True)
        for axes in grid[:, 0]:
            axes.set_ylabel(chart.y.label)
        figure.suptitle(chart.title)
        _legend(figure, seen, longest)


def _panel(axes, chart, lines):
    """Draw one method's map; return the outcomes in it."""
    from matplotlib.colors import ListedColormap
    level = lines[0]['level']
    outcomes, letters = list(LETTERS), list(LETTERS.values())
    numbers = np.array([[letters.index(letter) for letter in row['cells']] for row in lines])
    at_x, at_y = places(chart.x, level), places(chart.y, level)
    axes.pcolormesh(at_x, at_y, numbers, cmap=ListedColormap(list(COLORS.values())), vmin=-0.5,
                    vmax=len(outcomes) - 0.5)
    # Cells at the ends are shown by half, so that panels of other levels have the same frame.
    axes.set_xlim(at_x[0], at_x[-1])
    axes.set_ylim(at_y[0], at_y[-1])
    for axis, of in ((axes.xaxis, chart.x), (axes.yaxis, chart.y)):
        _ticks(axis, of)
    return {outcomes[number] for number in np.unique(numbers)}


def _theory(axes, chart, solver):
    """
    Draw where the bound is one, if there it is.

    It is a power of the step or does not depend on y, so that two values of y will do.
    """
    ends = (chart.y.low, chart.y.high)
    fine = chart.x._replace(has_zero=False)
    reach = np.array([[chart.bound(solver, x, y) for x in fine.values(LINE_LEVEL)] for y in ends])
    if np.isfinite(reach).all():
        axes.contour(places(fine, LINE_LEVEL), np.log10(ends), np.log(reach), [0.0],
                     colors=LINE, linewidths=2.0)


def places(axis, level):
    """Return where an axis' values stand in a drawing: their logarithms, zero a bit before."""
    values = [math.log10(value) for value in axis.values(level) if value > 0.0]
    return np.array([_zero(axis)] * axis.has_zero + values)


def _zero(axis):
    """Return where zero stands."""
    return math.log10(axis.low) - 0.12 * math.log10(axis.high / axis.low)


def _ticks(axis, of):
    """Name the powers of ten, at most seven of them, and zero."""
    first, last = math.ceil(math.log10(of.low) - 1e-9), math.floor(math.log10(of.high) + 1e-9)
    powers = range(first, last + 1, -(-(last - first) // 6))
    zero = [_zero(of)] if of.has_zero else []
    axis.set_ticks([*zero, *powers])
    axis.set_ticklabels(['0'] * of.has_zero + [f'$10^{{{power}}}$' for power in powers])


def _legend(figure, seen, longest):
    """Name the outcomes that are seen, and the lines."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    handles = [Patch(facecolor=COLORS[outcome], edgecolor='#808080', label=text)
               for outcome, text in trial.OUTCOMES.items() if outcome in seen]
    handles.append(Line2D([], [], color=LINE, linewidth=2.0, label='bound of theory'))
    if longest:
        handles.append(Line2D([], [], **REFUSED, label=(
            f'max_gap ({longest:g} s): longer frames are refused by default')))
    figure.legend(handles=handles, loc='outside lower center', ncols=3, frameon=False)
