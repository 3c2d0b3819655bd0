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

"""A condition is told when it begins and when it is over."""
from flag_sim.protocol.hysteresis import Hysteresis


def told(frames, dt=0.5):
    """Return what is told of frames in which a condition holds (1) or does not (0)."""
    hysteresis = Hysteresis(2.0)
    words = {(False, False): '.', (True, False): 'B', (False, True): 'E'}
    return ''.join(words[hysteresis.update(holds == '1', dt)] for holds in frames)


def test_it_begins_at_once_and_is_over_after_two_seconds_without():
    """Each is told once, and again when it comes back."""
    assert told('0011100000000') == '..B.....E....'
    assert told('1000010000') == 'B...EB...E'


def test_what_comes_and_goes_is_told_once():
    """The time without it begins anew with every frame in which it holds."""
    assert told('010001001000110000') == '.B...............E'


def test_time_is_that_of_the_simulation():
    """Twice as long frames are half as many; one long frame is enough."""
    assert told('1000', dt=1.0) == 'B.E.'
    assert told('100', dt=5.0) == 'BE.'
