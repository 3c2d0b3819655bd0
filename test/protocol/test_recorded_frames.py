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

"""The messages of a bag as frames, with gaps, takes and copies, in whatever order they came."""
import struct

from flag_sim.protocol.cdr import serialized_stamp
from flag_sim.protocol.recorded_frames import LOOKAHEAD, recorded_frames
import pytest

FRAME = 10**9 // 30  # [ns]
EVERY_FRAME = ('parameters', 'vertices')


def message(stamp):
    """Return a serialised message that begins with a stamp [ns]."""
    return b'\x00\x01\x00\x00' + struct.pack('<iI', stamp // 10**9, stamp % 10**9)


def p(index):
    """Return a row of parameters."""
    return 'parameters', message(index * FRAME)


def v(index):
    """Return a row of vertices."""
    return 'vertices', message(index * FRAME)


@pytest.mark.parametrize('order, byte', [('<', 1), ('>', 0)])
def test_a_stamp_is_read_in_either_byte_order(order, byte):
    """Before 0, too; bytes that are too few are refused."""
    data = bytes([0, byte, 0, 0]) + struct.pack(f'{order}iI', -5, 7) + b'more'
    assert serialized_stamp(data) == -5 * 10**9 + 7
    with pytest.raises(ValueError, match='its 11 bytes are too few for a stamp'):
        serialized_stamp(data[:11])


def frames_of(rows):
    """Return [(index or None, names of its messages, names of those lost)] of recorded frames."""
    return [(None if frame.stamp is None else round(frame.stamp / FRAME),
             ''.join(name[0] for name, _ in frame.messages),
             ''.join(name[0] for name in sorted(frame.lost)))
            for frame in recorded_frames(((name, 0, data) for name, data in rows), EVERY_FRAME)]


@pytest.mark.parametrize('rows, expected', [
    # In the order of the wind, whatever the topics' order and distance.
    ([p(0), p(1), p(2), v(0), v(1), v(2)], [(0, 'pv', ''), (1, 'pv', ''), (2, 'pv', '')]),
    ([v(0), p(0), v(1), p(1)], [(0, 'vp', ''), (1, 'vp', '')]),
    # What was lost on the way into the bag is known once its topic has gone past it.
    ([p(0), p(1), v(1), p(2), v(2)], [(0, 'p', 'v'), (1, 'pv', ''), (2, 'pv', '')]),
    ([v(0), p(1), v(1)], [(0, 'v', 'p'), (1, 'pv', '')]),
    ([p(0), v(0), p(1)], [(0, 'pv', ''), (1, 'p', 'v')]),
    # Another take: its stamps are those of the first.
    ([p(0), v(0), p(1), p(0), v(1), v(0), p(1), v(1)],
     [(0, 'pv', ''), (1, 'pv', ''), (0, 'pv', ''), (1, 'pv', '')]),
    # A copy, sent again, does not pass for what is still to come.
    ([p(0), v(0), p(1), p(1), v(0), v(1), p(2), v(2)],
     [(0, 'pv', ''), (1, 'pv', ''), (1, 'p', 'v'), (0, 'v', 'p'), (2, 'pv', '')]),
])
def test_messages_are_frames_by_their_stamps(rows, expected):
    """Whenever they were received."""
    assert frames_of(rows) == expected


def test_a_topic_that_ends_is_not_waited_for_to_the_end_of_the_bag():
    """No more is held in memory than frames can be apart."""
    read = []

    def rows():
        yield ('vertices', 0, message(0))
        for index in range(200):
            read.append(index)
            yield ('parameters', 0, message(index * FRAME))
    frames = recorded_frames(rows(), EVERY_FRAME)
    assert next(frames).stamp == 0
    second = next(frames)
    assert second.lost == {'vertices'} and len(read) <= LOOKAHEAD + 2


def test_what_belongs_to_no_frame_goes_with_the_one_before_it():
    """A key is crossed between two frames."""
    key = 'keyframe', message(FRAME // 2)
    assert frames_of([p(0), key, v(0), p(1), v(1)]) == [
        (0, 'pkv', ''), (1, 'pv', '')]


def test_damage_is_told_after_all_that_was_read_before():
    """Nothing whole is lost by it."""
    def rows():
        yield ('parameters', 0, message(0))
        raise ValueError('damaged')
    frames = recorded_frames(rows(), EVERY_FRAME)
    assert next(frames).lost == {'vertices'}
    with pytest.raises(ValueError, match='damaged'):
        next(frames)
