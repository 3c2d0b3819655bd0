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

"""Parameters of the nodes that send frames: how they are paced, and when one is done."""
from flag_sim.parameters.declaration import Declaration

PACE = Declaration(
    'pace', 'realtime', 'realtime: by the clock; lockstep: as fast as every frame is done',
    choices=('realtime', 'lockstep'))
WAIT_FOR = Declaration(
    'wait_for', ['renderer'],
    'nodes whose frame_done makes a frame done: renderer, recorder, your own', item=str)
RESEND_AFTER = Declaration(
    'resend_after', 1.0, 'lockstep: an unfinished frame is sent again after', 's', 0.05, 60.0)
