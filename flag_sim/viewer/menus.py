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

"""The menus of the window: whatever it can do, with its key."""
from pathlib import Path

from flag_sim.viewer import shot_files
from flag_sim.viewer.field import Field
from flag_sim.viewer.keys_help import keys_page
from qtpy.QtGui import QKeySequence
from qtpy.QtWidgets import QAction, QApplication, QFileDialog, QMainWindow, QMenu, QMessageBox

FILES = 'Params files (*.yaml *.yml)'


def add(menu: QMenu, text: str, do, keys: str = '') -> QAction:
    """Add an action to a menu; return it."""
    action = menu.addAction(text)
    action.triggered.connect(lambda _=False: do())
    if keys:
        action.setShortcut(QKeySequence(keys))
    return action


def fill(window: QMainWindow) -> None:
    """Give the window its menus."""
    bar = window.menuBar()
    files = bar.addMenu('&File')
    for title, paths in shot_files.shipped().items():
        menu = files.addMenu(f'Load one of the &{title}')
        menu.setToolTipsVisible(True)
        menu.setEnabled(bool(paths))
        for path in paths:
            action = add(menu, path.stem, lambda path=path: window.load(path))
            action.setToolTip(shot_files.comment_of(path))
    add(files, '&Load a params file\u2026', lambda: _load(window), 'Ctrl+O')
    add(files, '&Save all parameters\u2026', lambda: _save(window), 'Ctrl+S')
    add(files, 'Save a &picture of the window\u2026', lambda: _grab(window), 'Ctrl+P')
    files.addSeparator()
    add(files, '&Quit', window.close, 'Ctrl+Q')
    play = bar.addMenu('&Play')
    add(play, '&Run or pause', window.toggle, 'F5')
    add(play, '&Step', lambda: window.model.publish('step'), 'F6')
    add(play, 'Restore the &flag', lambda: window.model.publish('reset'), 'F7')
    keys = bar.addMenu('&Keys')
    line = window.timeline
    add(keys, '&Undo', line.model.undo, 'Ctrl+Z')
    add(keys, '&Redo', line.model.redo, 'Ctrl+Shift+Z')
    add(keys, '&Add a key at the playhead', line.add, 'Ctrl+I')
    add(keys, '&Key the parameter whose field is in use', lambda: _key(window), 'Ctrl+K')
    add(keys, '&Delete the selected key', line.delete, 'Ctrl+Del')
    add(keys, 'Delete its &track', line.delete_track, 'Ctrl+Shift+Del')
    go = bar.addMenu('&Go')
    add(go, 'To the &picture', window.view.setFocus, 'Ctrl+1')
    add(go, 'To the search for p&arameters', _all_selected(window), 'Ctrl+2')
    add(go, 'To the &timeline', window.timeline.rows.setFocus, 'Ctrl+3')
    add(go, '&Search', _all_selected(window), 'Ctrl+F')
    about = bar.addMenu('&Help')
    add(about, '&Keys and mouse', lambda: QMessageBox.information(
        window, 'Keys', keys_page(window.menuBar())), 'F1')


def _all_selected(window):
    def go():
        window.panel.search.setFocus()
        window.panel.search.selectAll()
    return go


def _key(window):
    widget = QApplication.focusWidget()
    while widget is not None and not isinstance(widget, Field):
        widget = widget.parentWidget()
    if widget is None:
        window.say('first go to the field of the parameter that is to be keyed')
    else:
        window.timeline.key_parameter(widget.role, widget.name)


def _load(window):
    path, _ = QFileDialog.getOpenFileName(window, 'Load a params file', '', FILES)
    if path:
        window.load(Path(path))


def _save(window):
    path, _ = QFileDialog.getSaveFileName(window, 'Save all parameters', 'my_shot.yaml', FILES)
    if path:
        window.save(Path(path))


def _grab(window):
    path, _ = QFileDialog.getSaveFileName(window, 'Save a picture of the window', 'viewer.png',
                                          'PNG (*.png)')
    if path:
        window.say(f'saved: {path}' if window.grab().save(path)
                   else f'{path} cannot be written')
