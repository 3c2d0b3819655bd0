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

"""Threads that wait for one another are parted, where there is a processor for each."""
import os

from flag_sim.parallel import placement
import pytest

ALLOWED = os.sched_getaffinity(0)


@pytest.mark.skipif(len(ALLOWED) < 2, reason='there is one processor alone')
def test_a_thread_leaves_the_processor_of_its_caller(monkeypatch):
    """At once; and may run there again later."""
    monkeypatch.setattr(placement, 'is_one_free', lambda: True)
    for caller in ALLOWED:
        try:
            os.sched_setaffinity(0, {caller})
            assert placement.processor() == caller
            placement.part_from(caller)  # there is no other
            assert placement.processor() == caller and os.sched_getaffinity(0) == {caller}
            asked = []
            with monkeypatch.context() as patch:
                patch.setattr(os, 'sched_getaffinity', lambda _: ALLOWED)
                patch.setattr(os, 'sched_setaffinity', lambda _, to: asked.append(set(to)))
                assert placement.apart(lambda a, b: a - b, 5, 3, caller=caller) == 2
            assert asked == [ALLOWED - {caller}, ALLOWED]
            os.sched_setaffinity(0, ALLOWED - {caller})
            assert placement.processor() != caller
        finally:
            os.sched_setaffinity(0, ALLOWED)


def test_a_thread_stays_where_all_processors_are_busy(monkeypatch):
    """There it would wait for its caller longer than for its turn."""
    monkeypatch.setattr(placement, 'is_one_free', lambda: False)
    monkeypatch.setattr(placement, 'processor', lambda: min(ALLOWED))
    monkeypatch.setattr(os, 'sched_setaffinity', lambda *_: pytest.fail('was moved'))
    placement.part_from(min(ALLOWED))


@pytest.mark.parametrize('text, free', [
    ('0.1 0.1 0.1 {}/272 6929', True), ('0.1 0.1 0.1 {}000/90000 6929', False), ('', False)])
def test_what_the_system_says_of_its_processors(text, free, tmp_path, monkeypatch):
    """One that says nothing has none to give."""
    load = tmp_path / 'loadavg'
    load.write_text(text.format(os.cpu_count()))
    monkeypatch.setattr(placement, '_LOAD', load)
    assert placement.is_one_free() is free


def test_what_a_system_without_proc_says(tmp_path, monkeypatch):
    """Nothing."""
    monkeypatch.setattr(placement, '_LOAD', tmp_path / 'none')
    assert not placement.is_one_free()
