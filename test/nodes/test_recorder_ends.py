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

"""What ends a recording, and what it survives."""
import resource

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Vector3Stamped
from std_msgs.msg import Empty, Header
from support.forked import Graph
from support.shot import messages_of, SHOT, SMALL
from support.watch import eventually, Watcher


def test_a_recorder_overwrites_nothing(tmp_path, domain):
    """A path that exists is refused and stays as it was."""
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'bag' / 'precious').write_text('kept')
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}')
        assert graph.wait('recorder', 90.0) == 1
        assert 'exists already' in graph.log('recorder')
    assert [path.name for path in (tmp_path / 'bag').iterdir()] == ['precious']


def test_a_full_disk_ends_the_recording_with_a_clear_error(tmp_path, domain):
    """A file that may not grow stands for the full disk; status 1, and the reason is said."""
    limit = 3_000_000  # bytes; an image has 57,600
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('physics')
        graph.start('renderer', *SMALL)
        recorder = graph.start('recorder', '-p', f'path:={tmp_path / "bag"}')
        resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (limit, hard))
        graph.start('wind', *SHOT, '-p', 'wait_for:=[renderer]')
        assert graph.wait('recorder', 90.0) == 1, graph.log('recorder')
        assert 'cannot write' in graph.log('recorder')
        assert 'File too large' in graph.log('recorder')
        assert 'Traceback' not in graph.log('recorder')


def test_a_second_take_in_a_bag_is_told_once(tmp_path, domain):
    """A bag with two takes plays both; who reset the wind by mistake must know."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done, reset = watcher.listen('frame_done'), watcher.publisher('reset')
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}')
        graph.start('wind', *SHOT, '-p', 'wait_for:=[renderer, recorder]')
        watcher.parameters_of('wind', reset)  # now it hears each reset
        for takes in (0, 1, 2):
            del done[:]  # some of the take before may still come
            eventually(lambda: len(done) > 20 and graph.log('recorder').count(
                'another take begins') >= takes, watcher)
            assert graph.log('recorder').count('another take begins') == takes
            reset.publish(Empty())
        assert graph.end('recorder') == 0
        assert '3 takes' in graph.log('recorder')


def test_a_recorder_survives_an_invalid_stamp(tmp_path, domain):
    """A message typed with a time before 0 is told of and left out; the next one is recorded."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out, done = watcher.publisher('keyframe'), watcher.listen('frame_done')
        wind = watcher.publisher('wind')
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p',
                    'topics:=[keyframe, wind]')

        def send():
            out.publish(Header(stamp=Time(sec=-5)))
            wind.publish(Vector3Stamped(header=Header(stamp=Time(sec=1))))
        eventually(lambda: send() or 'its stamp -5.0 s is before 0' in graph.log('recorder')
                   and done, watcher)
        assert graph.end('recorder') == 0, graph.log('recorder')
    assert not messages_of(tmp_path / 'bag', '/keyframe')
    assert [time for time, _ in messages_of(tmp_path / 'bag', '/wind')] == [10**9]
