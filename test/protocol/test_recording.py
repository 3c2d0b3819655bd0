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

"""What a bag takes in: every message once, frame by frame and take by take."""
from flag_sim.protocol import recording as module
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.recording import Placement, Recording, REMEMBERED_FRAMES, TAKE_GAP
import pytest

FRAME = 10**9 // 25  # [ns]


def record(recording, topic, stamp):
    """Let a message arrive and be written; return what became of it and if its frame is whole."""
    placement = recording.place(topic, stamp)
    return placement, placement is Placement.WRITE and recording.written(topic, stamp)


def test_a_frame_is_complete_with_one_message_of_every_topic():
    """Those that not every frame has do not count, in whatever order they come."""
    recording = Recording(['image', 'vertices'])
    assert record(recording, 'vertices', 0) == (Placement.WRITE, False)
    assert record(recording, 'keyframe', 0) == (Placement.WRITE, False)
    assert recording.lacking() == (0, {'image'}) and recording.incomplete == 1
    assert record(recording, 'image', 0) == (Placement.WRITE, True)
    assert recording.lacking() is None
    assert (recording.complete, recording.incomplete) == (1, 0)


def test_copies_are_left_out_and_those_of_complete_frames_answered():
    """Also after the recording has all its frames; new ones are not begun then."""
    recording = Recording(['image', 'vertices'], 1)
    record(recording, 'image', 0)
    assert recording.place('image', 0) is Placement.IGNORE
    record(recording, 'vertices', 0)
    assert recording.has_all_frames
    assert recording.place('image', 0) is Placement.ANSWER
    assert recording.place('image', FRAME) is Placement.IGNORE
    assert recording.place('keyframe', FRAME) is Placement.IGNORE
    assert recording.copies == 2


def test_copies_of_frames_that_are_forgotten_are_left_out(monkeypatch):
    """They are older than all that are remembered; what never came is lost some day."""
    monkeypatch.setattr(module, 'REMEMBERED_FRAMES', 3)
    recording = Recording(['image', 'vertices'])
    for index in range(5):
        record(recording, 'image', index * FRAME)  # whose vertices do not come
    for index in range(5, 12):
        record(recording, 'image', index * FRAME)
        record(recording, 'vertices', index * FRAME)
    assert recording.place('image', 5 * FRAME) is Placement.IGNORE and recording.copies == 1
    assert recording.incomplete == 5


@pytest.mark.parametrize('begin, time', [(60 * 10**9, 60 * 10**9), (0, FRAME + TAKE_GAP)])
def test_takes_follow_one_another(begin, time):
    """At their own stamps if these are later, else behind the take before."""
    recording = Recording(['parameters'])
    for take, first in ((1, 0), (2, begin)):
        for index in range(2):
            frame = FrameId(first + index * FRAME, take, index, index)
            assert recording.follow(frame, b'data', 'wind') == [b'data']
            record(recording, 'parameters', frame.stamp)
    assert recording.takes == 2 and recording.complete == 4
    assert recording.time(begin) == time


def test_a_recording_is_full_with_a_whole_take():
    """A take that was reset does not count; one that goes on after another does."""
    recording = Recording(['parameters'], 4)

    def play(take, indices, sender='wind'):
        for index in indices:
            recording.follow(FrameId(index * FRAME, take, index, index), b'', sender)
            record(recording, 'parameters', index * FRAME)
    play(1, range(3))
    assert recording.outstanding == 1
    play(2, range(3))
    assert not recording.has_all_frames and recording.outstanding == 1 and recording.complete == 6
    play(3, range(1))
    play(2, range(3, 4), 'other')
    assert recording.has_all_frames and recording.takes == 4
    record(recording, 'parameters', 99 * FRAME)
    assert recording.in_take == 4


def test_few_takes_are_remembered():
    """However many resets there are."""
    recording = Recording(['parameters'], 4)
    for take in range(1, 100):
        recording.follow(FrameId(0, take, 0, 0), b'', 'wind')
        record(recording, 'parameters', 0)
    assert len(recording._in_takes) == module.REMEMBERED_TAKES


def test_a_late_copy_is_held_back_until_it_is_known_to_be_none():
    """One alone is a copy; two in a row begin another round, and both are recorded."""
    recording = Recording(['parameters'])
    for index in range(20):
        recording.follow(FrameId(index * FRAME, 1, index, index), b'%d' % index, 'player')
    again = [FrameId(index * FRAME, 1, index, index) for index in range(2)]
    assert recording.follow(again[0], b'first', 'player') == []
    assert recording.follow(FrameId(20 * FRAME, 1, 20, 20), b'20', 'player') == [b'20']
    assert (recording.takes, recording.copies) == (1, 1)
    assert recording.follow(again[0], b'first', 'player') == []
    assert recording.follow(again[1], b'second', 'player') == [b'first', b'second']
    assert (recording.takes, recording.copies) == (2, 1)


def test_invalid_stamps_are_refused():
    """Before 0, and beyond the largest time after all takes."""
    recording = Recording(['parameters'])
    with pytest.raises(ValueError, match='its stamp -1.0 s is before 0'):
        recording.place('parameters', -10**9)
    for take in range(1, 6):
        recording.follow(FrameId(0, take, 0, 0), b'', 'wind')
        stamps = [0, (2**31 - 1) * 10**9]
        if take < 5:
            for stamp in stamps:
                record(recording, 'parameters', stamp)
    with pytest.raises(ValueError, match='after 4 takes is later than a bag can hold'):
        recording.place('parameters', stamps[1])


def test_frames_of_strangers_are_forgotten_before_those_of_the_take():
    """A burst of them neither grows without bound nor has a frame recorded twice."""
    recording = Recording(['parameters', 'vertices'])
    recording.follow(FrameId(0, 1, 0, 0), b'', 'wind')
    assert recording.place('parameters', 0) is Placement.WRITE
    recording.written('parameters', 0)
    for stamp in range(10**15, 10**15 + 3 * REMEMBERED_FRAMES):
        assert recording.place('vertices', stamp) is Placement.WRITE
        recording.written('vertices', stamp)
    assert recording.incomplete == 3 * REMEMBERED_FRAMES + 1  # told, but not kept
    assert len(recording._missing) == REMEMBERED_FRAMES
    assert recording.place('parameters', 0) is Placement.IGNORE
    assert recording.place('vertices', 0) is Placement.WRITE
    assert recording.written('vertices', 0)
