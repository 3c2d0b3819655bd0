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

"""The panel: the source program's counters and buttons, and every parameter, by node and group."""
from flag_sim.parameters.descriptor import Descriptor
from flag_sim.viewer.field import Field
from flag_sim.viewer.graph_model import GraphModel, ROLES
from qtpy.QtCore import Qt, Signal
from qtpy.QtWidgets import QGroupBox, QHBoxLayout, QLabel, QLineEdit, QPushButton, QScrollArea
from qtpy.QtWidgets import QToolButton, QVBoxLayout, QWidget

COUNTERS = (
    ('wind', 'frames', 'frames'), ('wind', 'rate', 'rate'),
    ('physics', 'area_density', 'mass'), ('physics', 'stiffness', 'stiffness'),
    ('physics', 'damping', 'friction'), ('wind', 'speed', 'wind speed'))
"""The counters of the source text's program (sec. 2.5): role, parameter, title."""
HIDDEN = ('keys.', 'qos_overrides.', 'use_sim_time', 'start_type_description_service', 'tracks')
"""How names begin that are no field: keys are on the timeline, the others are of ROS."""


class Section(QWidget):
    """
    The fields of one group of a node; they are made when it is opened first.

    filled: that they are.
    """

    filled = Signal()

    def __init__(self, title: str, make: callable):
        super().__init__()
        self._make = make
        self.fields = None
        self._head = QToolButton()
        self._head.setText(title)
        self._head.setCheckable(True)
        self._head.setToolButtonStyle(Qt.ToolButtonTextBesideIcon)
        self._head.setAutoRaise(True)
        self._head.setFocusPolicy(Qt.StrongFocus)
        self._head.setArrowType(Qt.RightArrow)
        self._head.toggled.connect(self._show)
        self._body = QWidget()
        self._rows = QVBoxLayout(self._body)
        self._rows.setContentsMargins(12, 0, 0, 4)
        self._rows.setSpacing(0)
        self._body.hide()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self._head)
        column.addWidget(self._body)

    def unfold(self, is_open: bool) -> None:
        """Open or close it."""
        self._head.setChecked(is_open)

    def _show(self, is_open):
        if is_open:
            self.fill()
        self._head.setArrowType(Qt.DownArrow if is_open else Qt.RightArrow)
        self._body.setVisible(is_open)

    def fill(self) -> list[Field]:
        """Make the fields unless they are made; return them."""
        if self.fields is None:
            self.fields = self._make()
            for field in self.fields:
                self._rows.addWidget(field)
            self.filled.emit()
        return self.fields


class Panel(QWidget):
    """
    The fields of all nodes, which follow the model.

    restore, toggle and step: the buttons; key_asked(role, name): of a field; rearranged: that
    there are other fields than before.
    """

    restore, toggle, step, rearranged = Signal(), Signal(), Signal(), Signal()
    key_asked = Signal(str, str)

    def __init__(self, model: GraphModel):
        super().__init__()
        self._model = model
        self._sections = {}  # {(role, group): (its descriptors, Section)}
        self._counters = {}  # {(role, name): (descriptor, Field)}
        self._top = QGroupBox('Flag')
        self._top_rows = QVBoxLayout(self._top)
        self._top_rows.setSpacing(0)
        self.search = QLineEdit()
        self.search.setPlaceholderText('Search all parameters (Ctrl+F)')
        self.search.setAccessibleName('search parameters')
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._filter)
        inside = QWidget()
        self._list = QVBoxLayout(inside)
        self._list.setSpacing(2)
        self._nothing = QLabel('Nothing is known of any node yet.')
        self._nothing.setWordWrap(True)
        self._list.addWidget(self._nothing)
        self._list.addStretch(1)
        area = QScrollArea()
        area.setWidget(inside)
        area.setWidgetResizable(True)
        area.setFocusPolicy(Qt.NoFocus)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self._top)
        column.addLayout(self._buttons())
        column.addWidget(self.search)
        column.addWidget(area, 1)
        self.setMinimumWidth(self.fontMetrics().averageCharWidth() * 56)
        model.on_nodes.append(self._show_nodes)
        model.on_values.append(self._show_values)
        model.on_answer.append(self._show_answer)
        self._show_nodes()

    def _buttons(self):
        row = QHBoxLayout()
        self._run = QPushButton('&Pause')
        self._of_wind = []
        for button, signal, tip in (
                (QPushButton('&Restore the flag'), self.restore, 'back to the first frame'),
                (self._run, self.toggle, 'stop the wind, or let it blow on'),
                (QPushButton('&Step'), self.step, 'one frame, while paused')):
            button.setToolTip(tip)
            button.clicked.connect(lambda _=False, signal=signal: signal.emit())
            row.addWidget(button)
            self._of_wind.append(button)
        return row

    def fields(self) -> list[Field]:
        """Return all fields that were made."""
        return [field for _, field in self._counters.values()] + [
            field for _, section in self._sections.values() for field in section.fields or ()]

    def field(self, role: str, name: str) -> Field | None:
        """Return the field of a parameter, opening its section, or None."""
        found = self._sections.get((role, Descriptor(name).group))
        if found is None:
            return None
        found[1].unfold(True)
        return next((field for field in found[1].fields if field.name == name), None)

    # What the model tells.

    def _show_nodes(self):
        is_first = not self._sections
        for role in ROLES:
            # A player plays several roles; it is shown as the first of them.
            node = self._model.nodes.get(role)
            if self._model.is_known(role) and self._model.role_of(node) == role:
                self._show_groups(role)
        if is_first and self._sections:  # so that it is seen what the others hold
            next(iter(self._sections.values()))[1].unfold(True)
        for key, (_, section) in self._sections.items():
            section.setEnabled(self._model.is_known(key[0]))
        self._show_counters()
        self._nothing.setVisible(not self._sections)
        self.rearranged.emit()
        self._show_run()
        for field in self.fields():
            if self._model.is_known(field.role):
                field.show_value()
            else:
                field.answer('')  # a node that comes in its place has refused nothing

    def _show_groups(self, role):
        known = self._model.descriptors[self._model.nodes[role]].values()
        groups = {}
        for descriptor in sorted(known, key=lambda one: (one.group, one.name)):
            if not descriptor.name.startswith(HIDDEN):
                groups.setdefault(descriptor.group, []).append(descriptor)
        for gone in [key for key in self._sections
                     if key[0] == role and key[1] not in groups]:
            self._sections.pop(gone)[1].deleteLater()
        for group, descriptors in groups.items():
            made = self._sections.get((role, group))
            if made and made[0] == descriptors:
                continue
            section = Section(f'{role} \u203a {group or "general"}',
                              lambda role=role, own=descriptors: [
                                  self._field(role, one) for one in own])
            section.filled.connect(self.rearranged)
            if made:
                made[1].deleteLater()
            self._sections[role, group] = descriptors, section
        self._order()

    def _order(self):
        """Let the sections stand as the data flow: wind, physics, renderer."""
        order = sorted(self._sections, key=lambda key: (ROLES.index(key[0]), key[1]))
        for place, key in enumerate(order):
            self._list.insertWidget(place + 1, self._sections[key][1])

    def _show_counters(self):
        for role, name, title in COUNTERS:
            descriptor = self._model.descriptor(role, name)
            made = self._counters.get((role, name))
            if made and descriptor in (None, made[0]):
                made[1].setEnabled(descriptor is not None)
            elif descriptor is not None:
                field = self._field(role, descriptor, title)
                if made:
                    made[1].deleteLater()
                self._counters[role, name] = descriptor, field
        for place, key in enumerate(
                key[:2] for key in COUNTERS if key[:2] in self._counters):
            self._top_rows.insertWidget(place, self._counters[key][1])

    def _field(self, role: str, descriptor: Descriptor, title: str = ''):
        field = Field(self._model, role, descriptor, title)
        field.key_asked.connect(self.key_asked)
        return field

    def _show_values(self, role, names):
        keys_changed = role == 'wind' and 'tracks' in names
        for field in self.fields():
            if keys_changed or (field.role == role and field.name in names):
                field.show_value()
        if role == 'wind' and 'paused' in names:
            self._show_run()

    def _show_answer(self, role, reasons):
        for field in self.fields():
            if field.role == role and field.name in reasons:
                field.answer(reasons[field.name])

    def _show_run(self):
        is_paused = self._model.value('wind', 'paused') is True
        self._run.setText('&Run' if is_paused else '&Pause')
        for button in self._of_wind:
            button.setEnabled(self._model.is_known('wind'))

    def _filter(self, text):
        """Show the fields whose names or effects hold all words that are searched for."""
        words = text.lower().split()
        for _, section in self._sections.values():
            if not words:
                for field in section.fields or ():
                    field.setVisible(True)
                section.unfold(False)
                section.setVisible(True)
                continue
            found = [field for field in section.fill()
                     if all(word in field.words for word in words)]
            for field in section.fields:
                field.setVisible(field in found)
            section.unfold(bool(found))
            section.setVisible(bool(found))
