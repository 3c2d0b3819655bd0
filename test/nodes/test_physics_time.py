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

"""The physics node given time that stands still, jumps back, or has gaps."""
import itertools
import types

from flag_sim.nodes import physics
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
import numpy as np
import pytest
from support.bench import COUNT, FRAME, library, play, WIND
from support.frames import parameters_message


def test_time_that_stands_still_moves_nothing(bench):
    """The frame is answered with its stamp, and the cloth goes on from there."""
    before = play(bench, 6)
    assert np.array_equal(bench.frame(5 * FRAME), before)
    assert np.array_equal(play(bench, COUNT - 6, 6), library(COUNT))


def test_a_gap_longer_than_max_gap_is_not_simulated(bench, capfd):
    """It is said, and the cloth stands still over it."""
    before = play(bench, 6)
    assert np.array_equal(bench.frame(1e9), before)
    said = capfd.readouterr().err
    assert 'more than max_gap = 1 s: it is not simulated; a greater max_gap' in said
    assert not np.array_equal(bench.frame(1e9 + FRAME), before)


def test_gaps_that_follow_one_another_are_told_once(bench, capfd):
    """Once in WARN_EVERY; a rate below 1 / max_gap would fill the log."""
    for n in range(10):
        bench.frame(2.0 * n)
    assert capfd.readouterr().err.count('more than max_gap') == 1


def test_a_gap_made_by_the_node_itself_is_not_blamed_on_others(bench, capfd, monkeypatch):
    """The node says what it was busy with; a gap that it did not make is not explained by it."""
    play(bench, 6)
    now = itertools.count(1000.0, 0.3)  # at the begin of a frame, and at its end
    monkeypatch.setattr(physics, 'time', types.SimpleNamespace(monotonic=lambda: next(now)))
    assert bench.put(max_gap=0.2).successful
    bench.frame(6 * FRAME)
    bench.frame(6 * FRAME + 0.4)
    said = capfd.readouterr().err
    assert '0.400 s between two frames is more than max_gap = 0.2 s: ' in said
    assert 'physics itself was busy for 0.3 s with the frame before' in said
    bench.frame(6 * FRAME + 5.0)
    said = capfd.readouterr().err
    assert 'more than max_gap' in said and 'busy' not in said


def test_a_take_that_is_joined_in_the_middle_is_told(bench, capfd):
    """As after a restart of the node; its film has a cloth at rest there. Once, not of frame 0."""
    play(bench, 2)
    assert 'joined' not in capfd.readouterr().err
    for index in (7, 8):
        bench.hear(parameters_message(
            '/wind', FrameId(round(index * FRAME * 1e9), 2, index, index), WIND, {}))
    assert capfd.readouterr().err.count(
        'joined the take at frame 7: the cloth begins at rest there; reset for a whole take') == 1


def test_the_longest_gap_that_can_be_allowed_is_simulated(bench):
    """An hour in one frame: softened, and in its bounds."""
    assert bench.put(max_gap=3600.0).successful
    play(bench, 6)
    assert np.isfinite(bench.frame(5 * FRAME + 3600.0)).all()


@pytest.mark.parametrize('take', [1, 2, None])
def test_time_that_jumps_back_lays_the_cloth_out_again(bench, take):
    """In the same take, in a new one, and typed by hand."""
    play(bench, COUNT)
    if take is None:
        for at in (10.0, 4.0):
            message = parameters_message('/hand', FrameId(0, 0, 0, 0), WIND, {})
            message.stamp = messages.to_time(round(at * 1e9))
            del message.changed_parameters[1:4]
            cloud = bench.hear(message)
    else:
        index = COUNT if take == 1 else 0
        cloud = bench.hear(parameters_message(
            '/wind', FrameId(100, take, index, index), WIND, {}))
    assert np.array_equal(messages.read_cloud(cloud)[0], library(1))
