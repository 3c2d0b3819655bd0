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

"""The window on real nodes: what is shown is what they have, what is turned is what they get."""
import math

from flag_sim.viewer.keys_help import keys_page
import numpy as np
import pytest
from qtpy.QtCore import QPoint, QPointF, Qt
from qtpy.QtGui import QColor, QMouseEvent, QWheelEvent
from qtpy.QtTest import QTest
from qtpy.QtWidgets import QAbstractSpinBox, QApplication, QCheckBox, QComboBox, QMenu
from qtpy.QtWidgets import QSlider, QWidget
from support.window import Desk


@pytest.fixture(scope='module')
def desk(module_domain):
    """Return a window on wind, physics and renderer, which run."""
    with Desk(module_domain) as desk:
        desk.until(lambda: desk.window.counter.shown > 3)
        yield desk


def settled(desk, role, name):
    """Return the value that a node has, once the window knows the same."""
    desk.until(lambda: desk.model.value(role, name) == desk.value(role, name))
    return desk.value(role, name)


def edited(desk, role, name, kind):
    """Return the widget of a kind in the field of a parameter."""
    return desk.window.panel.field(role, name).findChild(kind)


def typed(box, text):
    """Type into a box as a person does."""
    line = box.lineEdit() if isinstance(box, QAbstractSpinBox) else box
    line.selectAll()
    QTest.keyClicks(line, text)
    QTest.keyClick(line, Qt.Key_Return)


def test_every_parameter_has_its_field(desk):
    """But for keys, and for what rclpy itself declares; each tells what its node tells of it."""
    panel = desk.window.panel
    for _, section in panel._sections.values():
        section.fill()
    fields = {(field.role, field.name): field for field in panel.fields()}
    for role, node in desk.nodes.items():
        for name, declaration in node._declarations.items():
            if name != 'tracks':
                words = fields[role, name].editor.descriptor.tooltip
                assert declaration.effect in words and declaration.rule.split(' [')[0] in words
                assert fields[role, name].editor.isEnabled() != declaration.fixed
    assert isinstance(edited(desk, 'physics', 'pole_collision', QCheckBox), QCheckBox)
    assert edited(desk, 'physics', 'solver', QComboBox).count() == 7
    assert edited(desk, 'renderer', 'flag.color', QSlider) is None


def test_what_is_typed_is_set(desk):
    typed(edited(desk, 'wind', 'speed', QAbstractSpinBox), '7.25')
    desk.until(lambda: desk.value('wind', 'speed') == 7.25)
    typed(edited(desk, 'renderer', 'camera.target', QAbstractSpinBox), '1.5')
    desk.until(lambda: desk.value('renderer', 'camera.target')[0] == 1.5)
    choice = edited(desk, 'renderer', 'samples', QComboBox)
    QTest.keyClicks(choice, '4')
    desk.until(lambda: desk.value('renderer', 'samples') == 4)
    check = edited(desk, 'physics', 'pole_collision', QCheckBox)
    QTest.keyClick(check, Qt.Key_Space)
    desk.until(lambda: desk.value('physics', 'pole_collision') is False)
    slider = edited(desk, 'wind', 'gust.length', QSlider)
    QTest.keyClick(slider, Qt.Key_End)
    desk.until(lambda: desk.value('wind', 'gust.length') == 1e4)


def test_a_colour_is_seen_while_it_is_chosen(desk):
    """And it is the one before if the dialog is cancelled."""
    before = settled(desk, 'renderer', 'pole.color')
    editor = desk.window.panel.field('renderer', 'pole.color').editor
    QTest.mouseClick(editor._button, Qt.LeftButton)
    editor._dialog.setCurrentColor(QColor(10, 200, 30))
    desk.until(lambda: desk.value('renderer', 'pole.color') == [10.0, 200.0, 30.0])
    desk.until(lambda: editor._button.text() == '10, 200, 30')
    editor._dialog.reject()
    desk.until(lambda: desk.value('renderer', 'pole.color') == before)


def test_what_a_node_refuses_comes_back_with_its_reason(desk):
    """In its own words, at the field, which shows the value that the node has."""
    before = settled(desk, 'wind', 'rate')
    field = desk.window.panel.field('wind', 'rate')
    box = field.findChild(QAbstractSpinBox)
    typed(box, '5000')
    desk.until(lambda: field.refusal)
    assert field.refusal == 'rate must be a number from 0.01 to 1000 [Hz], not 5000.0'
    assert float(box.text()) == before == desk.value('wind', 'rate')
    typed(box, '29')
    desk.until(lambda: desk.value('wind', 'rate') == 29.0)
    desk.until(lambda: not field.refusal)


def test_what_another_client_sets_is_shown(desk):
    desk.put('wind', speed=3.5)
    box = edited(desk, 'wind', 'speed', QAbstractSpinBox)
    desk.until(lambda: box.text() == '3.5')


def test_a_glance_at_a_value_does_not_round_it(desk):
    """Six digits are shown; to leave the box sets nothing."""
    desk.put('wind', speed=1.0 / 3.0)
    box = edited(desk, 'wind', 'speed', QAbstractSpinBox)
    desk.until(lambda: box.text() == '0.333333')
    QTest.keyClick(box.lineEdit(), Qt.Key_Return)
    desk.until(lambda: not desk.model._requests._under_way)
    assert desk.value('wind', 'speed') == 1.0 / 3.0


def test_the_search_finds_by_name_and_by_effect(desk):
    panel = desk.window.panel
    panel.search.setText('turbulence')
    shown = [field.name for field in panel.fields()
             if field.isVisibleTo(panel) and field not in
             [counter for _, counter in panel._counters.values()]]
    assert shown == ['gust.intensity']
    panel.search.setText('')


def test_the_picture_is_the_message(desk):
    """To the byte, at the picture's own size."""
    taken = []
    put = desk.viewer.exchange.put_picture
    desk.viewer.exchange.put_picture = lambda picture: (taken.append(picture), put(picture))
    try:
        desk.put('wind', paused=True)
        shown = desk.window.counter.shown
        desk.window.model.publish('step')
        desk.until(lambda: taken and desk.window.counter.shown > shown)
    finally:
        del desk.viewer.exchange.put_picture
        desk.put('wind', paused=False)
    picture, image = taken[-1], desk.window.view.image
    sent = np.frombuffer(picture.pixels, np.uint8).reshape(picture.height, picture.width, 3)
    bits = image.constBits()
    if hasattr(bits, 'setsize'):  # of PyQt
        bits.setsize(image.height() * image.bytesPerLine())
    pixels = np.frombuffer(bits, np.uint8).reshape(image.height(), image.width(), 4)
    np.testing.assert_array_equal(pixels[..., 2::-1], sent)


def test_the_buttons_stop_step_and_restore(desk):
    panel, counter = desk.window.panel, desk.window.counter
    desk.until(lambda: panel._run.text() == '&Pause')
    QTest.mouseClick(panel._run, Qt.LeftButton)
    desk.until(lambda: panel._run.text() == '&Run' and desk.value('wind', 'paused') is True)
    desk.until(lambda: 'paused' in desk.window.view.reason)
    assert desk.window.view.image is not None  # the last picture stays
    index = counter.place.index
    desk.window.panel.step.emit()
    desk.until(lambda: counter.place.index == index + 1)
    assert not desk.window.view.reason
    take = counter.place.take
    panel.restore.emit()
    QTest.keyClick(panel._run, Qt.Key_Space)
    desk.until(lambda: counter.place.take > take)


def dragged(view, *ways):
    """Drag with the right button from the middle by some ways, one after another."""
    at = QPointF(view.rect().center())
    for kind, way in ((QMouseEvent.MouseButtonPress, (0, 0)),
                      *((QMouseEvent.MouseMove, way) for way in ways),
                      (QMouseEvent.MouseButtonRelease, (0, 0))):
        at = at + QPointF(*way)
        QApplication.sendEvent(view, QMouseEvent(
            kind, at, QPointF(view.mapToGlobal(at.toPoint())), Qt.RightButton, Qt.RightButton,
            Qt.NoModifier))


def test_hands_turn_scale_shift_and_reset(desk):
    view = desk.window.view
    first = {name: settled(desk, 'renderer', name)
             for name in ('camera.azimuth', 'camera.distance', 'camera.target')}
    moves = 300
    asked = []
    ask, desk.model._ask = desk.model._ask, lambda request: (asked.append(request), ask(request))
    dragged(view, *[(1, 0)] * moves)
    desk.until(lambda: desk.value('renderer', 'camera.azimuth') == pytest.approx(
        math.remainder(first['camera.azimuth'] - 0.008 * moves, 2.0 * math.pi)))
    assert len(asked) < 5  # a fast mouse makes no queue
    desk.model._ask = ask
    QApplication.sendEvent(view, QWheelEvent(
        QPointF(20, 20), QPointF(20, 20), QPoint(), QPoint(0, 120), Qt.NoButton, Qt.NoModifier,
        Qt.NoScrollPhase, False))
    desk.until(lambda: desk.value('renderer', 'camera.distance') == pytest.approx(
        first['camera.distance'] / 1.1))
    QTest.keyClicks(view, 'w')
    desk.until(lambda: desk.value('renderer', 'camera.target')[2] > first['camera.target'][2])
    QTest.mouseDClick(view, Qt.LeftButton)
    met = desk.model.first_value
    desk.until(lambda: all(desk.value('renderer', name) == met('renderer', name)
                           for name in first))


def test_a_node_that_goes_and_comes_back(desk):
    """Its fields are grey meanwhile, what is shown stays, and the reason is told."""
    field = desk.window.panel.field('renderer', 'ambient')
    desk.end('renderer')
    desk.until(lambda: not field.isEnabled())
    desk.until(lambda: 'camera/image_raw' in desk.window.view.reason)
    assert 'ros2 run flag_sim renderer' in desk.window.view.reason
    shown = desk.window.counter.shown
    desk.start('renderer')
    desk.until(lambda: desk.window.panel.field('renderer', 'ambient').isEnabled()
               and desk.window.counter.shown > shown)
    assert not desk.window.view.reason


def test_the_keyboard_alone_reaches_everything(desk):
    """By Tab every widget that takes the keyboard, and by the menus all that the mouse does."""
    window = desk.window
    window.activateWindow()
    window.panel.search.setText('')
    window.panel.field('renderer', 'flag.color')
    window.view.setFocus()
    desk.until(window.view.hasFocus)
    reached = set()
    while QApplication.focusWidget() not in reached:
        reached.add(QApplication.focusWidget())
        window.focusNextChild()
    wanted = {widget for widget in window.findChildren(QWidget)
              if widget.focusPolicy() & Qt.TabFocus and widget.isVisibleTo(window)
              and widget.isEnabledTo(window) and widget.focusProxy() is None}
    missing = {widget for widget in wanted - reached
               if not any(widget.isAncestorOf(one) or one.isAncestorOf(widget)
                          for one in reached)}
    assert len(reached) > 40 and not missing
    shortcuts = {action.shortcut().toString() for menu in window.menuBar().findChildren(QMenu)
                 for action in menu.actions()}
    assert {'Ctrl+O', 'Ctrl+S', 'Ctrl+Z', 'Ctrl+I', 'Ctrl+K', 'F5', 'F6', 'F7', 'Ctrl+3'} <= (
        shortcuts)


def test_tab_goes_as_a_window_is_read(desk):
    """From the picture down the panel to the timeline, also to fields that were made late."""
    window = desk.window
    window.activateWindow()
    window.panel.search.setFocus()
    window.panel.search.setText('gravity')
    desk.until(window.panel.search.hasFocus)
    for _ in range(2):  # past the head of its section
        QTest.keyClick(QApplication.focusWidget(), Qt.Key_Tab)
    QTest.keyClick(QApplication.focusWidget(), Qt.Key_Down)
    desk.until(lambda: desk.value('physics', 'gravity') < 9.81)
    window.panel.search.setText('')
    window.view.setFocus()
    desk.until(window.view.hasFocus)
    stops = [window.view]
    while (widget := stops[-1].nextInFocusChain()) is not stops[0]:
        stops.append(widget)
    places = [stops.index(widget) for widget in (
        window.view, window.panel.fields()[0].findChild(QAbstractSpinBox),
        window.panel.search, window.panel.field('physics', 'gravity').findChild(QSlider),
        window.panel.field('renderer', 'ambient').findChild(QSlider), window.timeline.rows)]
    assert places == sorted(places)


def test_the_help_has_every_key_of_the_menus(desk):
    page = keys_page(desk.window.menuBar())
    actions = [action for entry in desk.window.menuBar().actions()
               for action in entry.menu().actions() if not action.shortcut().isEmpty()]
    assert len(actions) > 12
    for action in actions:
        assert f'<td>{action.shortcut().toString()}&nbsp;' in page
