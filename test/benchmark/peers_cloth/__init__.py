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

"""
Other programs that move the same cloth, one module each, every one behind the same call.

A peer is a class: Peer(case) makes the cloth of a Case, at rest and laid flat; run(steps) takes
steps of case.dt; state() returns its positions and velocities, each (rows, columns, 3) [m], [m/s].
`precision` says what it computes in. Its constructor raises where the peer is not to be had.
Nothing of a peer is imported before its own process asks for it.
"""
