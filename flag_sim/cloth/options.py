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

"""What Cloth takes beside grid, material, air and stepping."""
from dataclasses import dataclass

from flag_sim.cloth.solvers import SOLVERS
from flag_sim.parameters.declared import Declared, declared


@dataclass(frozen=True)
class Options(Declared):
    """
    The arguments of Cloth that are single numbers or words; see there.

    Raises ValueError for a value out of its range.
    """

    gravity: float = declared(9.81, 'downward acceleration', 'm/s2', 0.0, 1000.0)
    solver: str = declared('symplectic', 'method of the steps', choices=tuple(SOLVERS))
    stretch_limit: float = declared(
        1.0, 'greatest strain from the hoist to any node; 1: the cloth may double its length',
        '', 0.0, 1e6)
    start_noise: float = declared(
        1e-4, 'the cloth starts flat but for a random bump of at most this; 0: exactly flat, and '
        'in calm air or a wind along it it stays so forever', 'm', 0.0, 0.1)
    start_seed: int = declared(0, 'another seed, another bump', '', 0, 2**31 - 1)
    threads: int = declared(
        1, 'threads that step; 0: as many as the first frames show to be worth it', '', 0, 64,
        fixed=True)
