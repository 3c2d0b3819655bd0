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

"""A sheet of pictures: the same moment with each term and without it."""
from flag_sim.dials.settings import look_of
from flag_sim.study import error, plots
from flag_sim.study.pairs import Pairs
from flag_sim.study.settings import picture_of
from flag_sim.study.terms import settings_of, SHOTS
import numpy as np

APART = 1.0
"""Time since both runs were in the same state [s]."""
COLUMNS = 4
SHRUNK = 2
"""Pixels of a picture that one of the sheet stands for, along each side."""
GAP = 4
"""Between two pictures [pixel]."""


def draw(path, terms):
    """Draw the terms with and without side by side, each in the shot where it matters most."""
    rows = -(-len(terms) // COLUMNS)
    with plots.figure(path, COLUMNS, rows, (3.4, 1.5), squeeze=False) as (_, grid):
        for axes in grid.flat:
            axes.set_axis_off()
        for axes, term in zip(grid.flat, terms):
            axes.imshow(pair(term))
            words = 'on | off*' if term.on else 'on* | off'
            axes.set_title(f'{term.name}, {term.shots[-1]}: {words}', fontsize='small')


def pair(term):
    """Return both pictures, side by side with a gap, (height, ..., 3) uint8; white if diverged."""
    settings = settings_of(term, SHOTS[term.shots[-1]])
    pairs = Pairs(*settings, term.nudge, term.remake)
    found = []
    for one, positions in zip(settings, pairs.ends(pairs.starts(1)[0], APART)):
        height, width = (one[side] // SHRUNK for side in ('height', 'width'))
        found.append(np.full((height, width, 3), 255, np.uint8) if positions is None else
                     error.resized(picture_of(one).draw(positions, None, *look_of(one)).colour,
                                   height, width))
    gap = np.full((height, GAP, 3), 255, np.uint8)
    return np.concatenate([found[0], gap, found[1]], axis=1)
