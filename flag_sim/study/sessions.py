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

"""The sessions that a study took, and how busy others kept the machine in each."""
import contextlib

from flag_sim.study.machine import Watch

NAME = 'sessions'


@contextlib.contextmanager
def session(store):
    """Add a row on the time in which the block runs to a Store, also where it is interrupted."""
    watch = Watch()
    try:
        yield
    finally:
        others, seconds = watch.others(), watch.seconds()
        store.add(NAME, {'key': str(len(store.rows(NAME))), 'seconds': seconds, 'others': others})


def taken_by_others(store):
    """Return how many processors others kept busy, on average over all sessions; or None."""
    rows = [row for row in store.rows(NAME) if row['others'] is not None]
    total = sum(row['seconds'] for row in rows)
    return sum(row['seconds'] * row['others'] for row in rows) / total if total else None
