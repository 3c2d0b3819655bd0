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

"""The window with all nodes as processes, and what is left of them when it is closed."""
import os
import signal
import subprocess
import sys
import time

from flag_sim.tools import view
from PIL import Image
import pytest
from support.qt import why_no_qt

pytestmark = pytest.mark.skipif(bool(why_no_qt()), reason=why_no_qt())
SECONDS = 120.0  # that a start may take: kernels may have to be compiled


def children_of(pid):
    """Return the ids of the processes that a process has started."""
    path = f'/proc/{pid}/task/{pid}/children'
    with open(path) as file:
        return [int(one) for one in file.read().split()]


def is_there(pid):
    """Return whether a process still runs."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def started(*arguments):
    """Start the command in a process of its own; return it once all four nodes are started."""
    process = subprocess.Popen(
        [sys.executable, '-m', 'flag_sim.tools.view', *arguments], stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True)
    end = time.monotonic() + SECONDS
    while len(children_of(process.pid)) < 4 and process.poll() is None:
        assert time.monotonic() < end
        time.sleep(0.05)
    return process, children_of(process.pid)


def test_the_screenshot_is_the_window_and_all_processes_end_with_it(tmp_path):
    """It shows the flag, on its background, beside the panel."""
    path = tmp_path / 'window.png'
    process, nodes = started('--shot', 'turn', '--screenshot', str(path))
    said, _ = process.communicate(timeout=SECONDS)
    assert process.returncode == 0, said
    assert len(nodes) == 4 and not any(map(is_there, nodes))
    with Image.open(path) as image:
        counts = {colour: count for count, colour in image.convert('RGB').getcolors(1 << 24)}
    assert counts[180, 240, 240] > 100_000  # the renderer's background
    assert sum(count for (r, g, b), count in counts.items() if r > 2 * g and r > 2 * b) > 2000


def test_all_processes_end_with_the_command(tmp_path):
    process, nodes = started('--shot', 'preview')
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=SECONDS)
    assert process.returncode == 0 and not any(map(is_there, nodes))


def test_an_unknown_shot_is_refused(capsys):
    with pytest.raises(SystemExit) as end:
        view.main(['--shot', 'nix'])
    said = capsys.readouterr().err
    assert end.value.code == 2 and "no params file 'nix' in config/; there are: calm, " in said
