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

"""What one value is edited with, by its descriptor: a box, a slider, a check box, a choice."""
from flag_sim.parameters.checks import shown
from flag_sim.parameters.descriptor import Descriptor
from flag_sim.viewer.number_box import NumberBox
from flag_sim.viewer.scales import Scale, STEPS
from qtpy.QtCore import QSignalBlocker, Qt, Signal
from qtpy.QtGui import QColor, QIcon, QPixmap
from qtpy.QtWidgets import QCheckBox, QColorDialog, QComboBox, QHBoxLayout, QLineEdit
from qtpy.QtWidgets import QPushButton, QSlider, QWidget
import yaml

LONGEST_ROW = 4
"""Numbers of a list that are shown each in a box of its own."""
LONGEST_TEXT = 10_000
"""Characters of a list that can be edited as a text; a longer one is shown by its length."""


class Editor(QWidget):
    """
    One value: asked(value) by its user; `show_value` shows what it is.

    refused: why what was typed is no value.
    """

    asked = Signal(object)
    refused = Signal(str)

    def __init__(self, descriptor: Descriptor):
        super().__init__()
        self.descriptor = descriptor
        self.row = QHBoxLayout(self)
        self.row.setContentsMargins(0, 0, 0, 0)

    def add(self, widget: QWidget, stretch: int = 0) -> QWidget:
        """Add a widget to the row, named for those who cannot see it."""
        widget.setAccessibleName(self.descriptor.name)
        widget.setToolTip(self.descriptor.tooltip)
        self.row.addWidget(widget, stretch)
        if self.focusProxy() is None:
            self.setFocusProxy(widget)
        return widget

    def show_value(self, value: object) -> None:
        """Show a value; it is not asked for."""
        raise NotImplementedError


class CheckEditor(Editor):
    """A boolean."""

    def __init__(self, descriptor: Descriptor):
        super().__init__(descriptor)
        self._box = self.add(QCheckBox(), 1)
        self._box.clicked.connect(lambda is_on: self.asked.emit(bool(is_on)))

    def show_value(self, value: object) -> None:
        """Show it as a mark."""
        self._box.setChecked(bool(value))


class ChoiceEditor(Editor):
    """One of a few texts or whole numbers."""

    def __init__(self, descriptor: Descriptor):
        super().__init__(descriptor)
        self._box = self.add(QComboBox(), 1)
        self._box.addItems([str(choice) for choice in descriptor.choices])
        self._box.setFocusPolicy(Qt.StrongFocus)
        self._box.activated.connect(
            lambda place: self.asked.emit(descriptor.choices[int(place)]))
        self._box.wheelEvent = lambda event: event.ignore()  # it scrolls the panel

    def show_value(self, value: object) -> None:
        """Show the choice."""
        self._box.setCurrentIndex(self._box.findText(str(value)))


class NumberEditor(Editor):
    """A number, with a slider where it has a range."""

    def __init__(self, descriptor: Descriptor):
        super().__init__(descriptor)
        is_whole = descriptor.kind == 'int'
        self._box = self.add(NumberBox(descriptor.low, descriptor.high, is_whole))
        self._box.asked.connect(self._ask)
        self._box.refused.connect(self.refused)
        self._slider = None
        if descriptor.low is not None and descriptor.high > descriptor.low:
            self._scale = Scale(descriptor.low, descriptor.high, is_whole)
            self._slider = self.add(QSlider(Qt.Horizontal), 1)
            self._slider.setRange(0, STEPS)
            self._slider.setPageStep(STEPS // 20)
            self._slider.setMinimumWidth(60)
            self._slider.valueChanged.connect(lambda place: self._ask(self._scale.value(place)))
            self._slider.wheelEvent = lambda event: event.ignore()

    def _ask(self, value):
        self._box.show_value(value)
        self.asked.emit(value)

    def show_value(self, value: object) -> None:
        """Show it in the box and, unless it is in a hand, on the slider."""
        if self._slider is not None and not self._slider.isSliderDown():
            with QSignalBlocker(self._slider):
                self._slider.setValue(self._scale.place(value))
        self._box.show_value(value)


class NumbersEditor(Editor):
    """A few numbers side by side."""

    def __init__(self, descriptor: Descriptor):
        super().__init__(descriptor)
        self._boxes = [self.add(NumberBox(descriptor.low, descriptor.high,
                                          descriptor.kind == 'ints'), 1)
                       for _ in range(descriptor.length)]
        self._value = [0.0] * descriptor.length
        for n, box in enumerate(self._boxes):
            box.setMinimumWidth(box.fontMetrics().horizontalAdvance('-0.00000') + 24)
            box.asked.connect(lambda one, n=n: self.asked.emit(
                [*self._value[:n], one, *self._value[n + 1:]]))
            box.refused.connect(self.refused)

    def show_value(self, value: object) -> None:
        """Show each."""
        self._value = [*value]
        for box, one in zip(self._boxes, self._value):
            box.show_value(one)


class ColourEditor(Editor):
    """A colour, as a button that opens a dialog; the flag changes while it is open."""

    def __init__(self, descriptor: Descriptor):
        super().__init__(descriptor)
        self._button = self.add(QPushButton(), 1)
        self._button.clicked.connect(self._choose)
        self._dialog = None
        self._colour = QColor()

    def _choose(self):
        if self._dialog is None:
            self._dialog = QColorDialog(self)
            self._dialog.setWindowTitle(self.descriptor.name)
            self._dialog.currentColorChanged.connect(self._ask)
            self._dialog.rejected.connect(lambda: self._ask(self._before))
        self._before = QColor(self._colour)
        with QSignalBlocker(self._dialog):
            self._dialog.setCurrentColor(self._colour)
        self._dialog.open()

    def _ask(self, colour):
        self.asked.emit([float(one) for one in (colour.red(), colour.green(), colour.blue())])

    def show_value(self, value: object) -> None:
        """Show it as a swatch, and in numbers."""
        self._colour = QColor(*(min(max(round(one), 0), 255) for one in value))
        swatch = QPixmap(32, 16)
        swatch.fill(self._colour)
        self._button.setIcon(QIcon(swatch))
        self._button.setText(', '.join(f'{one:g}' for one in value))


class TextEditor(Editor):
    """A text, or a list as it is typed in a params file."""

    def __init__(self, descriptor: Descriptor):
        super().__init__(descriptor)
        self._line = self.add(QLineEdit(), 1)
        self._line.editingFinished.connect(self._finish)
        self._shown = ''

    def _finish(self):
        text = self._line.text()
        if text == self._shown or self._line.isReadOnly():
            return
        value = text
        if self.descriptor.is_list:
            try:
                value = yaml.safe_load(text if text.strip().startswith('[') else f'[{text}]')
            except yaml.YAMLError:
                value = None
            if not isinstance(value, list):
                self._line.setText(self._shown)
                self.refused.emit(f'{shown(text)} is no list')
                return
        self._line.setText(self._shown)
        self.asked.emit(value)

    def show_value(self, value: object) -> None:
        """Show it as it is typed."""
        text = str(value)
        if self.descriptor.is_list:
            text = ', '.join(map(str, value[:LONGEST_TEXT]))
        self._line.setReadOnly(len(text) > LONGEST_TEXT)
        if len(text) > LONGEST_TEXT:
            text = f'{len(value)} {"values" if self.descriptor.is_list else "characters"}'
        self._shown = text
        self._line.setText(text)
        self._line.setCursorPosition(0)


def editor_of(descriptor: Descriptor) -> Editor:
    """Return what a parameter's value is edited with."""
    if descriptor.kind == 'bool':
        return CheckEditor(descriptor)
    if descriptor.choices:
        return ChoiceEditor(descriptor)
    if descriptor.kind in ('int', 'float'):
        return NumberEditor(descriptor)
    if descriptor.is_colour:
        return ColourEditor(descriptor)
    if descriptor.kind in ('ints', 'floats') and (descriptor.length or 99) <= LONGEST_ROW:
        return NumbersEditor(descriptor)
    return TextEditor(descriptor)
