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

"""The demo: a shot played through four processes in lockstep, and pictures of it."""
import argparse
from collections.abc import Sequence
import importlib.util
import os
from pathlib import Path
import shutil
import sys
import time
from typing import NamedTuple

from flag_sim.parameters.arguments import given_path
from flag_sim.parameters.config import config_path
from flag_sim.parameters.file_targets import LARGEST, PARAMETERS
from flag_sim.parameters.plain_file import opened
from flag_sim.tools.domains import NoDomain
from flag_sim.tools.film import (
    count_images, images_of, write_animation, write_contact_sheet, write_movie)
from flag_sim.tools.graph import Graph
from flag_sim.tools.signals import noted_signals
from tqdm import tqdm
import yaml

SHOT = 'gust'
"""What is filmed unless another is named: the shot that is made to be shown."""
STALLED = 60.0
"""The demo gives up after this time without a new frame [s]."""
FIRST_STALLED = 300.0
"""The same before the first one [s]: kernels compile for half a minute, longer if it is busy."""
POLL_PERIOD = 0.1
"""How often to check the nodes [s]."""
LONGEST_LOOK = 1.0
"""A longer time between two checks means that this process was suspended [s]."""


class Progress:
    """
    Shows how many frames are recorded, and notices when no more come.

    waited: how long the first one took [s], None before it: its kernels may have been compiled.
    """

    def __init__(self, frames: int):
        self.waited = None
        self._begin = None   # steady time of the first look [s]
        self.bar = tqdm(total=frames, unit='frame', desc='filming')
        self._seen = None    # steady time of the last look [s]
        self._without = 0.0  # time since the last new frame, as far as it was seen [s]

    def look(self, frames: int, now: float) -> None:
        """Note at steady time `now` [s] how many frames are recorded."""
        self._without += 0.0 if self._seen is None else min(now - self._seen, LONGEST_LOOK)
        self._seen = now
        self._begin = now if self._begin is None else self._begin
        if frames and self.waited is None:
            self.waited = now - self._begin
            self.bar.unpause()  # the bar's frames a second are those from now on
        if frames > self.bar.n:
            self.bar.update(frames - self.bar.n)
            self._without = 0.0

    @property
    def is_stalled(self) -> bool:
        """Return whether no new frame has come for too long."""
        return self._without > (STALLED if self.bar.n else FIRST_STALLED)


class Played(NamedTuple):
    """
    How a shot was played.

    is_whole: whether wind and recorder have ended as they do after a whole shot. rate: frames a
    second, from the first to the last, or None; waited: see Progress.
    """

    is_whole: bool
    rate: float | None
    waited: float | None


def play(shot: Path, frames: int, out: Path, signals: Sequence) -> Played:
    """Play the params file `shot` into the bag out/demo, until something is added to `signals`."""
    arguments = ['--params-file', str(shot), '-p']
    with Graph(out / 'log') as graph:
        progress = Progress(frames)
        graph.start('physics', *arguments[:2])
        graph.start('renderer', *arguments[:2])
        recorder = graph.start(
            'recorder', *arguments, f'path:={out / "demo"}', '-p', 'storage:=mcap', '-p',
            'compression:=zstd', '-p', f'frames:={frames}')
        wind = graph.start('wind', *arguments, 'pace:=lockstep', '-p',
                           'wait_for:=[renderer, recorder]')
        while None in (wind.poll(), recorder.poll()) and not graph.failed():
            progress.look(int(graph.told('recorder').get('X_FLAG_SIM_FRAMES', 0)),
                          time.monotonic())
            if progress.is_stalled or signals:
                break
            time.sleep(POLL_PERIOD)
        told = graph.told('recorder')
        progress.look(int(told.get('X_FLAG_SIM_FRAMES', 0)), time.monotonic())
        progress.bar.close()
        is_whole = wind.poll() == 0 and recorder.poll() == 0
        # The logs of the nodes that failed say why; if none failed, any log may.
        for name in [] if signals else graph.failed() or ([] if is_whole else graph.processes):
            print(f'--- {name} said:\n{graph.log(name)}', file=sys.stderr)
        seconds = float(told.get('X_FLAG_SIM_SECONDS', 0.0))
        return Played(is_whole, (frames - 1) / seconds if seconds else None, progress.waited)


def frames_of(path: Path) -> int | None:
    """Return the number of frames of a params file, or None if it is not a shot."""
    try:
        with opened(path, LARGEST) as file:
            found = yaml.safe_load(file)
    except (OSError, ValueError, yaml.YAMLError):
        return None
    for key in ('/**/wind', PARAMETERS, 'frames'):
        found = found.get(key) if isinstance(found, dict) else None
    return found if type(found) is int else None


def shots() -> list[str]:
    """Return the names of the shots in config/."""
    return sorted(path.stem for path in config_path('fastdds.xml').parent.glob('*.yaml')
                  if frames_of(path))


def film(shot: Path, frames: int, out: Path) -> int:
    """Play the params file `shot`, make its pictures in `out`; return the exit status."""
    shutil.rmtree(out / 'demo', ignore_errors=True)
    for name in ('demo.mp4', 'demo.gif', 'demo.png'):
        (out / name).unlink(missing_ok=True)
    print(f'playing {shot.name}: {frames} frames through wind, physics, renderer and recorder')
    print('(the first time, compiling the kernels takes up to half a minute, longer where the '
          'machine is busy)')
    with noted_signals() as signals:
        try:
            played = play(shot, frames, out, signals)
        except NoDomain as error:
            print(error, file=sys.stderr)
            return 1
    if signals:
        print('ended before the shot was', file=sys.stderr)
        return 128 + signals[0]
    bag = out / 'demo'
    if not played.is_whole or count_images(bag) != frames:
        print('the shot did not reach its end', file=sys.stderr)
        return 1
    print('making the pictures', flush=True)
    made = {'demo': 'the bag: images, camera_info, vertices, parameters'}
    if importlib.util.find_spec('av'):
        write_movie(images_of(bag), out / 'demo.mp4')
        made['demo.mp4'] = 'the shot at its own speed and size'
    shown = write_animation(images_of(bag), out / 'demo.gif')
    write_contact_sheet(images_of(bag), frames, out / 'demo.png')
    made.update({'demo.gif': f'the shot at its own speed, smaller, {shown} of its frames',
                 'demo.png': 'a contact sheet'})
    rate = f' at {played.rate:.0f} frames/s' if played.rate else ''
    waited = '' if played.waited is None else f', the first after {played.waited:.0f} s'
    print(f'{frames} frames{rate}{waited}. Made:',
          *(f'  {str(out / name):{len(str(out)) + 10}} {what}' for name, what in made.items()),
          f'See it again, where ROS is installed: ros2 bag play {bag}', sep='\n')
    return 0


def main(args: Sequence[str] | None = None) -> int:
    """Film a shot of config/; return the exit status."""
    parser = argparse.ArgumentParser(prog='demo', description=__doc__)
    parser.add_argument('--shot', default=SHOT,
                        help=f'a params file in config/, without .yaml ({SHOT})')
    parser.add_argument('--out', type=given_path, default=Path('out'),
                        help='folder of what is made (out)')
    options = parser.parse_args(args)
    try:
        shot = config_path(f'{options.shot}.yaml')
    except FileNotFoundError:
        parser.error(f"no shot '{options.shot}' in config/; there are: {', '.join(shots())}")
    frames = frames_of(shot)
    if not frames:
        parser.error(f'{shot} is not a shot: it has no number of frames for the wind')
    try:
        options.out.mkdir(parents=True, exist_ok=True)
        if not os.access(options.out, os.W_OK):
            raise PermissionError('no permission to write there')
    except OSError as error:
        parser.error(f'out {options.out} cannot be written: {error.strerror or error}')
    return film(shot, frames, options.out)


if __name__ == '__main__':
    sys.exit(main())
