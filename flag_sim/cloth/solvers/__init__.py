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

"""The methods that carry the cloth from one moment to the next, one file each; see Solver."""
from flag_sim.cloth.solvers.euler import Euler
from flag_sim.cloth.solvers.implicit import Implicit
from flag_sim.cloth.solvers.rk4 import RK4
from flag_sim.cloth.solvers.seed import Seed
from flag_sim.cloth.solvers.symplectic import Symplectic
from flag_sim.cloth.solvers.verlet import Verlet
from flag_sim.cloth.solvers.xpbd import XPBD

SOLVERS = {
    'symplectic': Symplectic,
    'verlet': Verlet,
    'rk4': RK4,
    'xpbd': XPBD,
    'implicit': Implicit,
    'euler': Euler,
    'seed': Seed,
}
"""
Every method by the name that users choose it by, in the order in which they see them.

A new one is its file and its line here: the choices of the parameter `solver` and all that is
measured follow.
"""
