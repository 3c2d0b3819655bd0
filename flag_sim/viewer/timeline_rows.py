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

"""The rows of the timeline: curves, keys and the playhead."""
from flag_sim.viewer.timeline_geometry import curve, TimeScale, ValueScale
from flag_sim.viewer.timeline_model import Row, TimelineModel
from qtpy.QtCore import QPointF, QRect, QRectF, QSize, Qt, Signal
from qtpy.QtGui import QColor, QPainter, QPen, QPixmap, QPolygonF
from qtpy.QtWidgets import QWidget

RULER, ROW, MARGIN = 22, 54, 8
"""Heights of the ruler and of a row, and what is left free above and below a curve."""
KEY = 5
"""Half the size of a key."""
REACH = 9
"""How far from a key the mouse may be that takes it."""
COLOURS = [QColor(220, 70, 60), QColor(60, 160, 70), QColor(70, 110, 220), QColor(160, 120, 40)]
"""Of the numbers of a vector: as those of red, green and blue, or x, y and z."""
PLAYHEAD = QColor(230, 60, 50)


class Rows(QWidget):
    """
    Draws the rows of a TimelineModel; `selected` is (track, key) or None.

    A key is dragged to whole frames, with Shift to any time. selection_changed: another key is
    selected, or it has changed.
    """

    selection_changed = Signal()

    def __init__(self, model: TimelineModel):
        super().__init__()
        self._model = model
        self.selected = None
        self.scale = None  # a TimeScale, where its user has zoomed
        self._drag = None  # (Row, key, keys as they are dragged, place among them)
        self._playhead = None
        self._drawn = None  # what stands still, as a QPixmap
        self.setFocusPolicy(Qt.StrongFocus)
        self.setMouseTracking(True)
        self.setAccessibleName('timeline')
        self.setToolTip('Drag a key: in time and value (Shift: between frames); double click: a '
                        'new key;\narrows: choose a key; Alt and arrows: move it; Insert, Delete; '
                        'wheel: zoom in time, with Shift: move; Home: all')
        model.on_change.append(self.refresh)
        self.refresh()

    # What is where.

    @property
    def label_width(self) -> int:
        """Return how wide the names of the tracks stand."""
        names = [row.name for row in self._model.rows] or ['']
        widest = max(self.fontMetrics().horizontalAdvance(name) for name in names)
        return min(widest + 16, self.width() // 3)

    def times(self) -> TimeScale:
        """Return where times stand."""
        left, right = float(self.label_width + 12), float(max(self.width() - 16, 1))
        if self.scale is not None:
            return TimeScale(self.scale.begin, self.scale.end, left, right)
        return TimeScale(*self._model.extent(), left, max(right, left + 1.0))

    def values(self, place: int) -> ValueScale:
        """Return where the values of a row stand."""
        top = RULER + place * ROW
        low, high = self._model.rows[place].span or (0.0, 1.0)
        return ValueScale(low, high, top + ROW - MARGIN, top + MARGIN)

    def point(self, place: int, k: int) -> QPointF:
        """Return where a key of a row is drawn."""
        row = self._model.rows[place]
        keys = self._drag[2] if self._drag and self._drag[0].name == row.name else row.keys
        value, scale = keys.values[k], self.values(place)
        middle = RULER + (place + 0.5) * ROW
        y = middle if row.span is None or row.is_vector else scale.y(value)
        return QPointF(self.times().x(keys.times[k]), y)

    def sizeHint(self) -> QSize:
        """Return the size that all rows need."""
        return QSize(400, RULER + max(len(self._model.rows), 1) * ROW + 4)

    # What has changed.

    def refresh(self) -> None:
        """Show the model as it is now; a drag ends where somebody else has changed its keys."""
        if self._drag is not None and self._model.row(self._drag[0].name) is not self._drag[0]:
            self._drag = None
        if self.selected is not None:
            row = self._model.row(self.selected[0])
            if row is None:
                self.selected = None
            elif self.selected[1] >= len(row.keys.times):
                self.selected = row.name, len(row.keys.times) - 1
        self._drawn = None
        self.setMinimumHeight(self.sizeHint().height())
        self.update()
        self.selection_changed.emit()

    def show_playhead(self, time: float | None) -> None:
        """Show where in the shot the picture is [s]; None nowhere."""
        if time == self._playhead:
            return
        scale = self.times()
        for moment in (self._playhead, time):
            if moment is not None:
                self.update(QRect(round(scale.x(moment)) - 6, 0, 12, self.height()))
        self._playhead = time

    def select(self, name: str | None, k: int = 0) -> None:
        """Select a key of a track, or none."""
        self.selected = None if name is None else (name, k)
        self._drawn = None
        self.update()
        self.selection_changed.emit()

    # Drawing.

    def resizeEvent(self, _) -> None:
        """Draw anew."""
        self._drawn = None

    def changeEvent(self, event) -> None:
        """Draw anew in other colours and fonts."""
        self._drawn = None
        super().changeEvent(event)

    def paintEvent(self, _) -> None:
        """Show what stands still, and the playhead over it."""
        painter = QPainter(self)
        if self._drawn is None:
            ratio = self.devicePixelRatioF()
            self._drawn = QPixmap(QSize(round(self.width() * ratio),
                                        round(self.height() * ratio)))
            self._drawn.setDevicePixelRatio(ratio)
            self._drawn.fill(self.palette().base().color())
            inner = QPainter(self._drawn)
            inner.setFont(self.font())
            inner.setRenderHint(QPainter.Antialiasing)
            self._draw(inner)
            inner.end()
        painter.drawPixmap(0, 0, self._drawn)
        if self.hasFocus():
            painter.setPen(self.palette().highlight().color())
            painter.drawRect(self.rect().adjusted(0, 0, -1, -1))
        if self._playhead is not None:
            x = self.times().x(self._playhead)
            if x >= self.label_width:
                painter.setRenderHint(QPainter.Antialiasing)
                painter.setPen(QPen(PLAYHEAD, 1.5))
                painter.drawLine(QPointF(x, 0), QPointF(x, self.height()))
                painter.setBrush(PLAYHEAD)
                painter.drawPolygon(QPolygonF([QPointF(x - 5, 0), QPointF(x + 5, 0),
                                               QPointF(x, 7)]))

    def _draw(self, painter):
        text, scale = self.palette().text().color(), self.times()
        faint = QColor(text)
        faint.setAlpha(50)
        apart = 6.0 * self.fontMetrics().horizontalAdvance('00')
        for time in scale.ticks(apart):
            x = scale.x(time)
            painter.setPen(faint)
            painter.drawLine(QPointF(x, RULER - 4), QPointF(x, self.height()))
            painter.setPen(text)
            painter.drawText(QRectF(x - 60, 0, 120, RULER - 4), Qt.AlignCenter, f'{time:g} s')
        for time, name in self._model.events:
            painter.setPen(QPen(text, 1, Qt.DashLine))
            painter.drawLine(QPointF(scale.x(time), RULER), QPointF(scale.x(time), self.height()))
            painter.drawText(QPointF(scale.x(time) + 3, self.height() - 5), name)
        if not self._model.rows:
            painter.setPen(text)
            painter.drawText(self.rect().adjusted(8, RULER, -8, 0), Qt.AlignCenter,
                             'No track yet. Ctrl+K keys the parameter whose field is in use; with '
                             'autokey every change becomes a key.')
        for place, row in enumerate(self._model.rows):
            self._draw_row(painter, place, row, scale)

    def _draw_row(self, painter, place, row: Row, scale):
        text, top = self.palette().text().color(), RULER + place * ROW
        faint = QColor(text)
        faint.setAlpha(70)
        painter.setPen(faint)
        painter.drawLine(QPointF(0, top + ROW), QPointF(self.width(), top + ROW))
        painter.setPen(text)
        label = QRectF(6, top, self.label_width - 6, ROW)
        name = self.fontMetrics().elidedText(row.name, Qt.ElideMiddle, int(label.width()))
        painter.drawText(label, Qt.AlignVCenter | Qt.AlignLeft, name)
        painter.save()
        painter.setClipRect(QRectF(scale.left - 8, top, self.width(), ROW))
        if row.track is not None:
            heights = self.values(place)
            for component in row.components:
                colour = (self.palette().highlight().color() if component is None
                          else COLOURS[component % len(COLOURS)])
                painter.setPen(QPen(colour, 1.6))
                painter.drawPolyline(QPolygonF([
                    QPointF(scale.x(time), heights.y(value))
                    for time, value in curve(row.track, component, scale.begin, scale.end)]))
        painter.restore()
        for k in range(len(row.keys.times)):
            self._draw_key(painter, self.point(place, k), self._is_selected(row, k), text)

    def _is_selected(self, row, k):
        at = self._drag[3] if self._drag and self._drag[0].name == row.name else None
        return k == at if at is not None else (row.name, k) == self.selected

    def _draw_key(self, painter, at, is_selected, text):
        if at.x() < self.label_width:
            return
        size = KEY + 2 * is_selected
        painter.setPen(QPen(text, 1))
        painter.setBrush(self.palette().highlight() if is_selected else self.palette().base())
        painter.drawPolygon(QPolygonF([at + QPointF(*way) for way in (
            (0, -size), (size, 0), (0, size), (-size, 0))]))
        painter.setBrush(Qt.NoBrush)
