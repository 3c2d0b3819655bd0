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

"""The order in which Tab goes through a window: as its widgets are read."""
from collections.abc import Iterator
import itertools

from qtpy.QtCore import Qt
from qtpy.QtWidgets import QLayout, QScrollArea, QSplitter, QWidget


def order_tabs(window: QWidget) -> None:
    """
    Let Tab go through a widget as it is read: from left to right and down, pane by pane.

    Qt's own order is that in which the widgets were made, and fields are made as nodes come.
    """
    for one, following in itertools.pairwise(_in_reading_order(window)):
        QWidget.setTabOrder(one, following)


def _in_reading_order(part: QWidget | QLayout) -> Iterator[QWidget]:
    """Yield the widgets that Tab reaches, as layouts, splitters and scroll areas hold them."""
    if isinstance(part, QWidget) and part.focusPolicy() & Qt.TabFocus:
        yield part
    if isinstance(part, QSplitter):
        inside = [part.widget(place) for place in range(part.count())]
    elif isinstance(part, QScrollArea):
        inside = [part.widget()]
    else:
        layout = part if isinstance(part, QLayout) else part.layout()
        items = [layout.itemAt(place) for place in range(layout.count())] if layout else []
        inside = [item.widget() or item.layout() for item in items]
    for one in inside:
        if one is not None:
            yield from _in_reading_order(one)
