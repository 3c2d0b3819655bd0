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

"""Which parameters are asked for when, without a network."""
from flag_sim.viewer.requests import Requests


class Sent(list):
    """The requests that were sent, and the answers that were taken."""

    def __init__(self):
        self.answers = []
        self.requests = Requests(lambda *request: self.append(request))

    def answer(self, reason=''):
        """Answer the last request."""
        token, _, values, _ = self[-1]
        self.requests.answered(token, dict.fromkeys(values, reason))

    def take(self, reasons):
        """Take an answer."""
        self.answers.append(reasons)


def test_a_fast_hand_makes_no_queue():
    """While a node has not answered, of each parameter the latest value waits."""
    sent = Sent()
    for n in range(1000):
        sent.requests.put('/renderer', {'azimuth': n, f'other{n % 2}': n}, sent.take)
    assert [one[2] for one in sent] == [{'azimuth': 0, 'other0': 0}]
    sent.answer()
    assert sent[1:] == [(2, '/renderer', {'azimuth': 999, 'other0': 998, 'other1': 999}, False)]
    sent.answer('no')
    assert len(sent) == 2 and sent.answers[1]['azimuth'] == 'no'


def test_what_is_set_together_is_sent_whole_and_in_its_turn():
    sent = Sent()
    sent.requests.put('/wind', {'speed': 1.0}, sent.take)
    sent.requests.put_together('/wind', {'times': [0.0], 'values': [1.0]}, sent.take)
    sent.requests.put('/wind', {'speed': 2.0}, sent.take)
    sent.requests.put_together('/wind', {'times': None}, sent.take)
    while sent.requests.is_busy('/wind'):
        sent.answer()
    assert [one[2:] for one in sent] == [
        ({'speed': 1.0}, False), ({'times': [0.0], 'values': [1.0]}, True),
        ({'speed': 2.0}, False), ({'times': None}, True)]


def test_one_node_waits_for_no_other():
    sent = Sent()
    sent.requests.put('/wind', {'speed': 1.0}, sent.take)
    sent.requests.put('/physics', {'gravity': 1.0}, sent.take)
    assert [one[1] for one in sent] == ['/wind', '/physics']


def test_what_waits_for_a_node_that_is_gone_is_dropped():
    sent = Sent()
    sent.requests.put('/wind', {'speed': 1.0}, sent.take)
    sent.requests.put('/wind', {'speed': 2.0}, sent.take)
    sent.requests.forget('/wind')
    sent.answer('/wind did not answer')
    assert len(sent) == 1 and not sent.requests.is_busy('/wind')
    sent.requests.answered(99, {})  # an answer to nothing
    sent.requests.put('/wind', {'speed': 3.0}, sent.take)
    assert len(sent) == 2
