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

"""The cloth that parameters make, from frame to frame: what starts it anew and what does not."""
from flag_sim.cloth import Cloth
from flag_sim.declarations.factories import pose_of
from flag_sim.declarations.moving_cloth import MovingCloth
from flag_sim.declarations.nodes import defaults
from flag_sim.drawing.transforms import apply
import numpy as np
import pytest

FRAME = 33_333_333  # [ns]
WIND = (6.0, 2.0, 0.5)
VALUES = {**defaults('physics'), 'grid.rows': 5, 'grid.columns': 7, 'preroll': 0.0}


def played(frames, values=VALUES):
    """Return a cloth after some frames."""
    cloth = MovingCloth(values)
    for index in range(frames):
        cloth.advance_to(index * FRAME, WIND, values)
    return cloth


def test_it_is_the_librarys_cloth():
    """To the bit; the first frame is where it begins."""
    cloth = Cloth(5, 7, pole=(0.0, 0.0, 0.05))
    for _ in range(3):
        cloth.advance(FRAME * 1e-9, WIND)
    moved = played(4)
    assert np.array_equal(moved.positions, cloth.positions) and moved.time == 3 * FRAME
    assert np.array_equal(moved.normals(), cloth.normals())


def test_time_that_goes_back_starts_anew_as_a_restart_does():
    """Both lay it out again."""
    back, restarted, fresh = played(6), played(6), played(2)
    restarted.restart()
    for cloth in (back, restarted):
        cloth.advance_to(0, WIND, VALUES)
        cloth.advance_to(FRAME, WIND, VALUES)
        assert np.array_equal(cloth.positions, fresh.positions)


def test_a_gap_that_is_too_long_is_not_simulated():
    """The cloth stands still over it, and the next frame moves it again."""
    cloth = played(3)
    before = cloth.positions
    cloth.advance_to(10**10, WIND, VALUES)
    assert np.array_equal(cloth.positions, before) and cloth.time == 10**10
    assert cloth.gap == pytest.approx(10.0 - 2 * FRAME * 1e-9)
    cloth.advance_to(10**10 + FRAME, WIND, VALUES)
    assert cloth.gap == 0.0 and not np.array_equal(cloth.positions, before)


@pytest.mark.parametrize('changes', [
    {'grid.rows': 6}, {'stiffness': 700.0}, {'solver': 'rk4'}, {'precision': 'float32'},
    {'pole.diameter': 0.1, 'gravity': 3.0}])
def test_other_values_keep_the_motion(changes):
    """The cloth is about where it was."""
    cloth = played(20)
    before, corner = cloth.positions[-1, -1], MovingCloth(VALUES).positions[-1, -1]
    assert np.linalg.norm(before - corner) > 0.3
    cloth.advance_to(19 * FRAME + 1, WIND, {**VALUES, **changes})
    assert np.linalg.norm(cloth.positions[-1, -1] - before) < 0.05


def test_solver_and_moving_air_change_together():
    """Neither order of setting them one by one is right both ways."""
    cloth = MovingCloth(VALUES)
    for index, (solver, share) in enumerate([
            ('symplectic', 0.5), ('xpbd', 0.0), ('symplectic', 0.5), ('verlet', 0.0)]):
        values = {**VALUES, 'solver': solver, 'air.added_mass': share}
        cloth.advance_to(index * FRAME, WIND, values)
    assert cloth.positions[:, -1, 1].min() > 1e-4  # it moved in the last frame, too


def test_another_size_starts_anew_and_rolls():
    """In the wind of its first frame, in which it then moves on as in any other."""
    values = {**VALUES, 'preroll': 0.1}
    cloth = played(3, values)
    larger = {**values, 'flag.length': 3.0}
    cloth.advance_to(3 * FRAME, WIND, larger)
    expected = Cloth(5, 7, length=3.0, pole=(0.0, 0.0, 0.05))
    for _ in range(3):
        expected.advance(0.1 / 3, WIND)
    expected.advance(FRAME * 1e-9, WIND)
    assert np.array_equal(cloth.positions, expected.positions)


def driven(index):
    """Return the values of a frame of a pole that drives and turns."""
    return {**VALUES, 'pole.position': [0.1 * index, 2.0, 0.0], 'pole.yaw': 0.02 * index,
            'pole.tilt': 0.1}


def test_the_pole_goes_to_where_the_frame_has_it():
    """From where the frame before had it; in the first frame, and after a restart, it is there."""
    cloth, expected = MovingCloth(VALUES), Cloth(5, 7, pole=(0.0, 0.0, 0.05))
    expected.pose = pose_of(driven(0))
    for index in range(4):
        cloth.advance_to(index * FRAME, WIND, driven(index))
        if index:
            expected.advance(FRAME * 1e-9, WIND, pose_of(driven(index)))
        assert np.array_equal(cloth.positions, expected.positions)
    cloth.restart()
    cloth.advance_to(0, WIND, driven(7))
    expected.reset()
    expected.pose = pose_of(driven(7))
    assert np.array_equal(cloth.positions, expected.positions)


def test_over_a_gap_the_cloth_goes_with_its_pole():
    """And where the pole jumps: that is said once, with what is too fast."""
    cloth = MovingCloth(VALUES)
    for index in range(3):
        cloth.advance_to(index * FRAME, WIND, driven(0))
    own = apply(np.linalg.inv(pose_of(driven(0))), cloth.positions)
    cloth.advance_to(10**10, WIND, driven(50))
    np.testing.assert_allclose(cloth.positions, apply(pose_of(driven(50)), own), atol=1e-9)
    told = [cloth.advance_to(10**10 + n * FRAME, WIND, driven(500 * n)) for n in (1, 2)]
    (entry,) = told[0]
    assert '200 m/s at the hoist or 100 rad/s' in entry.text and told[1] == []
    assert cloth.softness() == 'the pole is too fast for the cloth to follow'


def test_figures_and_words_tell_of_a_softened_cloth():
    """Which is reported in the frame in which it begins."""
    values = {**VALUES, 'substeps_limit': 5, 'stiffness': 1e6}
    cloth = MovingCloth(values)
    assert cloth.softness() == '' and 'steps granted' not in cloth.figures()
    assert cloth.advance_to(0, WIND, values) == []
    (entry,) = cloth.advance_to(FRAME, WIND, values)
    assert entry.level == 'warning' and 'substeps_limit allows 5' in entry.text
    assert cloth.softness() == 'the cloth is softer than it is set'
    assert cloth.figures()['steps granted'] == 5
