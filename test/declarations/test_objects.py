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

"""Boxes as flat lists of parameters, and which of these go together."""
from flag_sim.declarations.factories import look_of
from flag_sim.declarations.nodes import defaults
from flag_sim.declarations.objects import boxes_of
from flag_sim.drawing import Box, Surface
import pytest

TWO = {'objects.sizes': [1.0, 2.0, 3.0, 0.5, 0.5, 0.5],
       'objects.positions': [4.0, 5.0, 0.0, -1.0, 0.0, 0.0]}


def boxes(**more):
    """Return the boxes of the renderer's parameters, `__` for a dot."""
    given = {name.replace('__', '.'): value for name, value in more.items()}
    return boxes_of({**defaults('renderer'), **TWO, **given})


def test_boxes_are_those_of_the_lists_in_their_order():
    assert boxes_of(defaults('renderer')) == ()
    plain = boxes()
    assert plain == (Box((1.0, 2.0, 3.0), (4.0, 5.0, 0.0)), Box((0.5, 0.5, 0.5), (-1.0, 0.0, 0.0)))
    look = boxes(objects__yaws=[0.5, 0.0], objects__colors=[1.0, 2.0, 3.0, 40.0, 50.0, 60.0])
    assert [box.yaw for box in look] == [0.5, 0.0]
    assert look[1].surface == Surface((40.0, 50.0, 60.0))
    assert look_of({**defaults('renderer'), **TWO}).dimensions.boxes == plain


@pytest.mark.parametrize('more, words', [
    ({'objects__sizes': [1.0, 2.0]}, 'objects.sizes must hold 3 numbers for each box, not 2'),
    ({'objects__positions': [1.0, 2.0, 3.0]},
     'objects.positions must be those of the 2 boxes that objects.sizes has, not of 1'),
    ({'objects__positions': []}, 'not of 0'), ({'objects__yaws': [0.0]}, 'objects.yaws .* of 1'),
    ({'objects__colors': [0.0] * 9}, 'objects.colors .* not of 3'),
    ({'objects__colors': [0.5] * 6}, 'color'),
    ({'objects__sizes': [1.0] * 753}, 'of at most 250 boxes, not 251')], ids=str)
def test_lists_that_do_not_go_together_are_refused(more, words):
    with pytest.raises(ValueError, match=words):
        boxes(**more)
