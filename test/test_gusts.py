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

"""Gusts against the formulas of their spectrum."""
from flag_sim.animation.gusts import Gusts
from flag_sim.animation.timeline import Timeline
from flag_sim.animation.tracks import Track
from flag_sim.animation.wind import Passage, wind_vector
from flag_sim.nodes.dials import NODES
from flag_sim.nodes.weather import Weather
import numpy as np
import pytest

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


def test_the_wind_of_a_shot_does_not_depend_on_the_frame_rate():
    """Nor on what was asked for before: with keyed speed and gusts, to the bit."""
    values = {dial.name: dial.default for dial in NODES['wind']}
    values |= {'gust.intensity': 0.3, 'gust.seed': 4}
    timeline = Timeline({'wind.speed': Track([0.0, 2.0, 9.0], [2.0, 12.0, 6.0], ['cubic'] * 3)})
    fine, coarse, once = (Weather(values, timeline) for _ in range(3))
    at_240 = {k: fine.at(k / 240.0) for k in range(2401)}
    for k in range(301):
        assert np.array_equal(at_240[8 * k], coarse.at(k / 30.0))
    assert np.array_equal(at_240[2400], once.at(10.0))
    assert np.ptp([wind[2] for wind in at_240.values()]) > 1.0  # there are gusts


def test_gusts_are_parts_of_the_speed_in_the_winds_own_axes():
    """Along, to the left and upwards."""
    assert np.allclose(wind_vector(10.0, 0.0, 0.0, (0.1, 0.2, 0.3)), [11.0, 2.0, 3.0])
    assert np.allclose(wind_vector(10.0, np.pi / 2, 0.0, (0.1, 0.2, 0.3)), [-2.0, 11.0, 3.0])


def test_bad_eddies_are_refused():
    """The size must be positive."""
    with pytest.raises(ValueError, match='gust.length must be above 0'):
        Gusts(0.0, 1)
