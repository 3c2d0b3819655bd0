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

"""Why a value was refused is told beside the panel, whose fields stay where they are."""
from flag_sim.parameters.descriptor import Descriptor
from flag_sim.viewer.balloon import Balloon
from flag_sim.viewer.exchange import Answered, Described, Found
from flag_sim.viewer.window import Window
import pytest
from qtpy.QtCore import QCoreApplication, QEvent
from support.window import application

REASON = 'b must be a number from 0 to 1, not 7.0: ' + 'and so on, ' * 20


class Told(Window):
    """A window with one node of many parameters, which a test answers for."""

    def __init__(self):
        self.asked = []
        super().__init__(self.asked.append, lambda: 0)
        names = [f'group.a parameter of a long name {letter}' for letter in 'abcdefghij']
        self.names = names
        self.model.take(Found({'wind': '/wind'}))
        self.model.take(Described('/wind', tuple(
            Descriptor(name, kind='float', low=0.0, high=1.0) for name in names) + (
                Descriptor('tracks', kind='strs'),),
            {**dict.fromkeys(names, 0.5), 'tracks': []}))
        self.show()
        self.panel.field('wind', names[0])  # which opens the section
        self.settle()

    def settle(self):
        """Let the window do what is due."""
        for _ in range(5):
            application().processEvents()
            QCoreApplication.sendPostedEvents(None, QEvent.DeferredDelete)

    def refuse(self, name, reason):
        """Ask for a value as a field does, and answer as the node does."""
        self.model.put('wind', {name: 7.0})
        self.model.take(Answered(self.asked[-1].token, {name: reason}))
        self.settle()

    def places(self):
        """Return where each field is, and how large."""
        return [(one.name, self.left(one), one.mapTo(self, one.rect().topLeft()).y(), one.size())
                for one in self.panel.fields()]

    def left(self, field):
        """Return where a field begins [pixels from the left]."""
        return field.mapTo(self, field.rect().topLeft()).x()

    def balloon(self, field):
        """Return what is told beside a field."""
        return field._balloon


@pytest.fixture
def window():
    """Return a window that a test answers for."""
    application()
    made = Told()
    yield made
    made.close()
    made.deleteLater()
    made.settle()


def test_a_refusal_moves_and_covers_nothing_of_the_panel(window):
    """What its user is about to click on stays where it is."""
    field, before = window.panel.field('wind', window.names[1]), window.places()
    assert len(before) == 10 and field.isVisible()
    window.refuse(field.name, REASON)
    balloon = window.balloon(field)
    assert field.refusal == REASON
    assert balloon.isVisible() and window.places() == before
    assert 0 <= balloon.x() and balloon.geometry().right() < window.left(field)
    assert abs(balloon.geometry().center().y()
               - field.mapTo(window, field.rect().center()).y()) <= 1
    window.refuse(field.name, '')
    assert not field.refusal and window.places() == before


def test_a_key_moves_nothing_either(window):
    """Its diamond has a place of its own before the name."""
    before = window.places()
    window.model.values['/wind']['tracks'] = [f'wind.{name}' for name in window.names]
    for field in window.panel.fields():
        field.show_value()
    window.settle()
    assert window.places() == before


def test_a_balloon_goes_along_with_its_field_and_hides_with_it(window):
    field = window.panel.field('wind', window.names[1])
    window.refuse(field.name, REASON)
    balloon, before = window.balloon(field), window.left(field)
    window.resize(window.width() + 80, window.height())
    window.settle()
    assert window.left(field) != before and balloon.geometry().right() < window.left(field)
    section = window.panel._sections['wind', 'group'][1]
    for is_open in (False, True):
        section.unfold(is_open)
        window.settle()
        assert balloon.isVisible() == is_open
    window.model.take(Found({}))  # a node that comes in its place has refused nothing
    assert not field.refusal
    window.model.take(Found({'wind': '/wind'}))
    window.model.take(Described('/wind', (Descriptor('speed', kind='float'),), {'speed': 1.0}))
    window.settle()
    assert not window.findChildren(Balloon)
