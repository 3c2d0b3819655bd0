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

"""The window's process: whether there is a display, the event loop, and what wakes it."""
from collections.abc import Callable
import os
import subprocess
import sys
import traceback

from flag_sim.viewer.exchange import Exchange, Unreadable
from flag_sim.viewer.window import Window
import qtpy
from qtpy import API_NAME
from qtpy.QtCore import QCoreApplication, QObject, Qt, QTimer, Signal
from qtpy.QtWidgets import QApplication

TRIAL = 'from qtpy.QtWidgets import QApplication; QApplication([])'
NEEDS_NO_DISPLAY = ('offscreen', 'minimal', 'vnc', 'linuxfb', 'eglfs')
CALLS = 100
"""Of Qt, after which it is seen whether they lose references."""
TRIAL_TIMEOUT = 30.0
"""How long Qt may take to open the display [s]."""
SCREENSHOT_FRAMES = 90
"""After so many pictures the window is saved: counters and states are there by then."""


def why_unsound() -> str:
    """
    Return in words why Qt's binding would end this process sooner or later, or ''.

    That of PySide6 6.12 takes None to be immortal, which it is from Python 3.12 on; with an older
    one every call loses a reference to it, and where none is left Python ends.
    """
    before = sys.getrefcount(None)
    for _ in range(CALLS):
        QCoreApplication.processEvents()
    if sys.getrefcount(None) > before - CALLS // 2:
        return ''
    return (f'{API_NAME} {qtpy.PYSIDE_VERSION or qtpy.PYQT_VERSION} does not work with this '
            "Python; install another one: pip install 'PySide6-Essentials<6.12'")


def why_no_display() -> str:
    """
    Return in words why no window can be opened here, or ''.

    Qt ends the process where it cannot open one, so it is tried in another process.
    """
    if os.environ.get('QT_QPA_PLATFORM', '').partition(':')[0] in NEEDS_NO_DISPLAY:
        return ''
    try:
        done = subprocess.run([sys.executable, '-c', TRIAL], capture_output=True, text=True,
                              timeout=TRIAL_TIMEOUT)
        said = done.stderr.strip() if done.returncode else ''
    except subprocess.TimeoutExpired:
        said = f'it did not open within {TRIAL_TIMEOUT:g} s'
    if not said:
        return ''
    display = os.environ.get('DISPLAY') or os.environ.get('WAYLAND_DISPLAY')
    lines = [line for line in said.splitlines() if line.strip()]
    return '\n'.join([
        f'Qt cannot open a window on the display {display}:' if display else
        'there is no display to open a window on (neither DISPLAY nor WAYLAND_DISPLAY is set):',
        *lines[:4], 'over ssh, log in with ssh -X; a picture of the window needs no display:',
        'set QT_QPA_PLATFORM=offscreen and the parameter screenshot'])


class Bridge(QObject):
    """Brings what the thread of ROS has left, or that the process is to end, to the window's."""

    woken = Signal()
    ended = Signal()

    def __init__(self, window: Window, exchange: Exchange):
        super().__init__()
        self._window = window
        self._exchange = exchange
        self.woken.connect(self._take)  # in the window's thread, wherever it is emitted
        # Queued also where it is emitted here: a window that is closed before the event loop runs
        # ends nothing.
        self.ended.connect(window.close, Qt.QueuedConnection)
        exchange.wake_window = self.woken.emit

    def _take(self):
        news, picture = self._exchange.news()
        for one in news:
            if isinstance(one, Unreadable):
                self._window.show_unreadable(one.reason)
            else:
                self._window.model.take(one)
        if picture is not None:
            self._window.show_picture(*picture)


def run_window(exchange: Exchange, screenshot: str,
               when_ended: Callable[[Callable], None]) -> int:
    """
    Show the window until it is closed; return the exit status.

    screenshot: a PNG to be made once SCREENSHOT_FRAMES pictures are shown, whereafter the window
    is closed; '' for none. when_ended(function): has the function called, in any thread, when
    the process is told to end.
    """
    # What a slot raises would end the process in PyQt; here it is told, and the window goes on.
    sys.excepthook = lambda *error: traceback.print_exception(*error)
    application = QApplication.instance() or QApplication(['viewer'])
    application.setApplicationDisplayName('flag_sim')
    window = Window(exchange.ask, lambda: exchange.left_out)
    bridge = Bridge(window, exchange)
    window.show()
    exchange.wake_window()  # for what came before there was a window
    when_ended(lambda _: bridge.ended.emit())
    status = [0]
    timer = QTimer()
    if screenshot:
        def look():
            if window.counter.shown >= SCREENSHOT_FRAMES and window.is_settled:
                timer.stop()
                status[0] = int(not window.grab().save(screenshot))
                if status[0]:
                    print(f'the screenshot {screenshot} cannot be written', file=sys.stderr)
                window.close()
        timer.timeout.connect(look)
        timer.start(200)
    application.exec_()
    exchange.wake_window = None
    return status[0]
