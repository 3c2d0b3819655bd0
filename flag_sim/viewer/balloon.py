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

"""A balloon: words beside a widget, over what is left of it, so that nothing has to make room."""
from qtpy.QtCore import QEvent, QPoint, Qt
from qtpy.QtGui import QPalette
from qtpy.QtWidgets import QFrame, QLabel, QWidget

GAP = 4
"""Between the balloon and its widget, and the window's edge [pixels]."""
NARROWEST = 160
"""Where there is less room to the left it covers some of the widget [pixels]."""
MOVES = (QEvent.Move, QEvent.Resize, QEvent.Show, QEvent.Hide, QEvent.LayoutRequest)


class Balloon(QLabel):
    """
    Words to the left of a widget, in its window; they go along with it, and hide with it.

    Its user can select them by the mouse.
    """

    def __init__(self, at: QWidget, text: str):
        super().__init__(text, at.window())
        self._at = at
        self.setTextFormat(Qt.PlainText)
        self.setWordWrap(True)
        self.setTextInteractionFlags(Qt.TextSelectableByMouse)
        self.setFrameStyle(QFrame.Box | QFrame.Plain)
        self.setMargin(GAP)
        self.setAutoFillBackground(True)
        self.setBackgroundRole(QPalette.ToolTipBase)
        self.setForegroundRole(QPalette.ToolTipText)
        place = at
        while place is not None:  # each moves it: a list that scrolls, a section that opens
            place.installEventFilter(self)
            place = None if place.isWindow() else place.parentWidget()
        at.destroyed.connect(self.deleteLater)
        self._follow()

    def eventFilter(self, watched, event) -> bool:
        """Follow the widget."""
        if event.type() in MOVES:
            self._follow()
        return False

    def _follow(self):
        """Stand beside the widget, as tall as the words are; hide while it is not seen."""
        window, seen = self.parentWidget(), self._at.visibleRegion().boundingRect()
        self.setVisible(seen.height() * 2 > self._at.height())
        if not self.isVisibleTo(window):
            return
        corner = self._at.mapTo(window, QPoint(0, 0))
        room = max(corner.x() - 2 * GAP, NARROWEST)
        width = min(room, self.fontMetrics().horizontalAdvance(self.text()) + 6 * GAP)
        height = self.heightForWidth(width)
        self.setGeometry(max(corner.x() - GAP - width, GAP),
                         corner.y() + (self._at.height() - height) // 2, width, height)
        self.raise_()
