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

"""Frames that were missed: how many, and whose fault it was."""
from flag_sim.protocol.missed_frames import MissedFrames
import pytest


def test_what_is_missed_is_reported_once():
    """With the rate, who was late, and what helps."""
    missed = MissedFrames()
    missed.frames['sent'] += 10
    assert missed.report(30.0, '', ['renderer']) == ''
    missed.frames['sent'] += 8
    missed.frames['undone'] += 3
    assert missed.report(50.0, '', ['renderer', 'recorder']) == (
        '3 of the last 8 frames were missed at 50 Hz: 3 not done in time by renderer, recorder; '
        'a lower rate misses fewer, pace lockstep none')
    assert missed.report(50.0, '', ['renderer']) == ''
    assert missed.missed == 3


@pytest.mark.parametrize('computed, cause', [
    (0.9, 'not sent, the wind itself was too slow'),
    (0.1, 'not sent, the machine was busy with other processes')])
def test_a_wind_without_a_processor_is_not_to_blame(computed, cause):
    """It is known by the time that it has computed in."""
    missed = MissedFrames()
    missed.frames['sent'] += 6
    missed.skip(2, 1.0, computed)
    assert missed.report(10.0, '', ['renderer']) == (
        f'2 of the last 8 frames were missed at 10 Hz: 2 {cause}; a lower rate misses fewer, '
        'pace lockstep none')


def test_who_is_waited_for_is_named_instead_of_a_way_out():
    """A lower rate does not help against a node that does not answer."""
    missed = MissedFrames()
    missed.frames['undone'] += 1
    assert missed.report(10.0, 'renderer (gone)', ['renderer']).endswith(
        ': 1 not done in time by renderer (gone)')
    missed.skip(1, 1.0, 0.0)
    assert missed.report(10.0, 'renderer (gone)', ['renderer']).endswith(
        '; still waiting for renderer (gone)')


def test_the_state_tells_what_was_missed_lately():
    """Since it was asked last, however it was reported meanwhile."""
    missed = MissedFrames()
    missed.skip(2, 1.0, 1.0)
    missed.report(10.0, '', [])
    assert (missed.lately(), missed.lately()) == (2, 0)
