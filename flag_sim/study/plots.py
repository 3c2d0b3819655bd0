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

"""What all plots share: the only module that imports matplotlib, and only when it draws."""
from collections.abc import Iterator
import contextlib
import importlib.util
from pathlib import Path

import numpy as np

MISSING = ("Plots are missing: matplotlib is not installed (pip install 'flag_sim[study]', or the "
           'package python3-matplotlib).')
COLORS = ('#0072b2', '#e69f00', '#000000', '#d55e00', '#009e73', '#cc79a7', '#56b4e9')
"""Okabe and Ito's, which the colour-blind can tell apart; markers must differ too."""


LINES = tuple({'color': color, 'marker': marker, 'ls': dash, 'ms': 6, 'lw': 1.3}
              for color, marker, dash in zip(COLORS[2:3] + COLORS[:2] + COLORS[3:5], 'osD^v',
                                             ('-', '--', '-.', ':', (0, (5, 1, 1, 1, 1, 1)))))
"""Styles of the lines of a plot, at most so many; they differ in grey too, by mark and dash."""


def can_draw() -> bool:
    """Return whether matplotlib is installed."""
    return importlib.util.find_spec('matplotlib') is not None


@contextlib.contextmanager
def figure(path: Path, columns: int = 1, rows: int = 1, size: tuple = (7.0, 4.5),
           **options) -> Iterator[tuple]:
    """
    Yield (figure, axes) to draw on, then write it to `path` as PNG.

    size: of one of columns x rows axes [inch]; options: of matplotlib's subplots. Axes must be
    given labels with their units.
    """
    # The figure alone, without pyplot: no window, no state that another plot could meet.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    drawn = Figure(figsize=(size[0] * columns, size[1] * rows), dpi=110, layout='constrained')
    canvas = FigureCanvasAgg(drawn)
    yield drawn, drawn.subplots(rows, columns, **options)
    canvas.draw()
    save(np.asarray(canvas.buffer_rgba())[..., :3], path)


def save(picture: np.ndarray, path: Path) -> None:
    """Write a picture (height, width, 3) uint8 as PNG; a palette makes it a third as long."""
    from PIL import Image  # matplotlib needs it too
    Image.fromarray(np.ascontiguousarray(picture)).quantize().save(path, optimize=True)


WIDE = 1e5  # range of an axis, as a factor, from which on powers of ten are left to matplotlib


def decimal_ticks(*axes) -> None:
    """Write 0.5 and 20 at logarithmic axes, not powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator
    for axis in (axis for one in axes for axis in (one.xaxis, one.yaxis)):
        low, high = axis.get_view_interval()
        if axis.get_scale() == 'log' and high < WIDE * low:
            few = (1.0, 2.0, 5.0) if high > 30.0 * low else (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)
            axis.set_major_locator(LogLocator(subs=few))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f'{value:g}'))
            axis.set_minor_formatter(FuncFormatter(lambda *_: ''))


def dot_chart(axes, names: list[str], points: list[tuple], label: str) -> None:
    """
    Draw values beside their names, the first name on top.

    points: (name, value, error bars: half its length, the (low, high) end or None, style).
    """
    for name, value, bars, style in points:
        if isinstance(bars, tuple):
            bars = [[value - bars[0]], [bars[1] - value]]
        axes.errorbar(value, names.index(name), xerr=bars,
                      **{'fmt': 'o', 'capsize': 3, **style})
    axes.set_yticks(range(len(names)), names, fontsize='small')
    axes.set(xlabel=label, ylim=(len(names) - 0.5, -0.5))
