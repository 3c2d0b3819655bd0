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
What is ranked: how exact a reference is, and which differences that leaves.

A measured error is uncertain by what the reference itself is wrong by. Only what differs by at
least FROM times that is ranked; settings that differ by less are tied.
"""
import math

import numpy as np

FROM = 5.0
"""Times the reference's own error by which two settings must differ to be ranked."""
SAFETY = 1.25
LEAST_RATIO, MOST_RATIO = 2.0, 4.0
"""By which halving the spacing divides an error, of methods of first and second order."""
MIN_GAIN = 0.1  # part of an error that makes a difference


def own_error(quarter: float, half: float) -> float:
    """
    Return how far a reference is from the exact motion, estimated by two coarser grids.

    quarter: how far a grid a quarter as fine as the reference is from one half as fine; half: how
    far that one is from the reference. The grid convergence index of Roache (Perspective: A Method
    for Uniform Reporting of Grid Refinement Studies, 1994): if the next halving divides the
    distance by the same ratio, and so on, `half` / (ratio - 1) is left. The ratio is one of
    theory, as near the horizon all distances are alike, whatever the grids.
    """
    if half <= 0.0:
        return 0.0
    return SAFETY * half / (min(max(quarter / half, LEAST_RATIO), MOST_RATIO) - 1.0)


def ranks(values: dict[str, float], least: float) -> dict[str, int]:
    """
    Return {name: rank}, the lowest value first: 1 + how many are lower by at least `least`.

    Those of one rank are tied; so may be neighbours of different ranks, as what differs by less
    than `least` from both of two others may lie between them.
    """
    return {name: 1 + sum(value - other >= least and value > other for other in values.values())
            for name, value in values.items()}


def frontier(points: list[tuple[float, float]], same: float, least: float = 0.0) -> list[int]:
    """
    Return the indices of points (cost, error) that no other beats in both, by their cost.

    Costs less than the part `same` apart count as equal (see summary.resolution): chance would
    decide which is the cheaper. A dearer point must lower the error by at least `least`, and by
    the part MIN_GAIN of it.
    """
    best, found = math.inf, []
    for index in sorted(range(len(points)), key=lambda i: points[i]):
        cost, wrong = points[index]
        beaten = any(other < wrong and wrong - other >= least
                     and cost <= dearer <= (1.0 + same) * cost for dearer, other in points)
        if wrong < best and not beaten:
            best = min((1.0 - MIN_GAIN) * wrong, wrong - least)
            found.append(index)
    return found


def kendall(one: list[float], other: list[float], least: float = 0.0) -> float | None:
    """
    Return Kendall's tau-b of two rankings of the same things: 1 where they agree, -1 reversed.

    Two values less than `least` apart are tied. None where all are tied in one of both.
    """
    signs = [_signs(np.asarray(values, float), least) for values in (one, other)]
    product = math.prod(int(np.abs(some).sum()) for some in signs)
    return float(signs[0] @ signs[1] / math.sqrt(product)) if product else None


def reversed_pairs(one: dict[str, float], other: dict[str, float],
                   least: float) -> list[tuple[str, str]]:
    """Return the pairs of names that two rankings {name: value} have in opposite orders."""
    names = list(one)
    signs = [_signs(np.array([some[name] for name in names]), least) for some in (one, other)]
    return [(names[i], names[j]) for i, j, is_reversed in zip(
        *np.triu_indices(len(names), 1), signs[0] * signs[1] < 0) if is_reversed]


def _signs(values, least):
    """Return the sign of each pair's difference, in the order of triu_indices; 0 where tied."""
    i, j = np.triu_indices(len(values), 1)
    apart = values[i] - values[j]
    return np.sign(apart) * (np.abs(apart) >= least)
