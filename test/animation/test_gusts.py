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

"""Gusts against the formulas of their spectrum, and the way of the wind that brings them."""
import itertools
import tracemalloc

from flag_sim.animation.gusts import Gusts
from flag_sim.animation.timeline import Timeline
from flag_sim.animation.tracks import Track
from flag_sim.animation.wind_source import WindSource
from flag_sim.animation.wind_vector import Passage, wind_vector
from flag_sim.declarations.nodes import defaults
import numpy as np
import pytest
from support.traced import traced

LENGTH = 5.0
STEP = 0.25  # [m]
COUNT = 2**15


@pytest.fixture(scope='module')
def series():
    """Return (u, v, w) over distance, of four seeds: (4, COUNT, 3)."""
    return np.array([[gusts.at(i * STEP) for i in range(COUNT)]
                     for gusts in (Gusts(LENGTH, seed) for seed in range(4))])


def test_mean_and_variance(series):
    """
    Mean 0 and variance 1.

    A record of N eddies' lengths leaves a standard error of about sqrt(1 / N) in the mean and
    sqrt(2 / N) in the variance; N is COUNT STEP / LENGTH for each of 4 seeds, three errors wide.
    """
    eddies = 4 * COUNT * STEP / LENGTH
    assert np.all(np.abs(series.mean(axis=(0, 1))) < 3.0 * np.sqrt(1.0 / eddies))
    assert np.all(np.abs((series**2).mean(axis=(0, 1)) - 1.0) < 3.0 * np.sqrt(2.0 / eddies))


@pytest.mark.parametrize('component, spectrum', [
    (0, lambda x: 2.0 / np.pi / (1.0 + x**2)),
    (1, lambda x: (1.0 + 3.0 * x**2) / np.pi / (1.0 + x**2)**2),
    (2, lambda x: (1.0 + 3.0 * x**2) / np.pi / (1.0 + x**2)**2)])
def test_the_spectrum_is_drydens(series, component, spectrum):
    """
    The variance in each of six bands of L W is the integral of the formula there.

    The sum has about 256 / 6 lines in a band, each anywhere in its step: the band's edges leave an
    error of about two lines, 2 / 256 of the whole; a window leaks little between such wide bands.
    """
    window = np.hanning(COUNT)
    power = np.abs(np.fft.rfft(series[..., component] * window, axis=1))**2
    power = power.mean(axis=0) * 2.0 / (COUNT * np.sum(window**2))
    x = LENGTH * 2.0 * np.pi * np.fft.rfftfreq(COUNT, STEP)
    edges = [0.05, 0.3, 0.7, 1.5, 3.0, 6.0, 20.0]
    for low, high in zip(edges, edges[1:]):
        fine = np.linspace(low, high, 2001)
        expected = np.trapezoid(spectrum(fine), fine) if hasattr(np, 'trapezoid') else np.trapz(
            spectrum(fine), fine)
        assert power[(x >= low) & (x < high)].sum() == pytest.approx(expected, abs=0.02)


def test_the_same_seed_gives_the_same_series():
    """And another seed another one; a jump changes nothing, for the sum has no memory."""
    assert np.array_equal(Gusts(LENGTH, 3).at(100.0), Gusts(LENGTH, 3).at(100.0))
    assert not np.allclose(Gusts(LENGTH, 3).at(100.0), Gusts(LENGTH, 4).at(100.0))


def test_the_way_of_the_wind_does_not_depend_on_the_frame_rate():
    """The lattice is the passage's own: times in common get the same distance to the bit."""
    def speed(time):
        return 6.0 + 3.0 * np.sin(time)

    fine, coarse = Passage(speed), Passage(speed)
    at_240 = {k: fine.at(k / 240.0) for k in range(2401)}
    at_30 = {8 * k: coarse.at(k / 30.0) for k in range(301)}
    assert all(at_240[k] == distance for k, distance in at_30.items())
    assert at_30[2400] == pytest.approx(60.0 + 3.0 * (1.0 - np.cos(10.0)), abs=1e-3)


def way_of(speed, time, start=0.0, distance=0.0):
    """Return what a wind passes until a time, by trapezoids of 1/64 s from its start on, [m]."""
    whole = int(64.0 * (time - start))
    at = [start + k / 64.0 for k in range(whole + 1)]
    parts = (0.5 * (speed(a) + speed(b)) / 64.0 for a, b in zip(at, at[1:]))
    *_, passed = itertools.accumulate(parts, initial=distance)
    return passed + 0.5 * (time - at[-1]) * (speed(at[-1]) + speed(time))


@pytest.mark.parametrize('start, distance', [(0.0, 0.0), (1234.567, 89.0)])
def test_the_way_of_the_wind_is_the_sum_of_its_trapezoids(start, distance):
    """To the bit, whatever was asked for before: frames in turn, leaps, copies, times before."""
    track = Track([0.0, 2.0, 2.5, 9.0], [2.3, 12.1, 0.0, 6.7], ['cubic', 'ease', 'linear', 'step'])

    def speed(time):
        return track.at(time - start)

    passage = Passage(speed, start, distance)
    for time in [*(k / 30.0 for k in range(200)), 100.0, 100.0, 7.3, 100.0, 0.0, 1.0 / 64.0, 3.1]:
        assert passage.at(start + time) == way_of(speed, start + time, start, distance)


WEEK = 7 * 24 * 3600.0  # [s]


def test_a_week_of_wind_takes_no_memory_and_no_more_work(monkeypatch):
    """
    The last frame asks for as many speeds as the first, and nothing of the others is kept.

    On a lattice of 8 s for the test's sake; kept, its 75,600 numbers would take 2.4 MB.
    """
    monkeypatch.setattr(Passage, 'STEP', 8.0)
    asked = []

    def speed(time):
        asked.append(time)
        return 6.0

    passage, work = Passage(speed), set()
    tracemalloc.start()
    try:
        for frame in range(int(WEEK / 32.0)):
            asked.clear()
            passage.at(32.0 * frame)
            work.add(len(asked))
        assert traced() < 10_000  # [bytes]
    finally:
        tracemalloc.stop()
    assert work == {1, 5}  # four lattice points and the frame itself; at the first, itself alone


class CountedTrack(Track):
    """A track that counts how often it is asked for its value."""

    asked = 0

    def at(self, time):
        """Return the value."""
        self.asked += 1
        return super().at(time)


def weather_values(**changes):
    """Return the wind's values, changed."""
    return {**defaults('wind'),
            **{name.replace('__', '.'): value for name, value in changes.items()}}


def test_a_parameter_that_is_turned_after_a_week_without_gusts_has_no_past_to_catch_up():
    """Neither the one that is turned nor the gusts that it may bring."""
    speed = CountedTrack([0.0, 9.0], [2.0, 12.0])
    timeline = Timeline({'wind.speed': speed}, loop=True)
    source = WindSource(weather_values(), timeline)
    source.at(WEEK)
    source = source.continued(weather_values(azimuth=1.0), timeline, WEEK)
    source = source.continued(weather_values(gust__intensity=0.3), timeline, WEEK)
    source.at(WEEK)
    assert speed.asked < 10
    source.at(WEEK + 1.0)
    assert 64 < speed.asked < 90  # gusts are carried from here on


def test_turning_a_parameter_changes_no_gust_that_is_in_the_air():
    """The wind goes on from where it is; other parameters than its own leave it as it is."""
    values, timeline = weather_values(gust__intensity=0.3), Timeline({})
    source = WindSource(values, timeline)
    assert source.continued({**values, 'paused': True, 'rate': 50.0}, timeline, 3.21) is source
    continued = source.continued({**values, 'speed': 12.0}, timeline, 3.21)
    assert np.allclose(continued.at(3.21), 2.0 * source.at(3.21), rtol=1e-12)


@pytest.mark.parametrize('loop', [False, True])
def test_the_wind_of_a_shot_does_not_depend_on_the_frame_rate(loop):
    """Nor on what was asked for before: with keyed speed and gusts, to the bit."""
    timeline = Timeline({
        'wind.speed': Track([0.0, 2.0, 9.0], [2.0, 12.0, 6.0], ['cubic'] * 3),
        'wind.gust.intensity': Track([0.0, 3.0, 4.0], [0.0, 0.0, 0.3])}, loop=loop)
    values = weather_values(gust__seed=4)
    fine, coarse, once = (WindSource(values, timeline) for _ in range(3))
    at_240 = {k: fine.at(k / 240.0) for k in range(2401)}
    for k in range(301):
        assert np.array_equal(at_240[8 * k], coarse.at(k / 30.0))
    assert np.array_equal(at_240[2400], once.at(10.0))
    assert np.ptp([wind[2] for wind in at_240.values()]) > 1.0  # there are gusts
    passed = way_of(lambda time: timeline.value('wind.speed', time), 6.5)
    gust = 0.3 * Gusts(5.0, 4).at(passed)
    assert np.array_equal(at_240[1560], wind_vector(
        timeline.value('wind.speed', 6.5), values['azimuth'], values['elevation'], gust))


def test_gusts_are_parts_of_the_speed_in_the_winds_own_axes():
    """Along, to the left and upwards."""
    assert np.allclose(wind_vector(10.0, 0.0, 0.0, (0.1, 0.2, 0.3)), [11.0, 2.0, 3.0])
    assert np.allclose(wind_vector(10.0, np.pi / 2, 0.0, (0.1, 0.2, 0.3)), [-2.0, 11.0, 3.0])


def test_bad_eddies_are_refused():
    """The size must be positive."""
    with pytest.raises(ValueError, match='length must be a number from 0.01'):
        Gusts(0.0, 1)
