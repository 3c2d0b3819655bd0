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

"""A study in which everything is small: for seconds where the real one takes minutes."""
from flag_sim.study import search
from flag_sim.study.measures import behaves, judge, reference, rests

SMALL = (
    (judge, 'FINEST', (17, 25)), (search, 'SHOTS', 2), (search, 'WINDOWS', 1),
    (search, 'FIRST', 1),
    (judge, 'SETTLE', 0.5), (judge, 'LENGTH', 2.0), (behaves, 'WITHIN', 100.0),
    (rests, 'STILLED', 0.3), (rests, 'FREE', 0.3),
    (rests, 'WATCHED', 0.1), (rests, 'SLOW', 1e5), (rests, 'DEEPER', 10.0),
    (reference, 'SPIN_UP', 0.2), (reference, 'SPACING', 0.1), (reference, 'LEAD', 1.0 / 30.0))
"""(module, name, value): grids up to 13 x 9, two windows soon after the start, short long runs."""
