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

"""Drawing of plots: the only module that imports matplotlib, and only when it draws."""
import contextlib
import importlib.util

from flag_sim.cloth.solvers import SOLVERS
import numpy as np

MISSING = ("Plots are missing: matplotlib is not installed (pip install 'flag_sim[study]', or the "
           'package python3-matplotlib).')


def can_draw():
    """Return whether matplotlib is installed."""
    return importlib.util.find_spec('matplotlib') is not None


@contextlib.contextmanager
def figure(path, columns=1, rows=1, size=(7.0, 4.5), **options):
    """
    Yield (figure, axes) to draw on, then write it to `path` as PNG.

    size: of one of columns x rows axes [inch]; options: of matplotlib's subplots. Axes must be
    given labels with their units.
    """
    # The figure alone, without pyplot: no window, no state that another plot could meet.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image  # matplotlib needs it too
    drawn = Figure(figsize=(size[0] * columns, size[1] * rows), dpi=110, layout='constrained')
    canvas = FigureCanvasAgg(drawn)
    axes = drawn.subplots(rows, columns, **options)
    yield drawn, axes
    canvas.draw()
    # A palette makes a file a third as long.
    Image.fromarray(np.asarray(canvas.buffer_rgba())).convert('RGB').quantize().save(
        path, optimize=True)


def plain(*axes):
    """Write 0.5 and 20 at logarithmic axes, not powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator
    for axis in axes:
        for one in (axis.xaxis, axis.yaxis):
            if one.get_scale() == 'log':
                low, high = one.get_view_interval()
                few = (1.0, 2.0, 5.0) if high > 30.0 * low else (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)
                one.set_major_locator(LogLocator(subs=few))
                one.set_major_formatter(FuncFormatter(lambda value, _: f'{value:g}'))
                one.set_minor_formatter(FuncFormatter(lambda *_: ''))


METHODS = list(SOLVERS)


def style(method):
    """Return the colour and marks by which a method is known in every plot."""
    if method == 'seed':
        return {'color': 'black', 'marker': 'X', 'ls': '--'}
    index = METHODS.index(method) if method in METHODS else len(METHODS)
    return {'color': f'C{index}', 'marker': 'osD^vP*p'[index], 'ls': '-', 'ms': 4}
