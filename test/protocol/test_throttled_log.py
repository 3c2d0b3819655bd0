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

"""What is logged of reasons that come again and again, and of waiting."""
from flag_sim.protocol.throttled_log import MAX_REASONS, Refusals, Waiting, WARN_EVERY


def test_a_reason_is_logged_at_once_and_again_now_and_then():
    """Reasons that differ in numbers alone are one; a sender cannot fill the log with others."""
    refusals = Refusals()
    logged = [refusals.is_worth_logging(reason, now) for reason, now in (
        ('wind is 1.5', 0.0), ('wind is 2.5', 1.0), ('no field x', 1.0), ('wind is 3', 5.5))]
    assert logged == [True, False, True, True]
    others = [refusals.is_worth_logging('abcdefghijklmnop'[:n], 6.0) for n in range(1, 17)]
    assert sum(others) == MAX_REASONS - 1  # that of the wind counts still


def test_a_wait_is_logged_once_and_so_is_its_end():
    """With how long it has lasted."""
    waiting = Waiting(patience=2.0)
    logged = [waiting.look('vertices', 0, 0.5 * n) for n in range(8)]
    assert [n for n, entry in enumerate(logged) if entry] == [4]
    assert logged[4] == ('warning', 'waiting for 2.0 s for vertices')
    assert waiting.look('vertices', 1, 4.0) == ('info', 'frames are served again, after 4.0 s')
    assert waiting.look('vertices', 1, 5.9) is None
    assert waiting.look('vertices', 1, 6.0) == ('warning', 'waiting for 2.0 s for vertices')
    assert waiting.look('', 1, 7.0) == ('info', 'nothing is missing any more, after 3.0 s')
    assert waiting.look('', 1, 9.0) is None


def test_another_cause_of_a_wait_is_logged_too():
    """After as long a patience again; figures alone are no other cause."""
    waiting = Waiting(patience=2.0)
    reasons = 6 * ['image 1 of render'] + 6 * ['image 2 of render'] + 6 * ['image 2 of nobody']
    logged = [waiting.look(reason, 0, 0.5 * n) for n, reason in enumerate(reasons)]
    assert [n for n, entry in enumerate(logged) if entry] == [4, 12]
    assert logged[12] == ('warning', 'waiting for 6.0 s for image 2 of nobody')
    assert waiting.look('', 0, 9.0) == ('info', 'nothing is missing any more, after 9.0 s')


def test_served_frames_end_a_wait():
    """Although each lacks something for a moment; nothing is logged of a short wait either."""
    waiting = Waiting(patience=2.0)
    assert not any(waiting.look('vertices', n, 1.5 * n) for n in range(10))
    assert not waiting.look('vertices', 9, 15.0) and not waiting.look('', 9, 15.4)


def test_what_is_over_is_told_when_it_comes_again():
    """However long it went on before, and so had become rare in the log."""
    refusals, now = Refusals(), 0.0
    while now < 600.0:
        refusals.is_worth_logging('late', now)
        now += 1.0
    assert not refusals.is_worth_logging('late', now)
    refusals.end_silence()
    assert refusals.is_worth_logging('late', now + WARN_EVERY)
