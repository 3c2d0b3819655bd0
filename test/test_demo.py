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
from flag_sim.nodes import demo, messages
from flag_sim.nodes.config import config_path
import pytest


@pytest.mark.parametrize('shot, said', [
    ('nix', "no shot 'nix' in config/; there are: calm, flight, gust, storm, sunrise, turn"),
    ('preview', 'preview.yaml is not a shot: it has no number of frames')])
def test_what_is_no_shot_is_refused_with_those_that_are(capsys, shot, said):
    """Presets and the profile of the network are in the same folder and none of them."""
    with pytest.raises(SystemExit):
        demo.main(['--shot', shot])
    assert said in capsys.readouterr().err


def test_every_shot_has_frames():
    """As many as its file says."""
    assert demo.frames_of(config_path('gust.yaml')) > 1


def test_kernels_have_time_to_compile_and_a_shot_that_stands_still_ends():
    """Five minutes to the first frame, and one from a frame to the next."""
    progress = demo.Progress(10)
    begin = progress.changed
    assert not progress.is_stalled(begin + 299.0) and progress.is_stalled(begin + 301.0)
    progress.on_frame_done(messages.header(0, 'recorder'))
    begin = progress.changed
    assert not progress.is_stalled(begin + 59.0) and progress.is_stalled(begin + 61.0)
    progress.bar.close()
