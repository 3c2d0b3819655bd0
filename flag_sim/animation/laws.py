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

"""Laws of motion between two neighbouring keys: how a value goes from one to the next."""
import numpy as np


def step(_, before, after):
    """Hold the earlier key's value until the later key."""
    del after
    return before


def linear(fraction, before, after):
    """Go from one value to the next at constant speed; `fraction` of the way, in [0, 1)."""
    return before + (after - before) * fraction


LAWS = {'step': step, 'linear': linear}
"""Law by name, as glTF and OpenUSD name them; `law(fraction, before, after)` gives the value."""

HOLDS = (bool, np.bool_, str)
"""Types that have no states in between: only `step` can lead from one value to the next."""
