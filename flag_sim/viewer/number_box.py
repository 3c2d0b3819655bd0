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

"""A box for one number, which shows six digits of it and keeps all of them."""
import math

from flag_sim.viewer.typed import number
from qtpy.QtCore import QSize, Qt, Signal
from qtpy.QtGui import QValidator
from qtpy.QtWidgets import QAbstractSpinBox

DIGITS = 6


def step_of(value: float, is_whole: bool) -> float:
    """Return by how much an arrow changes a value: a tenth of its power of ten."""
    if not value:
        return 1.0 if is_whole else 0.1
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 1)
    return max(step, 1.0) if is_whole else step


class NumberBox(QAbstractSpinBox):
    """
    Asks for what is typed or stepped to; what it shows is what `show_value` was told last.

    low, high: where the arrows end, or None; any number can be typed, as the node says what it
    refuses. asked: a float, or an int where is_whole; refused: why a text is none.
    """

    asked = Signal(object)
    refused = Signal(str)

    def __init__(self, low: float | None = None, high: float | None = None,
                 is_whole: bool = False):
        super().__init__()
        self._low = -math.inf if low is None else low
        self._high = math.inf if high is None else high
        self._is_whole = is_whole
        self._value = 0
        self.setKeyboardTracking(False)
        self.setFocusPolicy(Qt.StrongFocus)
        self.setMinimumWidth(self.fontMetrics().horizontalAdvance('-0.00000e-00') + 16)
        self.editingFinished.connect(self._finish)
        self.show_value(0)

    def show_value(self, value: float | None) -> None:
        """Show a value, or nothing; it is not asked for."""
        self._value = value
        self.lineEdit().setText(self._text(value))

    def _text(self, value):
        if value is None:
            return ''
        return f'{value}' if self._is_whole else f'{value:.{DIGITS}g}'

    def _finish(self):
        text = self.text().strip()
        if text == self._text(self._value):
            return
        self.lineEdit().setText(self._text(self._value))
        try:
            value = number(text, self._is_whole)
        except ValueError as error:
            self.refused.emit(str(error))
        else:
            self.asked.emit(value)

    # What Qt asks.

    def sizeHint(self) -> QSize:
        """Return a size for a few digits, whatever the value is."""
        return QSize(self.minimumWidth(), super().sizeHint().height())

    def validate(self, text: str, place: int) -> tuple:
        """Take all that is typed: a letter that was left out would make it another number."""
        return QValidator.Acceptable, text, place

    def stepEnabled(self) -> QAbstractSpinBox.StepEnabled:
        """Return which of the arrows lead on."""
        if self.isReadOnly() or self._value is None:
            return QAbstractSpinBox.StepNone
        up = (QAbstractSpinBox.StepUpEnabled if self._value < self._high
              else QAbstractSpinBox.StepNone)
        down = (QAbstractSpinBox.StepDownEnabled if self._value > self._low
                else QAbstractSpinBox.StepNone)
        return up | down

    def stepBy(self, steps: int) -> None:
        """Ask for the value so many steps away."""
        step = step_of(self._value, self._is_whole)
        value = min(max(self._value + steps * step, self._low), self._high)
        value = round(value) if self._is_whole else float(f'{value:.12g}')
        self.show_value(value)
        self.asked.emit(value)

    def wheelEvent(self, event) -> None:
        """Step only where it has the keyboard: else the panel is scrolled."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()
