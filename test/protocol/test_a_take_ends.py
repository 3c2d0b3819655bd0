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

"""Whatever the network and its strangers do, a take ends: the nodes' protocol, without ROS."""
import itertools

from flag_sim.protocol.frames import FrameId
from hypothesis import settings, strategies as st
from hypothesis.stateful import initialize, rule, RuleBasedStateMachine
import pytest
from support.soak import SOAK
from support.take_models import FRAMES, NAMES, RESEND_AFTER, Stage, TICK

EVIL = st.floats(0.0, 0.6)
INDEX = st.integers(0, 3 * FRAMES)


class Trouble(RuleBasedStateMachine):
    """Anything may happen at any time in a shot; afterwards it ends."""

    @initialize(seed=st.integers(0, 2**16))
    def begin(self, seed):
        """Start the nodes."""
        self.stage = Stage(seed)
        self.is_plain = True  # nobody interferes, and there is but one take

    @rule(loss=EVIL, doubling=EVIL, longest=st.sampled_from([0.001, 0.3, 3.0]))
    def spoil(self, loss, doubling, longest):
        """Let the network lose, double and hold back messages."""
        network = self.stage.network
        network.loss, network.doubling, network.longest = loss, doubling, longest
        # Two late copies in a row are taken for another round of the take.
        self.is_plain &= longest < RESEND_AFTER and (doubling == 0.0 or longest < TICK)

    @rule(seconds=st.sampled_from([0.01, 0.3, 2.5]))
    def go_on(self, seconds):
        """Let time go by."""
        self.stage.run(seconds)

    @rule(name=st.sampled_from(NAMES))
    def kill(self, name):
        """Kill a node and start it again."""
        self.is_plain &= name in ('physics', 'renderer')
        self.stage.restart(name)

    @rule(times=st.integers(1, 5), seconds=st.sampled_from([0.0, 0.3]))
    def reset(self, times, seconds):
        """Ask for resets, in a row."""
        self.is_plain = False
        for _ in range(times):
            self.stage.wind.reset()
            self.stage.run(seconds)

    @rule(steps=st.integers(0, 20))
    def pause(self, steps):
        """Pause, and ask for many single steps at once."""
        self.stage.wind.is_paused = True
        for _ in range(steps):
            self.stage.wind.requests.steps += 1
            self.stage.wind.fill_window()

    @rule()
    def play(self):
        """Go on after a pause."""
        self.stage.heal()

    @rule(indices=st.lists(INDEX, min_size=1, max_size=80), shift=st.sampled_from([0, 1]))
    def foreign_vertices(self, indices, shift):
        """Vertices of a stranger, at the stamps of frames or beside them."""
        self.is_plain = False
        for index in indices:
            stamp = round(index * 1e9 / 30.0) + shift
            self.stage.network.publish('vertices', stamp, 'stranger')

    @rule(frames=st.lists(st.tuples(INDEX, INDEX), min_size=1, max_size=80),
          take=st.sampled_from([-1, 0, 1, None]), shift=st.sampled_from([0, 1]),
          is_bridged=st.booleans())
    def foreign_parameters(self, frames, take, shift, is_bridged):
        """Parameters of a stranger, or by the same bridge, of any take, index and stamp."""
        self.is_plain = False
        wind = self.stage.wind
        for index, back in frames:
            stamp = round(index * 1e9 / 30.0) + shift
            frame = (FrameId(stamp, None, stamp, stamp) if take is None else
                     FrameId(stamp, wind.number + take, index, max(index - back, 0)))
            self.stage.network.publish(
                'parameters', frame, wind.sender if is_bridged else 'stranger')

    @rule(index=INDEX, name=st.sampled_from(['renderer', 'recorder', 'stranger']))
    def foreign_answer(self, index, name):
        """Somebody says that a frame is done."""
        self.is_plain = False
        self.stage.network.publish('frame_done', (round(index * 1e9 / 30.0), name), 'stranger')

    def teardown(self):
        """See that the shot ends."""
        if hasattr(self, 'stage'):
            self.stage.assert_ends()
            recording = self.stage.recorder.recording
            assert not self.is_plain or (
                self.stage.wind.is_over and recording.in_take == recording.complete == FRAMES)
            # What is missing after the shot is told.
            assert recording.has_all_frames or recording.outstanding or not recording.complete


Trouble.TestCase.settings = settings(max_examples=1000 if SOAK else 60, stateful_step_count=15)
TestTrouble = Trouble.TestCase


@pytest.mark.parametrize('name', NAMES)
@pytest.mark.parametrize('when', [0.0, 0.02, 60.0])
def test_a_node_that_is_killed_and_started_again_holds_up_no_take(name, when):
    """Before, during and after the shot; with the wind the shot begins anew."""
    stage = Stage()
    stage.network.longest = 0.01
    stage.run(when)
    stage.restart(name)
    stage.assert_ends()
    is_whole = name != 'recorder' or when == 0.0
    assert stage.recorder.recording.has_all_frames == is_whole
    if not is_whole and when < 60.0:
        assert stage.recorder.recording.outstanding > 0  # which its log tells


@pytest.mark.parametrize('order', list(itertools.permutations(NAMES)), ids='-'.join)
def test_nodes_that_start_in_any_order_make_a_whole_take(order):
    """Each while those before it wait, or go on; none that is waited for misses a frame."""
    stage = Stage()
    stage.wind.is_over = True
    for name in order:
        stage.network.leave(name)
    for name in order:
        stage.restart(name)
        stage.run(1.3)
    stage.assert_ends()
    assert stage.recorder.recording.in_take == stage.recorder.recording.complete == FRAMES


def test_steps_of_a_paused_wind_respect_the_window():
    """They leave as frames are done, and none is forgotten."""
    stage = Stage()
    stage.wind.is_paused = True
    for _ in range(8):
        stage.wind.requests.steps += 1
        stage.wind.fill_window()
    stage.run(5.0)
    assert stage.wind.take.clock.index == 8 and not len(stage.wind.in_flight)


def test_resets_in_a_row_do_not_put_one_another_off():
    """Although a frame in flight is lost and nobody will answer it."""
    stage = Stage()
    stage.network.loss = 1.0
    stage.run(0.1)
    first = stage.wind.number
    for _ in range(10):
        stage.wind.reset()
        stage.run(0.3)
    assert stage.wind.number > first


def test_a_reset_in_mid_shot_gives_the_recorder_a_whole_take():
    """What it had of the take before does not count."""
    stage = Stage()
    stage.network.longest = 0.05
    stage.run(0.5)
    assert 0 < stage.recorder.recording.in_take < FRAMES
    stage.wind.reset()
    stage.assert_ends()
    assert stage.recorder.recording.in_take == FRAMES < stage.recorder.recording.complete


def test_vertices_of_the_future_hold_up_no_take():
    """More of them than the renderer keeps."""
    stage = Stage()
    for index in range(8):
        stage.network.publish('vertices', 10**12 + index, 'stranger')
    stage.assert_ends()
    assert stage.recorder.recording.in_take == FRAMES


def test_parameters_of_the_future_hold_up_no_take():
    """More of them than anybody keeps, by the wind's own name, as through a bridge."""
    stage = Stage()
    stage.network.longest = 0.05
    stage.run(0.2)
    for index in range(100, 200):
        stage.network.publish('parameters', FrameId(index * 10**8, stage.wind.number, index, 0),
                              stage.wind.sender)
    stage.assert_ends()


def test_a_frame_that_was_passed_over_for_a_stranger_is_served_in_the_end():
    """Its sender asks for it again and again, and sends nothing else."""
    stage = Stage()
    stage.network.longest = 0.05
    stage.run(0.2)
    index = stage.wind.in_flight.oldest.frame.index + 2
    stage.network.publish('parameters', FrameId(7, stage.wind.number, index, index),
                          stage.wind.sender)
    stage.assert_ends()


def test_frames_of_a_stranger_without_a_take_do_not_fill_the_recording():
    """Else it ends before the wind's last one, which would wait for ever."""
    stage = Stage()
    for stamp in (10**12, 0):
        stage.network.publish('parameters', FrameId(stamp, None, stamp, stamp), 'stranger')
    stage.assert_ends()
    assert stage.wind.is_over and stage.recorder.recording.in_take == FRAMES
