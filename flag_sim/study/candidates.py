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

"""The candidates of tune: grids and methods that it tries, and the scenes that it can tune."""
from flag_sim.declarations.factories import cloth_of, look_of
from flag_sim.parameters import checks
from flag_sim.study.measures import errors
from flag_sim.study.measures.judge import work
from flag_sim.study.measures.reference import nested, on_grid
from flag_sim.study.measures.settings import Settings

COARSEST = 7     # columns of the coarsest grid that is tried
MAX_WORK = 1e9   # nodes times steps of a second that the coarsest reference may take
CHOSEN = ('rate', 'grid.columns', 'grid.rows', 'damping', 'solver', 'substeps',
          'substeps_limit', 'step_safety', 'precision')
"""
The parameters that are chosen.

Not threads: they would be taken from the renderer, which draws one frame while the next moves.
"""
BETWEEN = (8, 12, 16)
"""Of grids of 3 n x 2 n cells, between those that are nested in the reference's."""
YOURS = 'your own settings'


def methods() -> dict[str, Settings]:
    """Return {name: changes}: steps that keep the material as it is, and friction in it."""
    exact = {'solver': 'symplectic', 'substeps': 0, 'precision': 'float64'}
    return {
        'symplectic float32': {**exact, 'precision': 'float32'},
        'symplectic': exact,
        'verlet': {**exact, 'solver': 'verlet'},
        **{f'{name} {steps}': {**exact, 'solver': name, 'substeps': steps,
                               'substeps_limit': steps}
           for name, steps in (('xpbd', 5), ('implicit', 5), ('implicit', 10))},
    }


def require(settings: Settings) -> None:
    """
    Raise ValueError for settings that make no scene, or that cannot be tuned.

    Their camera must see the flag, all methods must take their air, for they are compared, and
    the reference must not take hours.
    """
    if settings['air.added_mass'] > 0.0:
        raise ValueError('air.added_mass must be 0 here, not '
                         f'{checks.text(settings["air.added_mass"])}: methods are compared, and '
                         'most do not take moving air')
    at_rest = cloth_of(settings).positions
    errors.pixel_distances(at_rest, at_rest, look_of(settings).camera)
    coarsest = work(settings, 21, 31)
    if coarsest > MAX_WORK:
        raise ValueError(
            f'a reference may take {MAX_WORK:.0e} nodes times steps a second, and this sheet '
            f'needs {coarsest:.1e} on 31 x 21 nodes: lower its stiffness or damping')


def candidates(settings: Settings, finest: tuple[int, int]) -> dict[str, Settings]:
    """
    Return {name: settings}: the user's own, and every method on every grid.

    finest: rows and columns of the reference, which grids are coarser than.
    """
    found, half = {YOURS: settings}, (finest[0] + 1) // 2
    between = [(2 * n + 1, 3 * n + 1) for n in BETWEEN if 2 * n < half]
    for rows, columns in [*nested(finest), *between]:
        if columns < COARSEST:
            continue
        for method, changes in methods().items():
            found[f'{columns} x {rows}, {method}'] = on_grid(settings, rows, columns, **changes)
    return found
