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

"""Log entries for a user when a cloth's steps begin and cease to differ from what is set."""
from flag_sim.cloth.pole_frame import FASTEST_HOIST, FASTEST_SPIN
from flag_sim.cloth.stability import Plan
from flag_sim.protocol.hysteresis import Hysteresis
from flag_sim.protocol.throttled_log import Entry

CLEAR_AFTER = 2.0
"""How long softening or refining must be absent before it is reported over [simulated s]."""


def is_softened(plan: Plan) -> bool:
    """Return whether a frame's cloth was softer or less damped than it is set."""
    return min(plan.stiffness_factor, plan.damping_factor) < 1.0


class StepReport:
    """Compares every frame's plan with what is set, and reports what changes."""

    def __init__(self):
        self._refined = Hysteresis(CLEAR_AFTER)
        self._softened = Hysteresis(CLEAR_AFTER)
        self._held = Hysteresis(CLEAR_AFTER)
        self._carried = Hysteresis(CLEAR_AFTER)

    def update(self, plan: Plan, held: int, values: dict, dt: float,
               is_carried: bool = False) -> list[Entry]:
        """
        Return what there is to log of a frame of dt [s].

        plan: of its steps; held: how many nodes stretch_limit has held back; values: {name: value}
        of the physics node's parameters; is_carried: see Cloth.
        """
        entries = []
        asked = values['substeps']
        begins, ends = self._refined.update(0 < asked < plan.granted, dt)
        if begins:
            entries.append(Entry('warning', (
                f'substeps = {asked} is not stable: the frame needs {plan.demanded} steps and '
                f'gets {plan.granted}')))
        elif ends:
            entries.append(Entry('info', 'the steps that substeps sets are enough again'))
        begins, ends = self._softened.update(is_softened(plan), dt)
        if begins:
            entries.append(Entry('warning', (
                f'the frame needs {plan.demanded} steps and substeps_limit allows {plan.granted}: '
                f'stiffness is lowered to {plan.stiffness_factor:.3g} and damping to '
                f'{plan.damping_factor:.3g} of what is set; a greater substeps_limit avoids it')))
        elif ends:
            entries.append(Entry('info', (
                'stiffness and damping are back at what is set: the frame needs '
                f'{plan.demanded} steps and gets {plan.granted}')))
        begins, _ = self._held.update(held > 0, dt)
        if begins:
            entries.append(Entry('warning', (
                f'{held} nodes would stretch the cloth beyond stretch_limit = '
                f'{values["stretch_limit"]:g} and are held back')))
        begins, _ = self._carried.update(is_carried, dt)
        if begins:
            entries.append(Entry('warning', (
                f'the pole goes faster than the cloth can follow, {FASTEST_HOIST:g} m/s at the '
                f'hoist or {FASTEST_SPIN:g} rad/s: it is set down where the frame has it, and the '
                'cloth with it')))
        return entries
