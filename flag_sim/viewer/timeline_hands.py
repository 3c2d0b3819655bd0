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

"""What mouse and keyboard do on the rows of the timeline."""
from flag_sim.viewer.timeline_rows import REACH, ROW, Rows, RULER
from qtpy.QtCore import QPointF, Qt, Signal

ZOOM = 1.2
"""By how much one step of the wheel shows less time."""


class TimelineRows(Rows):
    """
    Rows whose keys are dragged, added, moved and deleted.

    add_asked, delete_asked: a key at the playhead is to be added; the selected one is to go.
    """

    add_asked, delete_asked = Signal(), Signal()

    # The mouse.

    def _place(self, at: QPointF):
        place = int((at.y() - RULER) // ROW)
        return place if 0 <= place < len(self._model.rows) else None

    def _key_at(self, at: QPointF):
        """Return (place of the row, key) of the key near a point, or None."""
        place = self._place(at)
        if place is None:
            return None
        near = [((self.point(place, k) - at).manhattanLength(), k)
                for k in range(len(self._model.rows[place].keys.times))]
        distance, k = min(near)
        return (place, k) if distance <= REACH else None

    def mousePressEvent(self, event) -> None:
        """Select a key and take hold of it."""
        self.setFocus()
        if event.button() != Qt.LeftButton:
            return
        found = self._key_at(event.position())
        if found is None:
            self.select(None)
            return
        place, k = found
        row = self._model.rows[place]
        self.select(row.name, k)
        self._drag = row, k, row.keys, k

    def mouseMoveEvent(self, event) -> None:
        """Drag the key that is held."""
        if self._drag is None:
            near = self._key_at(event.position()) is not None
            self.setCursor(Qt.SizeAllCursor if near else Qt.ArrowCursor)
            return
        row, k, *_ = self._drag
        place = self._model.rows.index(row)
        time = self.times().time(event.position().x())
        if not event.modifiers() & Qt.ShiftModifier:
            time = self._model.at_frame(time)
        value = row.keys.values[k]
        if row.span is not None and not row.is_vector:
            value = self._bounded(row, self.values(place).value(event.position().y()))
        moved = row.keys.moved(k, time, value)
        if len(moved[0].times) < len(row.keys.times):
            return  # on another key
        self._drag = row, k, *moved
        self._drawn = None
        self.update()

    @staticmethod
    def _bounded(row, value):
        descriptor = row.descriptor
        if descriptor.low is not None and not row.keys.turns:
            value = min(max(value, descriptor.low), descriptor.high)
        return float(round(value)) if descriptor.kind == 'int' else value

    def mouseReleaseEvent(self, event) -> None:
        """Let go: the key is moved there."""
        if event.button() != Qt.LeftButton or self._drag is None:
            return
        (row, k, keys, place), self._drag = self._drag, None
        if keys == row.keys:
            return
        self.selected = row.name, place
        self._model.move(row.name, k, keys.times[place], keys.values[place])

    def mouseDoubleClickEvent(self, event) -> None:
        """Add a key where the curve is at that time, and select it."""
        place = self._place(event.position())
        if place is not None and event.button() == Qt.LeftButton and not (
                self._key_at(event.position())):
            self._drag = None
            time = self._model.at_frame(self.times().time(event.position().x()))
            name = self._model.rows[place].name
            self.select(name, self._model.add(name, time))

    def wheelEvent(self, event) -> None:
        """Zoom in time, or with Shift move; without a key it scrolls the rows if they are many."""
        steps = (event.angleDelta().y() or event.angleDelta().x()) / 120.0
        if event.modifiers() & Qt.ShiftModifier:
            self.scale = self.times().shifted(-0.1 * steps)
        elif event.modifiers() & Qt.ControlModifier or not self._scrolls():
            self.scale = self.times().zoomed(event.position().x(), ZOOM ** -steps)
        else:
            event.ignore()
            return
        self._drawn = None
        self.update()
        event.accept()

    def _scrolls(self):
        parent = self.parentWidget()
        return parent is not None and parent.height() < self.height()

    # The keyboard.

    def keyPressEvent(self, event) -> None:
        """Choose, move, add and delete keys."""
        key, moves = event.key(), event.modifiers() & Qt.AltModifier
        arrows = {Qt.Key_Left: (-1, 0), Qt.Key_Right: (1, 0),
                  Qt.Key_Up: (0, 1), Qt.Key_Down: (0, -1)}
        if key in arrows and moves:
            self._nudge(*arrows[key])
        elif key in arrows:
            self._choose(arrows[key][0], -arrows[key][1])
        elif key == Qt.Key_Insert:
            self.add_asked.emit()
        elif key in (Qt.Key_Delete, Qt.Key_Backspace):
            self.delete_asked.emit()
        elif key == Qt.Key_Home:
            self.scale = self._drawn = None
            self.update()
        else:
            super().keyPressEvent(event)

    def _choose(self, along, down):
        """Select the next key of a track, or the nearest of the next track."""
        rows = self._model.rows
        if not rows:
            return
        if self.selected is None:
            self.select(rows[0].name, 0)
            return
        name, k = self.selected
        place = next(n for n, row in enumerate(rows) if row.name == name)
        time = rows[place].keys.times[k]
        row = rows[min(max(place + down, 0), len(rows) - 1)]
        if down:
            k = min(range(len(row.keys.times)), key=lambda n: abs(row.keys.times[n] - time))
        self.select(row.name, min(max(k + along, 0), len(row.keys.times) - 1))

    def _nudge(self, frames, steps):
        """Move the selected key by frames, or by hundredths of what its row shows."""
        if self.selected is None:
            return
        name, k = self.selected
        row = self._model.row(name)
        frame = self._model.at_frame
        time, value = row.keys.times[k], row.keys.values[k]
        if frames:
            time = frame(time + frames * self._model.frame)
        if steps and row.span is not None and not row.is_vector:
            step = 1.0 if row.descriptor.kind == 'int' else (row.span[1] - row.span[0]) / 100.0
            value = self._bounded(row, float(f'{value + steps * step:.6g}'))
        keys, place = row.keys.moved(k, time, value)
        if len(keys.times) == len(row.keys.times) and keys != row.keys:
            self.selected = name, place
            self._model.move(name, k, time, value)
