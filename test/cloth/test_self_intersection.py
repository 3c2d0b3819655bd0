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

"""Whether a cloth passes through itself, against all pairs in exact arithmetic."""
from fractions import Fraction
import itertools

from flag_sim.cloth import Cloth
from flag_sim.cloth.self_intersection import is_self_intersecting
import numpy as np
import pytest


def flat(rows=5, columns=7):
    """Return a flat cloth of cells of 1 m."""
    v, u = np.mgrid[0.0:rows, 0.0:columns]
    return np.stack([u, np.zeros_like(u), -v], axis=-1)


def folded(gap):
    """Return a cloth whose last columns are turned back over the first ones, `gap` [m] off."""
    cloth = flat()
    cloth[:, 4:, 0] = [2.6, 1.7, 0.8]
    cloth[:, 3, 0], cloth[:, 3, 1] = 3.0, 0.2
    cloth[:, 4:, 1] = gap
    return cloth


def test_flat_folded_and_touching_cloths_do_not():
    for cloth in (flat(), folded(0.3), flat() * [1.0, 1.0, 0.0]):
        assert not is_self_intersecting(cloth)
    touching = flat()
    touching[:, 5:] = touching[:, 1::-1]  # exactly onto the first ones
    touching[:, 4, 1] = 1.0
    assert not is_self_intersecting(touching)


def test_a_cloth_through_itself_does():
    through = folded(0.3)
    through[2, 6, 1] = -0.5
    assert is_self_intersecting(through)
    turned = through @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0] + 100.0
    assert is_self_intersecting(turned)


def by_all_pairs(positions):
    """Return the same of all pairs of triangles and all their edges, in fractions."""
    rows, columns = positions.shape[:2]
    exact = [[Fraction(float(x)) for x in point] for point in positions.reshape(-1, 3)]

    def side(a, b, c, d):
        p, q, r = ([x - y for x, y in zip(exact[n], exact[d])] for n in (a, b, c))
        value = (p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2])
                 + p[2] * (q[0] * r[1] - q[1] * r[0]))
        return (value > 0) - (value < 0)

    node = np.arange(rows * columns).reshape(rows, columns).tolist()
    triangles = [three for i in range(rows - 1) for j in range(columns - 1) for three in (
        (node[i][j], node[i][j + 1], node[i + 1][j]),
        (node[i + 1][j + 1], node[i + 1][j], node[i][j + 1]))]
    for one, other in itertools.permutations(triangles, 2):
        for p, q in itertools.combinations(one, 2):
            if {p, q} & set(other):
                continue
            a, b, c = other
            if side(a, b, c, p) * side(a, b, c, q) == -1 and (
                    side(p, q, a, b) == side(p, q, b, c) == side(p, q, c, a) != 0):
                return True
    return False


def test_random_cloths_are_as_all_pairs_say():
    """On a lattice, where much of it touches and only exact arithmetic decides."""
    random, found = np.random.default_rng(5), []
    for scale in (0.0, 0.25, 0.25, 0.5, 0.5, 1.0) * 3:
        cloth = flat(3, 4) + scale * random.integers(-2, 3, (3, 4, 3))
        found.append(is_self_intersecting(cloth))
        assert found[-1] == by_all_pairs(cloth)
    assert 3 < sum(found) < 15


def test_a_flag_in_the_wind_is_asked_at_once():
    cloth = Cloth(start_noise=0.01)
    for _ in range(5):
        cloth.advance(1 / 30, (9.0, 3.0, 0.0))
    assert not is_self_intersecting(cloth.positions)


@pytest.mark.parametrize('positions', [
    np.zeros((3, 3)), np.zeros((1, 3, 3)), np.full((3, 3, 3), np.nan), 'cloth', None])
def test_what_is_no_cloth_is_refused(positions):
    with pytest.raises(ValueError, match='positions'):
        is_self_intersecting(positions)
