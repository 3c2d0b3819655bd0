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

"""A field: a parameter's name, what its value is edited with, and why a value was refused."""
from flag_sim.parameters.descriptor import Descriptor
from flag_sim.viewer.balloon import Balloon
from flag_sim.viewer.editors import editor_of
from flag_sim.viewer.graph_model import GraphModel
from qtpy.QtCore import Signal
from qtpy.QtWidgets import QHBoxLayout, QLabel, QMenu, QWidget

LABEL_WIDTH = 21
"""Characters of the widest name that is not broken."""
KEYED = '\u25c6'  # a diamond, as keys on the timeline
REFUSED = '\u26a0 '


class Field(QWidget):
    """
    One parameter of the role's node. What is asked for stays shown until the node has answered.

    It is always of the same height: what is said of it later moves no other field.
    title: '' for the parameter's own name, without its group. key_asked(role, name): its user
    wants a key of it.
    """

    key_asked = Signal(str, str)

    def __init__(self, model: GraphModel, role: str, descriptor: Descriptor, title: str = ''):
        super().__init__()
        self.role, self.name = role, descriptor.name
        self._model = model
        self._title = title or descriptor.name.removeprefix(f'{descriptor.group}.')
        self._unit = f' [{descriptor.unit}]' if descriptor.unit else ''
        self.editor = editor_of(descriptor)
        self.editor.setEnabled(not descriptor.is_fixed and descriptor.kind != 'other')
        self.editor.asked.connect(self._ask)
        self.editor.refused.connect(self.answer)
        self._label = QLabel()
        self._label.setBuddy(self.editor)
        self._label.setToolTip(descriptor.tooltip)
        self._label.setWordWrap(True)
        self._label.setFixedWidth(self.fontMetrics().averageCharWidth() * LABEL_WIDTH)
        self._label.setText(f'{self._title}{self._unit}')
        self._diamond = QLabel()
        self._diamond.setFixedWidth(self.fontMetrics().horizontalAdvance(KEYED))
        self._balloon = None  # of the last refusal
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 1, 0, 1)
        row.addWidget(self._diamond)
        row.addWidget(self._label)
        row.addWidget(self.editor, 1)
        self.words = ' '.join((role, descriptor.name, self._title, descriptor.effect)).lower()
        self.show_value()

    @property
    def refusal(self) -> str:
        """Return why the last value was refused, as it is shown, or ''."""
        return self._balloon.text().removeprefix(REFUSED) if self._balloon else ''

    def show_value(self) -> None:
        """Show the value that the node has, and whether a track plays it."""
        value = self._model.wanted(self.role, self.name)
        if value is not None:
            self.editor.show_value(value)
        self._diamond.setText(KEYED if self._model.keyed(self.role, self.name) else '')

    def answer(self, reason: str) -> None:
        """Take the node's answer: show why it refused, with the value that it has, or nothing."""
        if self._balloon:
            self._balloon.deleteLater()
        self._balloon = Balloon(self, REFUSED + reason) if reason else None
        self.show_value()

    def _ask(self, value):
        self._model.put(self.role, {self.name: value})

    def contextMenuEvent(self, event) -> None:
        """Offer a key of the parameter."""
        menu = QMenu(self)
        action = menu.addAction('Key this parameter at the playhead\tCtrl+K')
        action.triggered.connect(lambda: self.key_asked.emit(self.role, self.name))
        menu.exec_(event.globalPos())
