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
What no node may do, whatever the forces: get too far from the hoist, or into the pole.

Methods see to the pole in every step, and then to both together (see collision); here both are
seen to between frames, also after a caller has placed the cloth or changed its limits.
"""
from flag_sim.cloth.attachment import attach
from flag_sim.cloth.collision import collide
from flag_sim.cloth.contact import Contact, Limits
from flag_sim.cloth.state import State
import numpy as np

SWEEPS = 20
"""Sweeps at most; a cloth that was put into the pole may need more, which the steps then do."""


def constrain(state: State, spare: State, limits: Limits, contact: Contact) -> None:
    """
    Bring back what is in the pole or too far from the hoist.

    spare: another state of the mesh, which is overwritten. limits, contact: of the mesh;
    contact.brought_back then has what was brought back here too.
    """
    band = state.mesh.band()
    if limits.pole[2] > 0.0:
        spare.data[3:] = state.data[3:]
        for _ in range(SWEEPS):
            spare.data[:3] = state.data[:3]
            collide(state.nodes, spare.nodes, limits, contact, band)
            if np.array_equal(spare.data[:3], state.data[:3]):
                break
            state.data[:3] = spare.data[:3]
        state.data[3:] = spare.data[3:]
    if state.mesh.pinned:
        attach(state.nodes, limits, contact.brought_back, band)
