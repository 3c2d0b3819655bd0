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

"""The demo: which shots there are, and when it gives up."""
import re
import signal
import subprocess
import sys
import time

from flag_sim.parameters.config import config_path
from flag_sim.tools import demo
from PIL import Image
import pytest
from support.children import children_of, is_there
from support.soak import SOAK
import yaml


@pytest.mark.parametrize('shot, said', [
    ('nix', "no shot 'nix' in config/; there are: calm, flight, gust, parade, storm, sunrise, "
     'turn'),
    ('preview', 'preview.yaml is not a shot: it has no number of frames')])
def test_an_invalid_shot_is_refused_with_the_names_of_the_valid_ones(capsys, shot, said):
    """Presets and the profile of the network are in the same folder and none of them."""
    with pytest.raises(SystemExit):
        demo.main(['--shot', shot])
    assert said in capsys.readouterr().err


@pytest.mark.parametrize('out', ['file', 'file/below', '/proc/x'])
def test_a_folder_that_cannot_be_written_is_one_line_and_status_2(tmp_path, capsys, out):
    """As the study's output is; nothing is started."""
    (tmp_path / 'file').write_text('something else')
    with pytest.raises(SystemExit) as end:
        demo.main(['--out', str(tmp_path / out)])
    said = capsys.readouterr().err.splitlines()[-1]
    assert end.value.code == 2 and f'{tmp_path / out} cannot be written' in said
    assert 'Errno' not in said


@pytest.mark.parametrize('content', [
    '[1]', 'a: b: c', '/**/wind: 3', '/**/wind: {ros__parameters: {frames: many}}', '\xff'])
def test_a_file_elsewhere_that_is_no_shot_is_refused(tmp_path, capsys, content):
    (tmp_path / 'mine.yaml').write_bytes(content.encode('latin-1'))
    with pytest.raises(SystemExit) as end:
        demo.main(['--shot', str(tmp_path / 'mine'), '--out', str(tmp_path / 'out')])
    assert end.value.code == 2 and 'is not a shot' in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()


def test_every_shot_has_frames():
    """As many as its file says."""
    assert demo.frames_of(config_path('gust.yaml')) > 1


def test_kernels_have_time_to_compile_and_a_shot_that_stands_still_ends():
    """Five minutes to the first frame, and one from a frame to the next."""
    progress = demo.Progress(10)

    def wait(seconds, frames):
        for _ in range(2 * seconds):
            now[0] += 0.5
            progress.look(frames, now[0])
        return progress.is_stalled
    now = [1000.0]
    progress.look(0, now[0])
    assert not wait(299, 0) and wait(2, 0)
    progress.look(1, now[0])
    assert not wait(59, 1) and wait(2, 1)
    progress.bar.close()


def test_frames_a_second_are_those_after_the_first():
    """Kernels that are compiled for it are told apart: the next film does not wait for them."""
    progress = demo.Progress(240)
    progress.look(0, 1000.0)
    progress.bar.start_t -= 90.0  # as if the bar had been there for so long
    progress.bar.last_print_t -= 90.0
    progress.look(0, 1050.0)
    assert progress.waited is None
    progress.look(1, 1090.0)
    progress.look(240, 1094.0)
    assert progress.waited == 90.0 and progress.bar.format_dict['elapsed'] < 45.0
    progress.bar.close()


def test_time_that_the_demo_was_stopped_is_nobodys_fault():
    """As where the machine slept: what it has not seen, it does not count."""
    progress = demo.Progress(10)
    progress.look(1, 0.0)
    progress.look(1, 3600.0)
    assert not progress.is_stalled
    progress.bar.close()


@pytest.mark.parametrize('stops', [True] + [False] * SOAK)
def test_a_whole_bag_is_a_success_with_pictures(tmp_path, stops):
    """However late the demo's own process is: what counts is how the nodes end, and the bag."""
    shot = tmp_path / 'shot.yaml'
    shot.write_text(yaml.safe_dump({
        '/**/wind': {'ros__parameters': {'frames': 80, 'speed': 9.0}},
        '/**/renderer': {'ros__parameters': {'width': 160, 'height': 120}}}))
    code = ('import sys; from pathlib import Path; from flag_sim.tools import demo; '
            'sys.exit(demo.film(Path(sys.argv[1]), 80, Path(sys.argv[2])))')
    with subprocess.Popen([sys.executable, '-c', code, shot, tmp_path], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        if stops:
            end = time.monotonic() + 400.0
            # 20 frames are more than a chunk, which the recorder then writes.
            while not any(file.stat().st_size > 1000 for file in tmp_path.glob('demo/*.mcap')):
                assert process.poll() is None and time.monotonic() < end
                time.sleep(0.001)
            process.send_signal(signal.SIGSTOP)
            time.sleep(3.0)
            process.send_signal(signal.SIGCONT)
        said, _ = process.communicate(timeout=400.0)
    assert process.returncode == 0, said
    assert re.search(r'\b80 frames at \d+ frames/s, the first after \d+ s. Made:', said)
    with Image.open(tmp_path / 'demo.gif') as animation:
        assert animation.n_frames == 40  # every second one
    assert (tmp_path / 'demo.png').is_file() and (tmp_path / 'demo.mp4').is_file()


def test_a_shot_that_fails_says_whose_log_tells_why(tmp_path):
    """Status 1, what that node said, and no pictures of the shot before."""
    (tmp_path / 'demo.png').write_text('of before')
    shot = tmp_path / 'shot.yaml'
    shot.write_text('/**/physics: {ros__parameters: {stiffness: -1.0}}')
    code = ('import sys; from pathlib import Path; from flag_sim.tools import demo; '
            'sys.exit(demo.film(Path(sys.argv[1]), 80, Path(sys.argv[2])))')
    done = subprocess.run([sys.executable, '-c', code, shot, tmp_path], text=True,
                          capture_output=True, timeout=400.0)
    assert done.returncode == 1
    assert '--- physics said:\nrefused: stiffness must be' in done.stderr
    assert 'did not reach its end' in done.stderr and not (tmp_path / 'demo.png').exists()


def test_all_processes_end_with_a_demo_that_is_told_to(tmp_path):
    """By SIGTERM, as CI and `timeout` tell it, as by Ctrl-C."""
    with subprocess.Popen(
            [sys.executable, '-m', 'flag_sim.tools.demo', '--shot', 'calm', '--out', tmp_path],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        end = time.monotonic() + 120.0
        while len(nodes := children_of(process.pid)) < 4:
            assert process.poll() is None and time.monotonic() < end
            time.sleep(0.05)
        process.terminate()
        said, _ = process.communicate(timeout=120.0)
    assert process.returncode == 128 + signal.SIGTERM and 'ended before the shot was' in said
    assert '240/240' not in said  # nor was it played on
    assert not any(map(is_there, nodes))
