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

"""What the recorder and the player do with takes, bytes, disks and bags as they should not be."""
import itertools
import resource
import shutil

from flag_sim.nodes.recorder import counted
from flag_sim.protocol.cdr import serialized_stamp
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.recording import TAKE_GAP
from flag_sim.ros import messages
from flag_sim.ros.bag import Bag
import numpy as np
import pytest
from rcl_interfaces.msg import ParameterEvent
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header
from support.bags import FRAME, images_bag, recorded
from support.forked import Graph
from support.frames import parameters_message
from support.nodes import made
from support.watch import eventually, Watcher

ZSTD_MAGIC = b'\x28\xb5\x2f\xfd'  # RFC 8878, 3.1.1


def frame(take, index):
    """Return the parameters of a frame in real time."""
    return parameters_message(
        'wind', FrameId(index * FRAME, take, index, index), [1.0, 0.0, 0.0], {})


def parameters_bag(path, take=1, frames=3):
    """Make a bag that holds one take's parameters; return its path."""
    bag = Bag(path, 'mcap', 'none')
    bag.add_topic('/parameters', ParameterEvent)
    for index in range(frames):
        bag.write('/parameters', index * FRAME, serialize_message(frame(take, index)))
    bag.close()
    return path


def test_an_older_take_of_another_sender_is_recorded(tmp_path, domain):
    """A take is played back after a newer one of the wind, and once more by another player."""
    old = parameters_bag(tmp_path / 'old', take=1)
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out, done = watcher.publisher('parameters'), watcher.listen('frame_done')
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p', 'topics:=[parameters]')
        # Once: a copy that came late, between frames of the players, would be another take.
        send_once(out, done, watcher, [frame(2, 0)])
        for name in ('first', 'second'):
            graph.start('player', '-p', f'path:={old}', '-p', 'pace:=lockstep',
                        '-p', 'wait_for:=[recorder]', name=name)
            eventually(lambda: graph.processes[name].poll() == 0, watcher)
        assert graph.end('recorder') == 0
        assert graph.log('recorder').count('another take begins') == 2
        assert '7 frames' in graph.log('recorder') and '3 takes' in graph.log('recorder')
    stamps = [serialized_stamp(data)
              for _, _, data in recorded(tmp_path / 'bag', 'parameters')]
    assert stamps == [0, *2 * [0, FRAME, 2 * FRAME]]


def test_a_topic_named_twice_is_refused(tmp_path, domain):
    """Before anything is made: no folder is left that stands in the next one's way."""
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p',
                    'topics:=[vertices, vertices]')
        assert graph.wait('recorder', 90.0) == 1
        assert "topics: each is named once, but 'vertices' more often" in graph.log('recorder')
        assert 'Traceback' not in graph.log('recorder')
    assert not (tmp_path / 'bag').exists()


def test_malformed_bytes_are_left_out(tmp_path, domain):
    """A message that is none is told of; the next one is recorded."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out, done = watcher.publisher('parameters'), watcher.listen('frame_done')
        keyframe = watcher.publisher('keyframe')
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p',
                    'topics:=[parameters, keyframe]')

        def send():
            out.publish(b'\x00\x01\x00\x00' + b'\xff' * 40)
            keyframe.publish(b'\x00\x01\x00\x00')
        eventually(lambda: send() or all(
            reason in graph.log('recorder') for reason in (
                'a message on parameters is not recorded: its 44 bytes are no ParameterEvent',
                'a message on keyframe is not recorded: its 4 bytes are too few')), watcher)
        eventually(lambda: out.publish(frame(1, 0)) or done, watcher)
        assert graph.end('recorder') == 0, graph.log('recorder')
    assert len(recorded(tmp_path / 'bag', 'parameters')) == 1
    assert not recorded(tmp_path / 'bag', 'keyframe')


def send_once(out, done, watcher, frames, is_left_out=bool):
    """Publish messages once each; is_left_out(): whether one was that will not be answered."""
    watcher.parameters_of('recorder', out)  # now it hears each of them
    for message in frames:
        del done[:]
        out.publish(message)
        eventually(lambda: any(one.stamp == message.stamp for one in done) or is_left_out(),
                   watcher)


def test_takes_beyond_the_latest_time_of_a_bag_are_left_out(tmp_path, domain):
    """Each begins where the last one ended: the fifth of 68 years each is beyond 2**63 ns."""
    frames = [frame(take, index) for take in range(1, 7) for index in range(2)]
    for message in frames[1::2]:
        message.stamp.sec = 2**31 - 1
    frames[-1].stamp.sec = 1  # after the fifth the sixth is recorded
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out, done = watcher.publisher('parameters'), watcher.listen('frame_done')
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p', 'topics:=[parameters]',
                    '-p', 'storage:=sqlite3')
        send_once(out, done, watcher, frames,
                  lambda: 'than a bag can hold' in graph.log('recorder'))
        last = frames[-1].stamp
        eventually(lambda: any(one.stamp == last for one in done), watcher)
        assert graph.end('recorder') == 0, graph.log('recorder')
        assert 'than a bag can hold' in graph.log('recorder')
    assert len(recorded(tmp_path / 'bag', 'parameters')) == len(frames) - 1


def test_takes_follow_one_another_wherever_their_stamps_begin(tmp_path, domain):
    """By the wall clock a take has its own place in the bag; else it follows the one before."""
    begins = [1_796_000_000, 1_796_000_060, 1_796_000_060, 0]  # [s]
    frames = [frame(take, index) for take in range(1, 5) for index in range(2)]
    for n, message in enumerate(frames):
        message.stamp.sec += begins[n // 2]
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out, done = watcher.publisher('parameters'), watcher.listen('frame_done')
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p', 'topics:=[parameters]')
        send_once(out, done, watcher, frames)
        assert graph.end('recorder') == 0, graph.log('recorder')
    second = (begins[1] - begins[0]) * 10**9
    third = second + FRAME + TAKE_GAP
    fourth = third + FRAME + TAKE_GAP
    assert [at - begins[0] * 10**9 for _, at, _ in recorded(tmp_path / 'bag', 'parameters')] == [
        0, FRAME, second, second + FRAME, third, third + FRAME, fourth, fourth + FRAME]


def test_a_late_picture_of_the_take_before_is_not_taken_for_one_of_the_next(tmp_path, domain):
    """A frame was sent again and answered twice, a reset came between the answers: same stamp."""
    topics = 'topics:=[parameters, camera/camera_info]'
    with made('recorder', domain, tmp_path, topics) as recorder:
        hears = {one.topic_name: one.callback for one in recorder.subscriptions}

        def hear(topic, message, sender):
            hears[topic](serialize_message(message), {'publisher_gid': {'data': [sender]}})

        def picture(index, take):
            stamp = messages.to_time(index * FRAME)
            hear('/camera/camera_info', CameraInfo(header=Header(stamp=stamp), width=take), 2)
        for take in 1, 2:
            for index in range(3):
                if (take, index) == (2, 1):
                    picture(1, 2)  # which the renderer makes before we hear of its parameters
                hear('/parameters', frame(take, index), 1)
                if (take, index) == (2, 0):
                    picture(1, 1)
                    picture(2, 1)
                if (take, index) != (2, 1):
                    picture(index, take)
    bag = recorded(tmp_path / 'bag', 'camera/camera_info')
    assert [deserialize_message(data, CameraInfo).width for *_, data in bag] == [1] * 3 + [2] * 3


def test_a_full_disk_ends_sqlite_with_a_clear_error(tmp_path, domain):
    """As it does mcap (test_recorder_ends); what was answered as done is kept, and so it says."""
    limit = 3_000_000  # bytes; an image has 1,000,000 and sqlite keeps 2 MB in memory
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out = watcher.publisher('camera/image_raw')
        recorder = graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p',
                               'topics:=[camera/image_raw]', '-p', 'storage:=sqlite3')
        resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (limit, hard))
        stamps = itertools.count(0, FRAME)
        pixels = np.zeros((500, 2000 // 3, 3), np.uint8)
        eventually(lambda: out.publish(messages.image_message(next(stamps), pixels))
                   or recorder.poll() is not None, watcher)
        said = graph.log('recorder')
        assert recorder.poll() == 1, said
        assert 'cannot write' in said and 'what was said to be done is kept' in said
        assert 'Traceback' not in said and 'MB' not in said
    assert recorded(tmp_path / 'bag', 'camera/image_raw')


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_missing_folder_is_an_error(tmp_path, domain, storage):
    """What was recorded went with it: the status is 1, and nobody reads of frames in a bag."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out, done = watcher.publisher('parameters'), watcher.listen('frame_done')
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p', 'topics:=[parameters]',
                    '-p', f'storage:={storage}')
        eventually(lambda: out.publish(frame(1, 0)) or done, watcher)
        shutil.rmtree(tmp_path / 'bag')
        assert graph.wait('recorder', 90.0) == 1  # at once, although nothing comes
        said = graph.log('recorder')
        assert 'cannot write' in said and 'cannot finish' in said and 'the folder is gone' in said
        assert 'MB' not in said and 'reindex' not in said and 'Traceback' not in said
    assert not (tmp_path / 'bag').exists()


def test_the_summary_tells_what_is_on_the_disk(tmp_path, domain):
    """Compressed, a black image of 3 MB takes a few kB; one frame is no plural."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out, done = watcher.publisher('camera/image_raw'), watcher.listen('frame_done')
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p',
                    'topics:=[camera/image_raw]', '-p', 'compression:=zstd')
        black = messages.image_message(0, np.zeros((1000, 1000, 3), np.uint8))
        eventually(lambda: out.publish(black) or done, watcher)
        assert graph.end('recorder') == 0
        assert ' 1 frame, 0.0 MB on disk, 0 incomplete frames, ' in graph.log('recorder')


@pytest.mark.parametrize(('number', 'words'), [(0, '0 copies'), (1, '1 copy'), (2, '2 copies')])
def test_things_are_counted_in_words(number, words):
    """As people do."""
    assert counted(number, 'copy', 'copies') == words


def play(graph, path, *arguments):
    """Play a bag; return the exit status and what the player said."""
    graph.start('player', '-p', f'path:={path}', *arguments)
    status = graph.wait('player', 90.0)
    return status, graph.log('player')


@pytest.mark.parametrize(('whole', 'said'), [
    (0, 'nothing after 0 messages'), (2, 'nothing after 2 messages')])
def test_a_damaged_chunk_ends_the_playing(tmp_path, domain, whole, said):
    """What lies before it is played; the path, the reason and status 1 tell of the rest."""
    file = images_bag(tmp_path / 'bag', 4)
    frames = file.read_bytes().split(ZSTD_MAGIC)
    assert len(frames) == 5
    file.write_bytes(b''.join(
        part + (b'' if n == 4 else bytes(4) if n == whole else ZSTD_MAGIC)
        for n, part in enumerate(frames)))
    with Graph(tmp_path / 'log', domain) as graph:
        status, log = play(graph, tmp_path / 'bag', '-p', 'topics:=[camera/image_raw]')
    assert status == 1 and 'Traceback' not in log
    assert f'path {tmp_path / "bag"}: cannot be read' in log and said in log


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_what_was_done_outlives_a_killed_recorder(tmp_path, domain, storage):
    """Every answer is true: the player finds the frame, without any other tool."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out, done = watcher.publisher('parameters'), watcher.listen('frame_done')
        recorder = graph.start('recorder', '-p', f'path:={tmp_path / "bag"}',
                               '-p', 'topics:=[parameters]', '-p', f'storage:={storage}')
        indices = itertools.count()
        eventually(lambda: out.publish(frame(1, next(indices))) or len(done) > 5, watcher)
        recorder.kill()
        recorder.wait()
        for _ in range(5):  # answers that were on their way
            watcher.spin(0.1)
        answered = {messages.to_stamp(header.stamp) for header in done}
        kept = {serialized_stamp(data) for _, _, data in recorded(tmp_path / 'bag', 'parameters')}
        assert len(answered) > 5 and answered <= kept
        status, log = play(graph, tmp_path / 'bag', '-p', 'rate:=1000.0')
    assert status == 0 and 'is not finished: what is whole of it is played' in log


def test_lockstep_plays_on_after_bytes_without_a_stamp(tmp_path, domain):
    """A reset has none, and a recorder of somebody else's may have kept malformed bytes."""
    bag = Bag(tmp_path / 'bag', 'mcap', 'none')
    bag.add_topic('/parameters', ParameterEvent)
    bag.write('/parameters', 0, b'\x00\x01\x00\x00')
    bag.close()
    with Graph(tmp_path / 'log', domain) as graph:
        status, log = play(graph, tmp_path / 'bag', '-p', 'pace:=lockstep')
    assert status == 0, log
    assert 'a message on parameters belongs to no frame: its 4 bytes are too few' in log
