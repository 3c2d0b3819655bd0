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

"""Wind, physics, renderer and the viewer's window, on this host, until the window is closed."""
import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
import signal
import sys
import tempfile
import time

from flag_sim.parameters.arguments import given_path
from flag_sim.parameters.config import config_path
from flag_sim.tools.domains import NoDomain
from flag_sim.tools.graph import Graph
from flag_sim.viewer.shot_files import shipped

POLL_PERIOD = 0.1
"""How often to check whether the window is still there [s]."""
LIVE = ('pace:=realtime', 'frames:=0', 'loop:=true', 'wait_for:=[renderer]')
"""What holds of the wind instead of what a shot says: it is looked at, not filmed."""


def show(shot: Path, screenshot: Path | None, logs: Path,
         is_stopped: Callable[[], bool]) -> int:
    """
    Start all nodes with a params file; return the viewer's status once its window is closed.

    screenshot: PNG to be made, or None; logs: folder of the nodes' logs; is_stopped(): whether
    all is to end before.
    """
    given = '--params-file', str(shot)
    with Graph(logs) as graph:
        graph.start('physics', *given)
        graph.start('renderer', *given)
        graph.start('wind', *given, *(part for one in LIVE for part in ('-p', one)))
        viewer = graph.start('viewer', *(() if screenshot is None else (
            '-p', f'screenshot:={screenshot.absolute()}')))
        print(f'The window shows {shot.name}. To reach the nodes from another terminal:\n'
              f'export ROS_DOMAIN_ID={graph.domain} ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST\n'
              f'Their logs, as long as the window is there: {logs}',
              flush=True)
        told = set()
        while viewer.poll() is None and not is_stopped():
            for name in {*graph.failed()} - told:  # the window stays, and says what it lacks
                print(f'--- {name} has ended; it said:\n{graph.log(name)}', file=sys.stderr)
                told.add(name)
            time.sleep(POLL_PERIOD)
        if viewer.poll():
            print(graph.log('viewer'), file=sys.stderr)
        return viewer.poll() or 0


def main(args: Sequence[str] | None = None) -> int:
    """Show a shot or a preset of config/ in the window; return the exit status."""
    parser = argparse.ArgumentParser(prog='view', description=__doc__)
    parser.add_argument('--shot', default='gust',
                        help='a params file in config/, without .yaml (gust)')
    parser.add_argument('--screenshot', type=given_path, default=None,
                        help='PNG that is made of the window, which is then closed (none)')
    options = parser.parse_args(args)
    try:
        shot = config_path(f'{options.shot}.yaml')
    except FileNotFoundError:
        parser.error(f"no params file '{options.shot}' in config/; there are: "
                     + ', '.join(path.stem for paths in shipped().values() for path in paths))
    signals = []  # noted only: what they would raise could come while a process is started
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *one: signals.append(one))
    with tempfile.TemporaryDirectory(prefix='flag_sim-view-') as logs:
        try:
            return show(shot, options.screenshot, Path(logs), lambda: bool(signals))
        except NoDomain as error:
            print(error, file=sys.stderr)
            return 1


if __name__ == '__main__':
    sys.exit(main())
