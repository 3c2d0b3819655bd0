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

"""
*Behaves*: whether a flag moves as the reference does, where no frame can be compared any more.

Two runs of the reference itself, in other gusts, differ by some distance, in each of several
statistics. That is the unit: settings behave like the reference if their runs are no farther from
the reference's runs than those are from one another. With d the distance of two runs, X and X' of
the reference, Y of the settings, the number is E d(X, Y) / E d(X, X'), as in the energy distance
(Szekely and Rizzo, Energy statistics, 2013); the distance of two distributions of a number is
Wasserstein's.
"""
from collections.abc import Callable
import itertools
import math
from typing import NamedTuple

from flag_sim.study.measures.long_run import LongRun
from flag_sim.study.measures.summary import rms
import numpy as np

WITHIN = 2.0
"""Scatters of the reference within which settings behave."""
SLOWEST = 0.3  # least frequency that is the flag's own and not the gusts' [Hz]
PEAK = 7       # frequencies over which a spectrum is smoothed before its peak is looked for
TOLD_APART = 0.05  # dominant frequencies, in runs of 20 s [Hz]


def wasserstein(one: np.ndarray, other: np.ndarray) -> float:
    """Return Wasserstein's distance of two samples of a number, of one size: in its unit."""
    return float(np.abs(np.sort(one) - np.sort(other)).mean())


def spectrum(run: LongRun) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [Hz] and the share that each has in the fly's motion across the wind."""
    motion = run.fly - run.fly.mean(axis=0)
    power = np.abs(np.fft.rfft(motion * np.hanning(len(motion))[:, None], axis=0))**2
    frequencies = np.fft.rfftfreq(len(motion), run.dt)
    power = power.sum(axis=1) * (frequencies >= SLOWEST)
    return frequencies, power / max(power.sum(), 1e-300)


def dominant_frequency(run: LongRun) -> float:
    """Return the frequency at which the fly moves most [Hz]."""
    frequencies, share = spectrum(run)
    smooth = np.convolve(share * frequencies, np.ones(PEAK) / PEAK, 'same')
    return float(frequencies[np.argmax(smooth)])


def _spectra(one, other):
    """Return Wasserstein's distance of two spectra [Hz]."""
    (frequencies, share), (_, share_of_other) = spectrum(one), spectrum(other)
    return float(np.abs(np.cumsum(share - share_of_other)).sum() * frequencies[1])


def _shapes(of):
    """Return a distance [pixel] of two runs by what `of` makes of the pixels over time."""
    return lambda one, other: rms(np.linalg.norm(of(one.pixels) - of(other.pixels), axis=-1))


def steepness(run: LongRun) -> np.ndarray:
    """Return the share of waves of 1, 2, ... half-waves along a row in the steepness of folds."""
    numbers = np.arange(1, run.wrinkles.shape[1] + 1)
    steep = run.wrinkles.mean(axis=0) * numbers**2
    return steep / max(steep.sum(), 1e-300)


def _wrinkles(one, other):
    """Return Wasserstein's distance of the steepness over wavelengths [octave]."""
    apart = np.abs(np.cumsum(steepness(one) - steepness(other)))[:-1]
    return float(apart @ np.diff(np.log2(np.arange(1, len(apart) + 2))))


class Statistic(NamedTuple):
    """
    One thing by which runs are compared: its name with the unit, and the distance of two.

    least: scatter below which nothing is told apart.
    """

    title: str
    distance: Callable
    least: float = 1e-12


STATISTICS = {
    'shape': Statistic('mean shape [px]', _shapes(lambda pixels: pixels.mean(axis=0))),
    'spread': Statistic('spread of the shape [px]', _shapes(lambda pixels: pixels.std(axis=0))),
    'energy': Statistic('kinetic energy [J]',
                        lambda one, other: wasserstein(one.energy, other.energy)),
    'frequency': Statistic('dominant frequency of the fly [Hz]', lambda one, other: abs(
        dominant_frequency(one) - dominant_frequency(other)), TOLD_APART),
    'spectrum': Statistic('spectrum of the fly [Hz]', _spectra),
    'wrinkles': Statistic('wrinkles [octave]', _wrinkles),
    'load': Statistic('pole load [N]', lambda one, other: wasserstein(one.load, other.load)),
}
"""{column: Statistic} of two LongRuns."""


def scatter(reference: list[LongRun]) -> dict[str, float]:
    """Return {statistic: mean distance of two of the reference's runs}: the unit of behaves."""
    return {name: max(one.least, float(np.mean([
        one.distance(*pair) for pair in itertools.combinations(reference, 2)])))
            for name, one in STATISTICS.items()}


def behaves(runs: list[LongRun | None], reference: list[LongRun]) -> dict[str, float]:
    """
    Return {statistic: distance from the reference, in its own scatter}: 1 is as near as itself.

    runs: of some settings, each in the gusts of the reference's run of the same place, with which
    it is not compared; None for one that diverged, which is infinitely far.
    """
    if None in runs:
        return dict.fromkeys(STATISTICS, math.inf)
    own = scatter(reference)
    pairs = [(run, right) for (i, run), (j, right) in itertools.product(
        enumerate(runs), enumerate(reference)) if i != j]
    return {name: float(np.mean([one.distance(*pair) for pair in pairs])) / own[name]
            for name, one in STATISTICS.items()}


def own_scatter(reference: list[LongRun]) -> float:
    """
    Return the standard deviation of `together` of the reference's runs, each by all the others.

    That is what the number of one run is uncertain by: in other gusts it would be another.
    """
    found = [together(behaves([one], [one, *(other for other in reference if other is not one)]))
             for one in reference]
    return float(np.std(found, ddof=1))


def together(distances: dict[str, float]) -> float:
    """Return the one number of `behaves`: the root mean square over all statistics."""
    return rms(list(distances.values()))
