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

"""The timeline below the picture: its rows, and what edits the key that is selected."""
from flag_sim.animation.laws import LAWS
from flag_sim.viewer.graph_model import GraphModel
from flag_sim.viewer.number_box import NumberBox
from flag_sim.viewer.timeline_hands import TimelineRows
from flag_sim.viewer.timeline_model import TimelineModel
from flag_sim.viewer.timeline_rows import ROW, RULER
from flag_sim.viewer.typed import like
from qtpy.QtCore import QSignalBlocker, QSize, Qt
from qtpy.QtWidgets import QCheckBox, QComboBox, QHBoxLayout, QLabel, QLineEdit, QPushButton
from qtpy.QtWidgets import QScrollArea, QVBoxLayout, QWidget

AUTOKEY = 'QPushButton:checked { background: #c62828; color: white; font-weight: bold; }'


class TimelinePanel(QWidget):
    """Shows and edits the keys of the wind's tracks. say(text): tells what was refused."""

    def __init__(self, graph: GraphModel, say):
        super().__init__()
        self._graph = graph
        self._say = say
        self.model = TimelineModel(graph, say)
        self.rows = TimelineRows(self.model)
        self._time = None
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addLayout(self._tools())
        self._area = QScrollArea()
        self._area.setWidget(self.rows)
        self._area.setWidgetResizable(True)
        self._area.setFocusPolicy(Qt.NoFocus)
        self._area.setMinimumHeight(RULER + ROW)
        column.addWidget(self._area, 1)
        self.rows.selection_changed.connect(self._show_selected)
        self.rows.add_asked.connect(self.add)
        self.rows.delete_asked.connect(self.delete)
        graph.on_nodes.append(self._show_switches)
        graph.on_values.append(lambda *_: self._show_switches())
        self._show_switches()
        self._show_selected()

    def sizeHint(self) -> QSize:
        """Return a size with room for a few rows."""
        return QSize(600, RULER + 3 * ROW + 40)

    def _tools(self):
        row = QHBoxLayout()
        self._autokey = QPushButton('\u25cf Auto&key')
        self._autokey.setCheckable(True)
        self._autokey.setStyleSheet(AUTOKEY)
        self._autokey.setToolTip('what is set on any node becomes a key at the playhead')
        self._autokey.clicked.connect(lambda is_on: self._graph.put('wind', {'autokey': is_on}))
        self._loop = QCheckBox('&Loop')
        self._loop.setToolTip('after the last key or event, begin with the first again')
        self._loop.clicked.connect(lambda is_on: self._graph.put('wind', {'loop': is_on}))
        self.law = QComboBox()
        self.law.addItems([*LAWS])
        self.law.setAccessibleName('law')
        self.law.setToolTip('how the value goes from this key to the next')
        self.law.activated.connect(lambda place: self._with_selected(
            lambda name, k: self.model.set_law(name, k, self.law.itemText(place))))
        self.key_time = NumberBox(-1e9, 1e9)
        self.key_time.setAccessibleName('time of the key')
        self.key_time.asked.connect(lambda time: self._move(time=time))
        self.key_time.refused.connect(self._say)
        self.key_value = QLineEdit()
        self.key_value.setAccessibleName('value of the key')
        self.key_value.setMinimumWidth(self.fontMetrics().averageCharWidth() * 18)
        self.key_value.editingFinished.connect(self._finish_value)
        for widget in (self._autokey, self._loop, None, QLabel('key at'), self.key_time,
                       QLabel('s:'), self.key_value, QLabel('then'), self.law):
            if widget is None:
                row.addStretch(1)
            else:
                row.addWidget(widget)
        return row

    # What is shown.

    def show_time(self, time: float | None) -> None:
        """Show the playhead at a time of the shot [s]; None nowhere."""
        self._time = time
        self.rows.show_playhead(time)

    def _show_switches(self):
        self.setEnabled(self._graph.is_known('wind'))
        self._autokey.setChecked(self._graph.wanted('wind', 'autokey') is True)
        self._loop.setChecked(self._graph.wanted('wind', 'loop') is True)

    def _selected(self):
        """Return (row, key) of what is selected, or None."""
        if self.rows.selected is None:
            return None
        name, k = self.rows.selected
        row = self.model.row(name)
        return None if row is None or k >= len(row.keys.times) else (row, k)

    def _show_selected(self):
        found = self._selected()
        for widget in (self.key_time, self.key_value, self.law):
            widget.setEnabled(found is not None)
        if found is None:
            self.key_time.show_value(None)
            self.key_value.clear()
            return
        row, k = found
        at = self.rows.point(self.model.rows.index(row), k)
        self._area.ensureVisible(self._area.horizontalScrollBar().value(), round(at.y()), 0, ROW)
        self.key_time.show_value(row.keys.times[k])
        self.key_value.setText(_words(row.keys.values[k]))
        with QSignalBlocker(self.law):
            self.law.setCurrentText(row.keys.laws[k])

    # What its user asks.

    def _with_selected(self, do):
        found = self._selected()
        if found is not None:
            do(found[0].name, found[1])

    def _finish_value(self):
        found = self._selected()
        if found is None or self.key_value.text() == _words(found[0].keys.values[found[1]]):
            return
        try:
            value = like(self.key_value.text(), found[0].keys.values[found[1]])
        except ValueError as error:
            self._say(str(error))
            self._show_selected()
        else:
            self._move(value=value)

    def _move(self, time=None, value=None):
        found = self._selected()
        if found is None:
            return
        row, k = found
        time = row.keys.times[k] if time is None else time
        value = row.keys.values[k] if value is None else value
        self.rows.selected = row.name, row.keys.moved(k, time, value)[1]
        self.model.move(row.name, k, time, value)

    def add(self) -> None:
        """
        Add a key at the playhead to the track of the selected key, or else to all.

        Where it is one, it is selected.
        """
        if self._time is None:
            return
        time = self.model.at_frame(self._time)
        found = self._selected()
        added = [(row.name, self.model.add(row.name, time))
                 for row in ([found[0]] if found else list(self.model.rows))]
        if len(added) == 1:
            self.rows.select(*added[0])

    def delete(self) -> None:
        """Delete the selected key."""
        self._with_selected(self.model.delete)

    def delete_track(self) -> None:
        """Delete the track of the selected key."""
        self._with_selected(lambda name, _: self.model.delete_track(name))

    def key_parameter(self, role: str, name: str) -> None:
        """Add a key of a parameter at the playhead, or at the begin where there is none."""
        self.model.key_parameter(role, name, self.model.at_frame(self._time or 0.0))


def _words(value):
    """Return a value as it is typed."""
    if isinstance(value, list):
        return ', '.join(f'{one:.6g}' for one in value)
    return f'{value:.6g}' if isinstance(value, float) else str(value)
