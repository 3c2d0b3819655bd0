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

"""References are what they are said to be."""
from flag_sim.cloth.model import Model
from flag_sim.declarations.factories import cloth_of
from flag_sim.study.measures import reference, settings
from flag_sim.study.measures.reference import nested, on_grid, Reference
import numpy as np
import pytest

FINEST = (17, 25)


@pytest.fixture(scope='module')
def base():
    """Return settings on a coarse grid nested in FINEST."""
    return settings.changed(settings.defaults(gust__intensity=0.3),
                            {'grid.rows': 9, 'grid.columns': 13})


@pytest.fixture
def soon(monkeypatch):
    """Let windows come soon after the flag is laid out."""
    for name, value in (('SPIN_UP', 0.2), ('SPACING', 0.1), ('LEAD', 1.0 / 30.0)):
        monkeypatch.setattr(reference, name, value)


def test_an_unknown_parameter_is_refused():
    """By its name."""
    with pytest.raises(ValueError, match='no parameter stifness'):
        settings.defaults(stifness=1.0)


def test_grids_are_nested_and_the_sheet_is_the_same(base):
    """Dashpots do not depend on the grid; each node of a coarser grid is one of a finer."""
    assert (9, 13) in nested(FINEST) and FINEST not in nested(FINEST)
    dashpots = []
    for rows, columns in [*nested(FINEST), FINEST]:
        assert (FINEST[0] - 1) % (rows - 1) == (FINEST[1] - 1) % (columns - 1) == 0
        cloth = cloth_of(on_grid(base, rows, columns))
        dashpots.append(Model(cloth.mesh, cloth.material).spring_c)
    # Products of a few factors: some units in the last place.
    assert dashpots == [pytest.approx(dashpots[0], rel=1e-12)] * len(dashpots)


def test_a_window_is_the_same_however_it_comes(base, soon, tmp_path):
    """Made in order, made alone, and read from the disk: bit by bit."""
    first = Reference(base, 2, tmp_path / 'windows', FINEST)
    made = [first.window(number) for number in (0, 1)]
    again = Reference(base, 2, tmp_path / 'windows', FINEST)
    alone = Reference(base, 2, tmp_path / 'alone', FINEST)
    for other in (again.window(1), alone.window(1)):
        for ours, theirs in zip(made[1], other):
            assert np.array_equal(ours, theirs)
    assert made[0].ends.shape == (2, *FINEST, 3)


def test_starts_are_taken_over_exactly(base, soon, tmp_path):
    """A node of a coarse grid has the very place and speed of the reference's node."""
    own = Reference(base, 1, tmp_path / 'windows', FINEST)
    window = own.window(0)
    cloth = own.start(window, base)
    assert np.array_equal(cloth.positions, window.positions[::2, ::2])
    assert np.array_equal(cloth.velocities[:, 1:], window.velocities[::2, ::2][:, 1:])
