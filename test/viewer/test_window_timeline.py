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

"""The timeline on real nodes: keys that are dragged are where the wind has them."""
import math

import pytest
from qtpy.QtCore import QEvent, QPointF, Qt
from qtpy.QtGui import QMouseEvent
from qtpy.QtTest import QTest
from qtpy.QtWidgets import QApplication, QSlider
from support.window import Desk
import yaml

TIMES, VALUES = [0.0, 1.0, 2.0], [4.0, 8.0, 6.0]
TRACK = 'wind.speed'


@pytest.fixture(scope='module')
def shared(module_domain):
    """Return a window on nodes, of which the wind plays a loop."""
    with Desk(module_domain, f'tracks:=[{TRACK}]', f'keys.{TRACK}.times:={TIMES}',
              f'keys.{TRACK}.values:={VALUES}', 'loop:=true') as desk:
        desk.window.resize(1000, 800)
        yield desk


@pytest.fixture
def desk(shared):
    """Return the same window, with the same keys for each test."""
    wind = shared.nodes['wind']
    for name in [name for name in wind.values if name.startswith('keys.renderer')]:
        shared.put('wind', tracks=[TRACK])
        wind.set_parameters_atomically([_deletion(name)])
    shared.put_all('wind', {
        'tracks': [TRACK], f'keys.{TRACK}.times': TIMES, f'keys.{TRACK}.values': VALUES,
        f'keys.{TRACK}.laws': ['linear', 'cubic', 'step'], 'autokey': False})
    shared.until(lambda: [row.name for row in model(shared).rows] == [TRACK]
                 and [*keys(shared)[:3]] == [TIMES, VALUES, ['linear', 'cubic', 'step']]
                 and not model(shared)._asked and not model(shared)._under_way
                 and shared.model.value('wind', 'autokey') is False)
    shared.window.timeline.rows.select(None)
    return shared


def _deletion(name):
    from rclpy.parameter import Parameter
    return Parameter(name, Parameter.Type.NOT_SET)


def model(desk):
    """Return the timeline's model."""
    return desk.window.timeline.model


def keys(desk, track=TRACK):
    """Return the keys that the window shows."""
    return model(desk).row(track).keys


def at_wind(desk, part, track=TRACK):
    """Return what the wind itself has."""
    return desk.value('wind', f'keys.{track}.{part}')


def mouse(rows, kind, at, button=Qt.LeftButton, modifiers=Qt.NoModifier):
    """Send a mouse event to the rows."""
    QApplication.sendEvent(rows, QMouseEvent(
        kind, at, QPointF(rows.mapToGlobal(at.toPoint())), button, button, modifiers))


def drag(rows, begin, end, modifiers=Qt.NoModifier):
    """Drag from one point to another."""
    mouse(rows, QEvent.MouseButtonPress, begin)
    for n in range(1, 11):
        mouse(rows, QEvent.MouseMove, begin + (end - begin) * n / 10, Qt.LeftButton, modifiers)
    mouse(rows, QEvent.MouseButtonRelease, end)


def test_a_dragged_key_is_where_the_wind_has_it(desk, tmp_path):
    """And where the file then says; undo brings it back, redo brings it there again."""
    rows = desk.window.timeline.rows
    begin = rows.point(0, 1)
    end = QPointF(rows.times().x(1.5), rows.values(0).y(5.0))
    drag(rows, begin, end)
    desk.until(lambda: at_wind(desk, 'times')[1] != 1.0)
    time, value = at_wind(desk, 'times')[1], at_wind(desk, 'values')[1]
    assert time * 30.0 == pytest.approx(round(time * 30.0))  # at a frame
    assert (time, value) == (pytest.approx(1.5, abs=0.05), pytest.approx(5.0, abs=0.1))
    desk.until(lambda: model(desk).history.next_undo and not model(desk)._asked)
    assert keys(desk).times[1] == time
    assert (rows.point(0, 1) - end).manhattanLength() < 12.0
    desk.window.save(tmp_path / 'shot.yaml')
    saved = yaml.safe_load((tmp_path / 'shot.yaml').read_text())
    assert saved['/**/wind']['ros__parameters'][f'keys.{TRACK}.times'] == [0.0, time, 2.0]
    model(desk).undo()
    desk.until(lambda: at_wind(desk, 'times') == TIMES and at_wind(desk, 'values') == VALUES)
    desk.until(lambda: not model(desk)._under_way)
    model(desk).redo()
    desk.until(lambda: at_wind(desk, 'times')[1] == time)


def test_between_frames_with_shift_and_past_other_keys(desk):
    rows = desk.window.timeline.rows
    drag(rows, rows.point(0, 0), QPointF(rows.times().x(1.2345), rows.point(0, 0).y()),
         Qt.ShiftModifier)
    desk.until(lambda: at_wind(desk, 'times')[0] == 1.0)
    assert at_wind(desk, 'times')[1] == pytest.approx(1.2345, abs=0.01)
    assert at_wind(desk, 'laws') == ['cubic', 'linear', 'step']
    assert rows.selected == (TRACK, 1)


def test_keys_are_added_and_deleted_and_get_laws(desk):
    panel, rows = desk.window.timeline, desk.window.timeline.rows
    desk.until(lambda: panel._time is not None)
    panel.add()
    desk.until(lambda: len(at_wind(desk, 'times')) == 4)
    desk.until(lambda: not model(desk)._under_way)
    added = next(time for time in at_wind(desk, 'times') if time not in TIMES)
    assert rows.selected == (TRACK, at_wind(desk, 'times').index(added))
    assert float(panel.key_time.text()) == pytest.approx(added, rel=1e-4)
    panel.law.setFocus()
    QTest.keyClicks(panel.law, 'ease')
    desk.until(lambda: at_wind(desk, 'laws').count('ease') == 1)
    QTest.keyClick(rows, Qt.Key_Delete)
    desk.until(lambda: at_wind(desk, 'times') == TIMES)
    rows.select(None)
    assert panel.key_time.text() == panel.key_value.text() == ''
    at = QPointF(rows.times().x(1.5), rows.point(0, 1).y() + 30.0)
    mouse(rows, QEvent.MouseButtonDblClick, at)
    assert rows.selected == (TRACK, 2)
    QTest.keyClick(rows, Qt.Key_Delete)
    desk.until(lambda: at_wind(desk, 'times') == TIMES and not model(desk)._under_way)


def test_a_burst_of_undo_and_redo_is_done_to_its_end(desk):
    """They wait for the wind's answer to what was asked before them."""
    rows = desk.window.timeline.rows
    rows.select(TRACK, 1)
    for n in range(1, 6):
        QTest.keyClick(rows, Qt.Key_Right, Qt.AltModifier)
        desk.until(lambda: not model(desk)._under_way and not model(desk)._asked)
        assert at_wind(desk, 'times')[1] == pytest.approx(TIMES[1] + n / 30.0)
    for _ in range(5):
        model(desk).undo()
    desk.until(lambda: at_wind(desk, 'times') == TIMES)
    for _ in range(3):
        model(desk).redo()
    desk.until(lambda: at_wind(desk, 'times')[1] == pytest.approx(TIMES[1] + 0.1))
    desk.until(lambda: not model(desk)._under_way)


def test_the_keyboard_moves_a_key(desk):
    """By frames, quickly one after another, and by typing."""
    panel, rows = desk.window.timeline, desk.window.timeline.rows
    QTest.keyClick(rows, Qt.Key_Right)
    QTest.keyClick(rows, Qt.Key_Right)
    assert rows.selected == (TRACK, 1)
    for _ in range(6):
        QTest.keyClick(rows, Qt.Key_Right, Qt.AltModifier)
    QTest.keyClick(rows, Qt.Key_Up, Qt.AltModifier)
    desk.until(lambda: at_wind(desk, 'times')[1] == pytest.approx(1.2)
               and at_wind(desk, 'values')[1] > 8.0)
    panel.key_value.setText('3.5')
    panel.key_value.editingFinished.emit()
    desk.until(lambda: at_wind(desk, 'values')[1] == 3.5)


def test_what_the_wind_refuses_goes_back(desk):
    panel, rows = desk.window.timeline, desk.window.timeline.rows
    rows.select(TRACK, 1)
    panel.key_value.setText('1000')
    panel.key_value.editingFinished.emit()
    said = desk.window.statusBar().currentMessage
    desk.until(lambda: 'must be a number from 0 to 200 [m/s], not 1000.0' in said())
    assert keys(desk).values == VALUES == at_wind(desk, 'values')
    desk.until(lambda: panel.key_value.text() == '8')


def test_what_another_client_edits_is_shown_and_ends_a_drag(desk):
    """Undo does not put back what was there before the other's edit."""
    rows = desk.window.timeline.rows
    rows.select(TRACK, 1)
    QTest.keyClick(rows, Qt.Key_Right, Qt.AltModifier)
    desk.until(lambda: model(desk).history.next_undo and not model(desk)._under_way
               and not model(desk)._asked)
    begin = rows.point(0, 0)
    mouse(rows, QEvent.MouseButtonPress, begin)
    mouse(rows, QEvent.MouseMove, begin + QPointF(40, 0))
    others = {f'keys.{TRACK}.times': [0.0, 3.0], f'keys.{TRACK}.values': [1.0, 2.0],
              f'keys.{TRACK}.laws': ['step', 'step']}
    desk.put_all('wind', others)
    desk.until(lambda: keys(desk).times == [0.0, 3.0])
    mouse(rows, QEvent.MouseButtonRelease, begin + QPointF(40, 0))
    assert model(desk).history.next_undo is None
    model(desk).undo()
    desk.until(lambda: not model(desk)._under_way)
    assert at_wind(desk, 'times') == [0.0, 3.0]


def test_autokey_makes_keys_of_a_slider(desk):
    """Of the renderer's, through the wind; undo takes them away together."""
    panel = desk.window.timeline
    QTest.mouseClick(panel._autokey, Qt.LeftButton)
    desk.until(lambda: desk.value('wind', 'autokey') is True)
    slider = desk.window.panel.field('renderer', 'sun.elevation').findChild(QSlider)
    track = 'renderer.sun.elevation'
    for _ in range(3):
        QTest.keyClick(slider, Qt.Key_PageUp)
    desk.until(lambda: model(desk).row(track) is not None
               and desk.value('wind', 'tracks') == [TRACK, track]
               and not desk.model._requests.is_busy('/renderer'))
    assert desk.window.panel.field('renderer', 'sun.elevation')._diamond.text() == '\u25c6'


def test_a_parameter_is_keyed_from_its_field_and_its_track_deleted(desk):
    track = 'renderer.flag.color'
    panel = desk.window.timeline
    desk.window.panel.key_asked.emit('renderer', 'flag.color')
    desk.until(lambda: desk.value('wind', 'tracks') == [TRACK, track])
    assert at_wind(desk, 'values', track) == [205.0, 35.0, 40.0]
    desk.until(lambda: model(desk).row(track) is not None)
    assert model(desk).row(track).components == [0, 1, 2]
    panel.rows.select(track, 0)
    panel.delete_track()
    desk.until(lambda: desk.value('wind', 'tracks') == [TRACK]
               and at_wind(desk, 'times', track) is None)
    desk.until(lambda: not model(desk)._under_way)
    model(desk).undo()
    desk.until(lambda: desk.value('wind', 'tracks') == [TRACK, track])


def test_the_playhead_follows_the_stamps_round_the_loop(desk):
    """It is where the wind's values are."""
    panel = desk.window.timeline
    seen = []
    desk.until(lambda: seen.append(panel._time) or len(
        {round(time, 3) for time in seen if time is not None}) > 20)
    assert all(0.0 <= time <= 2.0 for time in seen if time is not None)
    place = desk.window.counter.place
    expected = model(desk).playhead(desk.window.counter.stamp, place)
    assert expected == pytest.approx(
        model(desk).timeline.local(place.index / 30.0), abs=1e-6)
    assert math.isfinite(expected)
