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

"""What is typed, read as a value: nothing becomes another number, and what is none is told."""
from flag_sim.parameters.descriptor import Descriptor
from flag_sim.viewer.editors import editor_of
from flag_sim.viewer.typed import like, number
import pytest
from qtpy.QtCore import Qt
from qtpy.QtTest import QTest
from qtpy.QtWidgets import QLineEdit
from support.window import application


@pytest.mark.parametrize('text, value', [
    ('1.5', 1.5), ('1,5', 1.5), (' -,5 ', -0.5), ('1e3', 1000.0), ('7', 7.0),
    ('inf', float('inf'))])
def test_a_number_has_a_decimal_point_or_comma(text, value):
    assert number(text) == value


@pytest.mark.parametrize('text', ['1,234.5', '1,2,3', '', 'x', '1.5 m', '--1', '1' * 300 + 'x'])
def test_what_is_no_number_is_refused(text):
    with pytest.raises(ValueError, match='is no number') as refused:
        number(text)
    assert len(str(refused.value)) < 200


@pytest.mark.parametrize('text, before, value', [
    ('3,5', 6.0, 3.5), ('2', 3, 2), ('2,5', 3, 2.5), ('1, 2.5', [0.0, 0.0], [1.0, 2.5]),
    ('[1,2]', [0.0, 0.0], [1.0, 2.0]), (' False', True, False), ('flat', 'gouraud', 'flat')])
def test_a_key_is_of_the_type_of_the_one_before(text, before, value):
    """In a list commas stand between numbers."""
    assert like(text, before) == value
    assert type(like(text, before)) is type(value)


@pytest.mark.parametrize('text, before', [
    ('yes', True), ('red', [1.0, 2.0]), ('1; 2', [1.0, 2.0]), ('3 m', 1.0)])
def test_a_key_of_another_type_is_refused(text, before):
    with pytest.raises(ValueError, match='is no number|neither true nor false'):
        like(text, before)


@pytest.mark.parametrize('descriptor, before, text, asked, refused', [
    (Descriptor('speed', 'float', low=0.0, high=200.0), 6.0, '1,5', [1.5], []),
    (Descriptor('speed', 'float'), 6.0, '1.2.3', [], ["'1.2.3' is no number"]),
    (Descriptor('speed', 'float'), 6.0, '1e', [], ["'1e' is no number"]),
    (Descriptor('frames', 'int'), 6, '2,5', [2.5], []),  # the node says that it must be whole
    (Descriptor('frames', 'int'), 6, '1x2', [], ["'1x2' is no number"]),
    (Descriptor('camera.target', 'floats', length=3), [0.0, 0.0, 0.0], '0,5',
     [[0.5, 0.0, 0.0]], []),
    (Descriptor('names', 'strs'), ['a'], '[b', [], ["'[b' is no list"])])
def test_all_keys_that_are_typed_count(descriptor, before, text, asked, refused):
    """One that was left out would make it ten times as large, in silence."""
    application()
    editor = editor_of(descriptor)
    editor.show_value(before)
    told, why = [], []
    editor.asked.connect(told.append)
    editor.refused.connect(why.append)
    line = editor.findChild(QLineEdit)
    line.selectAll()
    QTest.keyClicks(line, text)
    QTest.keyClick(line, Qt.Key_Return)
    assert (told, why) == (asked, refused)
    editor.deleteLater()
