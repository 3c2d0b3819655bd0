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
from flag_sim.study import plots
from flag_sim.study.measures import stability_trial as trial
import numpy as np

# Okabe and Ito's colours, apart for the colour-blind, and also in grey from light to dark.
COLORS = dict(zip(trial.OUTCOMES, ('#f2f2f2', '#56b4e9', '#f0e442', '#d55e00', '#000000')))
BOUND_LINE = {'color': '#cc79a7', 'linewidth': 2.0}
MAX_GAP_LINE = {'color': 'black', 'linestyle': ':', 'linewidth': 1.5}
LINE_LEVEL, LINE_POINTS = 4, 200  # of the line: refinement along x, points along y


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
            seen |= set(''.join(row['cells'] for row in lines))
            _cells(axes, chart, lines)
            _bound(axes, chart, solver)
            if longest:
                axes.axhline(longest, **MAX_GAP_LINE)
            axes.set_title(solver)
        for axes in grid.flat[len(panels):]:
            axes.set_visible(False)
        for axes in grid.flat[max(0, len(panels) - columns):len(panels)]:
            axes.set_xlabel(chart.x.label)
            axes.tick_params(labelbottom=True)
        for axes in grid[:, 0]:
            axes.set_ylabel(chart.y.label)
        figure.suptitle(chart.title)
        _legend(figure, seen, longest, columns)


def _cells(axes, chart, lines):
    """Draw one method's map, on logarithmic axes that end where the values do."""
    from matplotlib.colors import ListedColormap
    letters = [outcome.letter for outcome in trial.OUTCOMES]
    numbers = [[letters.index(letter) for letter in row['cells']] for row in lines]
    edges = [_edges(axis, lines[0]['level']) for axis in (chart.x, chart.y)]
    axes.pcolormesh(*edges, numbers, cmap=ListedColormap(list(COLORS.values())), vmin=-0.5,
                    vmax=len(letters) - 0.5)
    axes.set(xscale='log', yscale='log')
    axes.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])


def _edges(axis, level):
    """Return the edges of the cells around an axis' values; the first and last are half shown."""
    values = np.array(axis.values(level))
    return np.array([axis.low, *np.sqrt(values[1:] * values[:-1]), axis.high])


def _bound(axes, chart, solver):
    """
    Draw where the bound is one, if there it is.

    It is a power of y or does not depend on it, so that its logarithm is linear in that of y.
    """
    at_x = chart.x.values(LINE_LEVEL)
    bounds = np.array([[chart.bound(solver, x, y) for x in at_x]
                       for y in (chart.y.low, chart.y.high)])
    if np.isfinite(bounds).all():
        logs = np.linspace(*np.log(bounds), LINE_POINTS)
        axes.contour(at_x, np.geomspace(chart.y.low, chart.y.high, LINE_POINTS), logs, [0.0],
                     colors=BOUND_LINE['color'], linewidths=BOUND_LINE['linewidth'])


def _legend(figure, seen, longest, columns):
    """Name the outcomes whose letters are seen, and the lines."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    handles = [Patch(facecolor=color, edgecolor='#808080', label=outcome.text)
               for outcome, color in COLORS.items() if outcome.letter in seen]
    handles.append(Line2D([], [], **BOUND_LINE, label='bound of theory'))
    if longest:
        handles.append(Line2D([], [], **MAX_GAP_LINE, label=(
            f'max_gap ({longest:g} s): longer frames are refused by default')))
    figure.legend(handles=handles, loc='outside lower center', ncols=min(3, columns),
                  frameon=False)
