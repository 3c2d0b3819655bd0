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

"""Follows, behaves and rests: on motions whose numbers are known."""
import math
import time

from flag_sim.declarations.factories import cloth_of, look_of
from flag_sim.study.measures import behaves, follows, long_run, rests
from flag_sim.study.measures.judge import Judge, reference_grid
from flag_sim.study.measures.long_run import LongRun
from flag_sim.study.measures.reference import exact, on_grid, Shot, steps
from flag_sim.study.measures.settings import changed, defaults
from flag_sim.study.measures.summary import rms
import numpy as np
import pytest
from scipy import stats
from support.study import SMALL

COARSE = {'grid.rows': 5, 'grid.columns': 7}


@pytest.fixture
def judge(monkeypatch, tmp_path):
    """Return a Judge of a small flag, whose shots are short."""
    for module, name, value in SMALL:
        monkeypatch.setattr(module, name, value)
    scene = changed(defaults(gust__intensity=0.3), {'grid.rows': 9, 'grid.columns': 13})
    return Judge(scene, tmp_path)


def waving(frequency=2.0, height=0.1, seed=0, seconds=20.0, waves=3):
    """Return a LongRun of a fly that waves at a frequency [Hz], in folds of some half-waves."""
    times = np.arange(0.0, seconds, 1.0 / 30.0)
    source = np.random.default_rng(seed)
    motion = height * np.sin(2.0 * np.pi * (frequency * times + source.random()))
    wrinkles = np.zeros((len(times), long_run.SHORTEST))
    wrinkles[:, waves - 1] = 0.5 * height**2 * (1.0 + 0.1 * source.random(len(times)))
    pixels = 100.0 * motion[:, None, None, None] * np.ones((1, 3, 4, 2))
    energy = motion**2 + 0.01 * source.random(len(times))
    return LongRun(1.0 / 30.0, pixels, energy, motion[:, None] * np.ones(3), wrinkles,
                   5.0 + 0.1 * source.random(len(times)))


def test_the_distance_of_samples_is_that_of_scipy():
    """Wasserstein's distance of two samples of one size."""
    source = np.random.default_rng(1)
    one, other = source.normal(0.0, 1.0, 50), source.normal(2.0, 3.0, 50)
    assert behaves.wasserstein(one, other) == pytest.approx(
        stats.wasserstein_distance(one, other))


def test_the_spectrum_of_a_known_motion():
    """Its peak, and the distance of two waves is that of their frequencies."""
    runs = [waving(2.0), waving(3.0)]
    assert [behaves.dominant_frequency(run) for run in runs] == pytest.approx(
        [2.0, 3.0], abs=0.2)
    found = behaves.STATISTICS['spectrum'].distance(*runs)
    assert found == pytest.approx(1.0, abs=0.05)


def test_waves_along_a_row_are_found_by_their_length():
    """A sine of three half-waves and 0.2 m: half of its square, in the third place."""
    part = np.linspace(0.0, 1.0, 97)
    sheet = np.zeros((4, 97, 3))
    sheet[..., 0] = 2.0 * part
    sheet[..., 1] = 0.2 * np.sin(3.0 * np.pi * part)
    found = long_run.wrinkles(sheet)
    assert found[2] == pytest.approx(0.5 * 0.2**2, rel=1e-3)
    assert found.sum() - found[2] < 1e-6
    tilted = sheet + sheet[..., :1] * [0.0, 0.5, -0.3]
    assert long_run.wrinkles(tilted) == pytest.approx(found, abs=1e-12)
    # Two octaves lie between folds of three half-waves and of twelve.
    three, twelve = waving(waves=3), waving(waves=12)
    assert behaves.STATISTICS['wrinkles'].distance(three, twelve) == pytest.approx(2.0)


def test_the_load_of_a_hanging_flag_is_its_weight():
    """0.2 kg/m2 times 2.25 x 1.5 m, but for the half cell at the hoist: 6.5 N."""
    cloth = cloth_of(defaults(node_damping=2.0, grid__rows=9, grid__columns=13))
    for _ in range(300):
        cloth.advance(1.0 / 30.0)
    hanging = 1.0 - 0.5 / 12
    assert long_run.pole_load(cloth, cloth.positions) == pytest.approx(
        0.2 * 2.25 * 1.5 * 9.81 * hanging, rel=0.03)


def test_settings_that_are_the_reference_behave_and_others_do_not():
    """By as much as they differ, in the unit of the reference's own scatter."""
    reference = [waving(2.0 + 0.02 * seed, 0.1 + 0.01 * seed, seed) for seed in range(4)]
    same = [waving(2.0 + 0.02 * seed, 0.1 + 0.01 * seed, seed + 10) for seed in range(3)]
    row = behaves.behaves(same, reference)
    assert set(row) == set(behaves.STATISTICS)
    assert max(row.values()) < behaves.WITHIN
    for other, worst in ((waving(4.0), {'spectrum', 'frequency'}),
                         (waving(height=0.5), {'energy'}), (waving(waves=12), {'wrinkles'})):
        row = behaves.behaves([other] * 3, reference)
        assert all(row[name] > behaves.WITHIN for name in worst)
    assert set(behaves.behaves([same[0], None], reference).values()) == {math.inf}


def test_a_run_is_not_compared_with_that_in_its_own_gusts():
    """The reference itself is at the distance 1 of itself, not at less."""
    reference = [waving(2.0 + 0.11 * seed, 0.1 + 0.01 * seed, seed, waves=3 + seed)
                 for seed in range(3)]
    assert list(behaves.behaves(reference, reference).values()) == pytest.approx(
        [1.0] * len(behaves.STATISTICS))


def test_the_number_of_one_run_is_uncertain_by_that_of_the_references_own():
    """Runs that are alike have none; one that differs from the others makes much of it."""
    runs = [waving(2.0 + 0.02 * seed, 0.1 + 0.01 * seed, seed) for seed in range(4)]
    own = behaves.own_scatter(runs)
    assert 0.0 < own < 1.0
    assert behaves.own_scatter([*runs[:3], waving(4.0, 0.5)]) > 2.0 * own


def test_what_is_kept_of_a_long_run():
    """A flag in wind, frame by frame; one that diverges has none."""
    settings = changed(defaults(), COARSE)
    camera = look_of(settings).camera
    run = long_run.observed(Shot(settings), cloth_of(settings), camera, 0.5, 1.0)
    assert run.pixels.shape == (30, *long_run.SEEN, 2)
    assert len(run.energy) == len(run.fly) == len(run.load) == 30
    assert run.energy.min() > 0.0 and run.load.min() > 0.0
    storm = changed(settings, {'solver': 'seed', 'area_density': 1e-6, 'stretch_limit': 1e6,
                               'speed': 200.0, 'substeps_limit': 5})
    assert long_run.observed(Shot(storm), cloth_of(storm), camera, 0.5, 1.0) is None
    assert rests.rest(Shot(storm), cloth_of(storm)).speed == math.inf


def test_an_exact_flag_rests_and_one_that_is_kept_moving_does_not():
    """A symplectic flag comes to rest; explicit Euler's jitters for ever."""
    settings = changed(defaults(), COARSE)
    found = rests.rest(Shot(settings), cloth_of(settings))
    assert found.speed < rests.SLOW
    assert 0.5 < found.depth < 1.5  # between that of a flag that flies, and its length
    cloth = cloth_of(settings)
    rests.rest(Shot(settings), cloth)
    assert cloth.material.node_damping == settings['node_damping']

    restless = changed(settings, {'solver': 'euler'})
    assert rests.rest(Shot(restless), cloth_of(restless)).speed > 10.0 * rests.SLOW


def test_a_flag_that_creeps_is_stilled_until_it_is_still(monkeypatch):
    """In a steady wind this one creeps for 50 s, before its folds give way: that is no jitter."""
    settings = changed(defaults(), COARSE)
    cloth, frames, speeds = cloth_of(settings), [], iter([3.0] * 900 + [0.1] * 1000)
    monkeypatch.setattr(rests, '_speed', lambda cloth, dt: frames.append(
        cloth.material.node_damping) or next(speeds))
    assert rests.rest(Shot(settings), cloth).speed == pytest.approx(0.1)
    assert frames.count(rests.STILLING) == 900 + 30 and frames[-1] == settings['node_damping']


def test_a_softened_flag_hangs_too_deep():
    """Half of the depth more where a hundredth of the stiffness is left."""
    settings = changed(defaults(), COARSE)
    right = rests.rest(Shot(settings), cloth_of(settings))
    soft = changed(settings, {'stiffness': 10.0, 'shear_stiffness': 5.0})
    assert rests.rest(Shot(soft), cloth_of(soft)).depth > 1.1 * right.depth


def test_two_runs_have_parted_at_a_tenth_of_what_strangers_are_apart():
    """The first time at which they are."""
    times, apart = [0.1, 0.2, 0.3], [0.01, 0.9, 5.0]
    assert follows.horizon(times, apart, 5.0) == 0.2
    assert follows.horizon(times, apart, 100.0) is None


def test_the_reference_has_no_error_and_a_coarse_grid_has(judge):
    """Errors grow with time; an end that is shifted is wrong by its shift."""
    right = exact(judge.scene, *judge.finest)
    row = judge.follow(right, 0)
    assert all(row[column] < 1e-9 for column in judge.columns)
    coarse = judge.follow(on_grid(judge.scene, 5, 7), 0)
    assert 0.1 < coarse['px_0.033'] < coarse['px_0.3']
    reference = judge.reference()
    window = reference.window(0)
    found = follows.ends(reference.shot, reference.start(window, right), window.frame, [1])
    error, = follows.errors_px(found, [window.ends[0] + [0.0, 0.0, 0.002]], judge.camera)
    # 2 mm upwards at the default camera's distance, and cos(elevation) of it across the view.
    assert error == pytest.approx(judge.camera.pixels_per_metre(5.5) * 0.002, rel=0.1)


def test_grids_are_compared_at_the_nodes_that_both_have():
    """Exactly where one is nested in the other, whichever is finer; None where one diverged."""
    source = np.random.default_rng(3)
    fine = source.normal([1.1, 0.0, 7.85], 0.3, (9, 13, 3))
    camera = look_of(defaults()).camera
    for pair in ((fine, fine[::2, ::2]), (fine[::2, ::2], fine)):
        assert all(np.array_equal(one, fine[::2, ::2]) for one in follows.shared(*pair))
        assert follows.errors_px([pair[0]], [pair[1]], camera) == [0.0]
    assert follows.errors_px([fine, None], [None, fine], camera) == [None, None]


def test_how_far_coarser_grids_are_from_the_reference(judge):
    """Half as fine is nearer than a quarter, and the step matters least."""
    half, quarter, step = judge.convergence(0)
    for column in judge.columns:
        assert 0.0 < step[column] < half[column] < quarter[column]
    row = judge.follow(exact(judge.scene, 9, 13), 0)
    assert {column: row[column] for column in judge.columns} == half


def test_references_are_in_single_precision_where_that_resolves_their_steps(judge):
    """At 100,000 steps a second it does not any more."""
    assert exact(judge.scene, 17, 25)['precision'] == 'float32'
    stiff = changed(judge.scene, {'stiffness': 1e8})
    assert steps(exact(stiff, 17, 25)) > 1e5
    assert exact(stiff, 17, 25)['precision'] == 'float64'


def test_a_run_that_diverges_has_no_error(judge):
    """Neither at the horizon where it did, nor later."""
    bad = changed(judge.scene, {'solver': 'seed', 'area_density': 1e-6, 'stretch_limit': 1e6,
                                'substeps_limit': 1})
    bad['speed'] = 200.0
    row = judge.follow(bad, 0)
    assert row['px_0.3'] is row['physics_ms'] is None or row['px_0.3'] > 100.0


def test_costs_are_those_of_the_processor(judge, monkeypatch):
    """A machine on which one waits for it does not make a method dear."""
    play = Shot.play

    def waited_for(self, *arguments):
        time.sleep(0.05)
        play(self, *arguments)

    monkeypatch.setattr(Shot, 'play', waited_for)
    row = judge.follow(on_grid(judge.scene, 5, 7), 0)
    assert row['physics_ms'] * max(judge.frames) < 1e3 * 0.05 * len(judge.frames)


def test_a_sheet_of_many_steps_has_a_coarser_reference(judge):
    """Down to the default grid, and no further."""
    assert reference_grid(judge.scene, 1e12, (17, 25)) == (17, 25)
    assert judge.finest == (17, 25) and judge.middle == (9, 13)
    stiff = changed(defaults(), {'stiffness': 1e7})
    assert reference_grid(stiff, 1.0, (81, 121)) == (21, 31)


def test_long_runs_are_kept(judge):
    """A second judge takes them from the folder."""
    own = judge.long_runs
    other = Judge(judge.scene, judge.folder)
    assert all(np.array_equal(*pair) for one, two in zip(own, other.long_runs)
               for pair in zip(one, two))
    row = judge.behave(on_grid(judge.scene, 5, 7), 1)
    assert row['behaves'] == rms([row[name] for name in behaves.STATISTICS])
