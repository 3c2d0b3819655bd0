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

"""Values on sliders."""
from flag_sim.declarations.nodes import NODES
from flag_sim.viewer.scales import Scale, STEPS
import pytest

LIMITED = [one for node in ('wind', 'physics', 'renderer') for one in NODES[node]
           if one.low is not None and not one.is_list]


@pytest.mark.parametrize('one', LIMITED, ids=lambda one: one.name)
def test_places_and_values_of_every_parameter_agree(one):
    """Both ends are reached exactly, all values are allowed, and no place leads back."""
    scale = Scale(one.low, one.high, isinstance(one.default, int))
    assert scale.value(0) == one.low and scale.value(STEPS) == one.high
    before = None
    for place in range(0, STEPS + 1, 7):
        value = scale.value(place)
        assert one.accept(value) == value
        assert before is None or value >= before
        assert scale.value(scale.place(value)) == pytest.approx(value, rel=0.02)
        before = value
    assert 0 <= scale.place(one.default) <= STEPS


def test_a_range_over_decades_is_logarithmic():
    assert Scale(0.01, 1000.0).value(STEPS // 2) == pytest.approx(3.16, rel=0.01)
    assert Scale(0.0, 1e9).is_logarithmic and not Scale(0.0, 200.0).is_logarithmic
    assert not Scale(-1e4, 1e4).is_logarithmic
    assert Scale(0.0, 1.0).place(99.0) == STEPS
