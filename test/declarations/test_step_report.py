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

"""What is reported of a cloth's steps: each change once."""
from flag_sim.cloth.stability import Plan
from flag_sim.declarations.step_report import is_softened, StepReport

VALUES = {'substeps': 10, 'stretch_limit': 0.1}
FINE = Plan(10, 10, 1.0, 1.0)


def told(report, plan, held=0, frames=1):
    """Return the levels and texts of some frames of half a second."""
    return [tuple(entry) for _ in range(frames)
            for entry in report.update(plan, held, VALUES, 0.5)]


def test_steps_that_are_refined():
    """At once, and after two seconds without."""
    report = StepReport()
    assert told(report, FINE, frames=9) == []
    refined = Plan(25, 25, 1.0, 1.0)
    assert told(report, refined, frames=3) == [
        ('warning', 'substeps = 10 is not stable: the frame needs 25 steps and gets 25')]
    assert told(report, FINE, frames=3) == []
    assert told(report, FINE) == [('info', 'the steps that substeps sets are enough again')]


def test_a_cloth_that_is_softened():
    """With what is left of it."""
    report, softened = StepReport(), Plan(40, 10, 0.0625, 0.25)
    assert is_softened(softened) and not is_softened(FINE)
    assert told(report, softened, frames=2) == [(
        'warning', 'the frame needs 40 steps and substeps_limit allows 10: stiffness is lowered '
        'to 0.0625 and damping to 0.25 of what is set; a greater substeps_limit avoids it')]
    assert told(report, FINE, frames=4) == [(
        'info', 'stiffness and damping are back at what is set: the frame needs 10 steps and '
        'gets 10')]


def test_nodes_that_are_held_back():
    """Once, although their number changes with every frame."""
    report = StepReport()
    assert told(report, FINE, held=7) == [(
        'warning', '7 nodes would stretch the cloth beyond stretch_limit = 0.1 and are held back')]
    assert told(report, FINE, held=9) == told(report, FINE) == told(report, FINE, held=2) == []
