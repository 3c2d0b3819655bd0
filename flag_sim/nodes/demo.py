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

"""The demo: a shot played through four processes in lockstep, and what was filmed as pictures."""
import argparse
import os
from pathlib import Path
import shutil
import sys
import time

from flag_sim.nodes import messages
from flag_sim.nodes.config import config_path
from flag_sim.nodes.domains import NoDomain
from flag_sim.nodes.film import images_of, write_animation, write_contact_sheet
from flag_sim.nodes.graph import Graph
from flag_sim.nodes.life import bring_profile
from flag_sim.nodes.topics import subscribe
from flag_sim.study.arguments import given_path
import rclpy
from tqdm import tqdm
import yaml

# Without a new frame for so long the demo gives up [s]. Kernels compile before the first one: in
# half a minute, and in one on a machine that is busy.
STALLED = 60.0
FIRST_STALLED = 300.0


class Progress:
    """Counts the frames that the recorder has safe, and the time from the first to the last."""

    def __init__(self, frames):
        self.bar = tqdm(total=frames, unit='frame', desc='filming')
        self.stamps = set()
        self.first = self.last = None
        self.changed = time.monotonic()

    def on_frame_done(self, message):
        """Note a frame; one that was sent again counts once."""
        stamp = messages.to_stamp(message.stamp)
        if message.frame_id != 'recorder' or stamp in self.stamps:
            return
        self.stamps.add(stamp)
        self.last = self.changed = time.monotonic()
        self.first = self.first or self.last
        self.bar.update()

    def is_stalled(self, now):
        """Return whether at steady time `now` [s] there is no hope for another frame."""
        return now - self.changed > (STALLED if self.stamps else FIRST_STALLED)

    @property
    def frames_per_second(self):
        """Return the rate of the frames after the first."""
        if self.bar.n < 2:
            return 0.0
        return (self.bar.n - 1) / (self.last - self.first)


def play(shot, frames, out):
    """Play the params file `shot` into the bag out/demo; return frames per second or None."""
    arguments = ['--params-file', str(shot), '-p']
    with Graph(out / 'log') as graph:
        # This process listens in, so it is part of the same graph as the nodes.
        os.environ.update(graph.environment)
        bring_profile()
        with rclpy.init():
            watcher = rclpy.create_node('demo')
            progress = Progress(frames)
            subscribe(watcher, 'frame_done', progress.on_frame_done)
            graph.start('physics', *arguments[:2])
            graph.start('renderer', *arguments[:2])
            graph.start('recorder', *arguments, f'path:={out / "demo"}', '-p', 'storage:=mcap',
                        '-p', 'compression:=zstd', '-p', f'frames:={frames}')
            wind = graph.start('wind', *arguments, 'pace:=lockstep', '-p',
                               'wait_for:=[renderer, recorder]')
            while wind.poll() is None and not graph.failed():
                rclpy.spin_once(watcher, timeout_sec=0.1)
                if progress.is_stalled(time.monotonic()):
                    break
            graph.wait('recorder', 10.0)
            progress.bar.close()
            is_whole = progress.bar.n >= frames
            # Whoever failed knows why; where nobody did, any node may.
            for name in graph.failed() or ([] if is_whole else graph.processes):
                print(f'--- {name} said:\n{graph.log(name)}', file=sys.stderr)
            return progress.frames_per_second if is_whole else None


def frames_of(path):
    """Return the number of frames of a params file, or None where it is not a shot."""
    wind = yaml.safe_load(path.read_text()).get('/wind', {})
    return wind.get('ros__parameters', {}).get('frames')


def shots():
    """Return the names of the shots in config/."""
    return sorted(path.stem for path in config_path('fastdds.xml').parent.glob('*.yaml')
                  if frames_of(path))


def main(args=None):
    """Play a shot, make its pictures, and say where they are."""
    parser = argparse.ArgumentParser(prog='demo', description=__doc__)
    parser.add_argument('--shot', default='gust', help='a params file in config/, without .yaml')
    parser.add_argument('--out', type=given_path, default=Path('out'),
                        help='folder of what is made')
    options = parser.parse_args(args)
    try:
        shot = config_path(f'{options.shot}.yaml')
    except FileNotFoundError:
        parser.error(f"no shot '{options.shot}' in config/; there are: {', '.join(shots())}")
    frames = frames_of(shot)
    if not frames:
        parser.error(f'{shot} is not a shot: it has no number of frames for /wind')

    out = options.out
    shutil.rmtree(out / 'demo', ignore_errors=True)
    print(f'playing {shot.name}: {frames} frames through wind, physics, renderer and recorder')
    print('(the first time, compiling the kernels takes up to half a minute)')
    try:
        rate = play(shot, frames, out)
    except NoDomain as error:
        parser.exit(1, f'{error}\n')
    if rate is None:
        print('the shot did not reach its end', file=sys.stderr)
        return 1
    images = list(images_of(out / 'demo'))
    write_animation(images, out / 'demo.gif')
    write_contact_sheet(images, out / 'demo.png')
    print(f'{frames} frames at {rate:.0f} frames/s. Made:\n'
          f'  {out / "demo"}      the bag: images, camera_info, vertices, parameters\n'
          f'  {out / "demo.gif"}  the shot at its own speed\n'
          f'  {out / "demo.png"}  a contact sheet\n'
          f'See it again, where ROS is installed: ros2 bag play {out / "demo"}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
