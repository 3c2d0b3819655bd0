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

"""Waiting awake for another thread: to be woken takes longer than some kernels run."""
from flag_sim.jit.kernels import shared_kernel
from flag_sim.parallel.atomics import load, SPINS, yield_processor

LOOKS = 5000
"""Looks before waiting is given up, about a millisecond."""


@shared_kernel
def wait_while(cells, value):
    """Wait until cells[0], int64, is another than `value`; return whether it was so in time."""
    for look in range(LOOKS):
        if load(cells, 0) != value:
            return True
        if look > SPINS:
            yield_processor()
    return False
