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

"""All keys of the window, as its help shows them."""
from html import escape

from qtpy.QtWidgets import QMenu, QMenuBar

HANDS = {
    'On the picture': (
        ('W A S D', 'shift the view'),
        ('+ and -, or the wheel', 'nearer, farther'),
        ('Shift and the arrows, or a drag with the right button', 'turn'),
        ('Home, or a double click', 'as it was at first'),
    ),
    'On the timeline': (
        ('the arrows, or a click', 'choose a key'),
        ('Alt and the arrows, or a drag', 'move it by whole frames, and in value'),
        ('Shift with a drag', 'move it between frames'),
        ('Insert, or a double click', 'a new key at the playhead, or under the mouse'),
        ('Delete', 'delete the key'),
        ('the wheel; Shift with the wheel', 'zoom in time; move in time'),
        ('Home', 'show all'),
    ),
    'On the panel': (
        ('Tab', 'to the next field'),
        ('the arrows', 'change a number or a slider'),
    ),
}
"""What hands do where no menu has it: {place: (keys, what they do)}."""


def keys_of(bar: QMenuBar) -> dict[str, list[tuple[str, str]]]:
    """Return {place: [(keys, what they do)]}: HANDS, and whatever has a key in the menus."""
    found = {place: [*rows] for place, rows in HANDS.items()}
    for entry in bar.actions():
        menu = entry.menu()
        rows = _rows(menu) if isinstance(menu, QMenu) else []
        if rows:
            found[f'Menu {_plain(entry.text())}'] = rows
    return found


def _rows(menu):
    return [(action.shortcut().toString(), _plain(action.text()))
            for action in menu.actions() if not action.shortcut().isEmpty()]


def _plain(text):
    return text.replace('&', '').rstrip('\u2026')


def keys_page(bar: QMenuBar) -> str:
    """Return the same as a table in HTML."""
    lines = []
    for place, rows in keys_of(bar).items():
        lines.append(f'<tr><th colspan="2" align="left">{escape(place)}</th></tr>')
        lines += [f'<tr><td>{escape(keys)}&nbsp;&nbsp;</td><td>{escape(what)}</td></tr>'
                  for keys, what in rows]
    return f'<table style="white-space: nowrap">{"".join(lines)}</table>'
