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

"""Parameters of the player node."""
from dataclasses import replace

from flag_sim.declarations.pacing import PACE, RESEND_AFTER, WAIT_FOR
from flag_sim.parameters.declaration import Declaration

PLAYER = (
    Declaration('path', '', 'the bag that is played', fixed=True),
    Declaration('topics', [], 'topics to play; none: parameters, or else vertices', item=str,
                fixed=True),
    replace(PACE, fixed=True),
    Declaration('rate', 1.0, 'realtime: how much faster than it was', '', 0.01, 1000.0,
                fixed=True),
    replace(WAIT_FOR, fixed=True),
    replace(RESEND_AFTER, fixed=True),
)
