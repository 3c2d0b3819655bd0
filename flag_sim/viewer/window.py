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

"""The window: picture, panel and timeline, and what brings them together."""
from collections.abc import Callable
from pathlib import Path
import time

from flag_sim.protocol.cdr_image import ImageBytes
from flag_sim.viewer import menus, shot_files, status_line
from flag_sim.viewer.exchange import FramePlace
from flag_sim.viewer.frame_counter import FrameCounter
from flag_sim.viewer.graph_model import GraphModel, ROLES
from flag_sim.viewer.hands import Hands
from flag_sim.viewer.loading import Loader
from flag_sim.viewer.panel import Panel
from flag_sim.viewer.picture_view import PictureView, to_image
from flag_sim.viewer.reasons import why_still
from flag_sim.viewer.tab_order import order_tabs
from flag_sim.viewer.timeline_panel import TimelinePanel
from qtpy.QtCore import Qt, QTimer
from qtpy.QtWidgets import QLabel, QMainWindow, QSplitter, QVBoxLayout, QWidget

TICK = 250
"""How often the words are brought up to date [ms]: more often nobody reads them."""
PLAYHEAD_TICK = 50
"""How often the playhead moves [ms]."""
PATIENCE = 1.0
"""After how long without a picture the reason is told [s]."""
SAID = 10_000
"""How long a message stays in the status bar [ms]."""


class Window(QMainWindow):
    """
    The whole window.

    ask(request): hands a request to the thread of ROS. left_out(): how many pictures came while
    the window was busy with an earlier one.
    """

    def __init__(self, ask: Callable[[object], None], left_out: Callable[[], int]):
        super().__init__()
        self.model = GraphModel(ask)
        self.counter = FrameCounter()
        self._left_out = left_out
        self._unshown = ''  # why the images cannot be shown
        self.view = PictureView()
        self.panel = Panel(self.model)
        self.hands = Hands(self.view, self.model)
        self.hands.said.connect(self.say)
        self._frames, self._compute = QLabel(), QLabel()
        for label in (self._frames, self._compute):
            label.setTextInteractionFlags(Qt.TextSelectableByMouse)
        left = QWidget()
        column = QVBoxLayout(left)
        column.setContentsMargins(6, 6, 0, 0)
        column.addWidget(self.view, 1)
        column.addWidget(self._frames)
        column.addWidget(self._compute)
        top = QSplitter(Qt.Horizontal)
        top.addWidget(left)
        top.addWidget(self.panel)
        top.setStretchFactor(0, 1)
        top.setStretchFactor(1, 0)
        self.timeline = TimelinePanel(self.model, self.say)
        self._loader = Loader(self.model, self.timeline.model, self.say)
        whole = QSplitter(Qt.Vertical)
        whole.addWidget(top)
        whole.addWidget(self.timeline)
        whole.setStretchFactor(0, 1)
        whole.setStretchFactor(1, 0)
        self.setCentralWidget(whole)
        self.panel.key_asked.connect(self.timeline.key_parameter)
        self.panel.restore.connect(lambda: self.model.publish('reset'))
        self.panel.step.connect(lambda: self.model.publish('step'))
        self.panel.toggle.connect(self.toggle)
        self.panel.rearranged.connect(lambda: order_tabs(whole))
        order_tabs(whole)
        self.model.on_answer.append(self._tell_refusals)
        self.model.on_nodes.append(lambda: self.say(''))  # it was of who was there before
        menus.fill(self)
        self.statusBar()
        self.setWindowTitle('viewer')
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._tick)
        self._timer.start(TICK)
        self._play_timer = QTimer(self)
        self._play_timer.timeout.connect(self._show_time)
        self._play_timer.start(PLAYHEAD_TICK)
        self.view.setFocus()
        self.resize(1180, 860)
        top.setSizes([660, 520])
        self._tick()

    @property
    def is_settled(self) -> bool:
        """Return whether every node that is there has told all of itself."""
        return bool(self.model.nodes) and all(
            self.model.is_known(role) and self.model.report(role) for role in self.model.nodes)

    def say(self, text: str) -> None:
        """Tell something below for some seconds, in place of what was told before; '' nothing."""
        self.statusBar().showMessage(text, SAID)

    # What comes.

    def show_picture(self, picture: ImageBytes, place: FramePlace | None) -> None:
        """Show an image, with its frame's place in the shot if it is known."""
        image, self._unshown = to_image(picture)
        if image is not None:
            self.view.show_image(image)
        if self.view.reason != self._unshown:
            self.view.set_reason(self._unshown)
        self.counter.show(picture.stamp, place, time.monotonic())

    def show_unreadable(self, reason: str) -> None:
        """Say why an image cannot be shown, over the last one that could."""
        self._unshown = f'The images cannot be read: {reason}.'
        self.view.set_reason(self._unshown)

    def _tick(self):
        now = time.monotonic()
        self._frames.setText(status_line.frame_words(self.counter, now))
        self._frames.setToolTip(f'{self._left_out()} pictures came while the window was busy')
        self._compute.setText(status_line.compute_words(self.model))
        still = self.counter.still(now)
        rate = self.model.value('wind', 'rate') or 30.0
        if self.counter.last is None or still > max(PATIENCE, 3.0 / rate):
            self.view.set_reason(self._unshown or why_still(self.model, still))

    def _tell_refusals(self, role, reasons):
        refused = [f'{role}: {reason}' for reason in reasons.values() if reason]
        self.say('; '.join(refused))  # also of parameters whose field is not seen

    def _show_time(self):
        self.timeline.show_time(self.timeline.model.playhead(
            self.counter.stamp, self.counter.place))

    # What its user asks.

    def toggle(self) -> None:
        """Stop the wind, or let it blow on."""
        self.model.put('wind', {'paused': not self.model.wanted('wind', 'paused', False)})

    def load(self, path: Path) -> None:
        """Set what a params file holds for the nodes that are there: all of it, or nothing."""
        self._loader.load(path)

    def save(self, path: Path) -> None:
        """Write the parameters of all nodes that are there as a params file."""
        nodes = {self.model.nodes[role]: self.model.values[self.model.nodes[role]]
                 for role in ROLES if self.model.is_known(role)}
        if not nodes:
            self.say('nothing was saved: no node has told its parameters')
            return
        try:
            shot_files.save(path, nodes)
            self.say(f'saved: {path}')
        except (OSError, ValueError) as error:
            self.say(f'not saved: {error}')
