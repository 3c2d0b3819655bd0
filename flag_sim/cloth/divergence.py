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

"""Whether a state has diverged, and which step would have been stable."""
from flag_sim.cloth.material import Air
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.state import State
from flag_sim.jit.kernels import kernel
from flag_sim.parameters import checks

MAX_DISTANCE = 1e9
"""Greatest coordinate [m]: beyond, float64 does not resolve a tenth of a micrometre."""
MAX_SPEED = 1e7
"""Greatest speed along an axis [m/s]: a free fall of eleven days."""


class Diverged(RuntimeError):
    """A frame diverged; the cloth is still as the frame before left it."""


def validate(state: State) -> None:
    """Raise Diverged if a position or a velocity of a state is not finite or beyond all bounds."""
    for values, limit, what in ((state.data[:3], MAX_DISTANCE, 'position'),
                                (state.data[3:], MAX_SPEED, 'velocity')):
        if not _within(values.reshape(-1), limit):
            raise Diverged(f'a {what} is not finite or beyond {limit:g}')


def stability_hint(name: str, step: float, safety: float, omega: float, gamma: float,
                   air: Air) -> str:
    """
    Return which step would have been stable, instead of one of step [s] with the solver so named.

    safety: the part of the largest stable step that is used. omega, gamma: bounds of frequencies
    and damping rates [1/s] (see stability). air: what the wind acts by.
    """
    def stable(solver):
        return safety * SOLVERS[solver].stable_step(omega, gamma, air)

    own = stable(name)
    if own == 0.0:
        return (f'no step is stable for {name}; symplectic is stable in steps of '
                f'{checks.rounded_down(stable("symplectic"))} s')
    if step > own * (1.0 + 1e-9):
        return f'{name} is stable in steps of {checks.rounded_down(own)} s'
    return (f'steps up to {checks.rounded_down(own)} s are stable: it is the state or a force '
            'that is too large')


@kernel
def _within(values, limit):
    """Return whether all values of a flat array are finite and at most limit in size."""
    outside = 0.0
    for i in range(values.size):
        # A NaN compares false, and so counts as outside.
        outside += 0.0 if abs(values[i]) <= limit else 1.0
    return outside == 0.0
