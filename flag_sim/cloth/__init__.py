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
The cloth: a grid of masses and springs in the wind, stepped through time.

In a few lines:

>>> from flag_sim.cloth import Cloth
>>> cloth = Cloth()
>>> plan = cloth.advance(1 / 30, wind=(9.0, 3.0, 0.0))
>>> cloth.positions                     # (rows, columns, 3) [m]

The modules, in the order in which a frame and its steps pass them:

- simulation: Cloth, the frame from end to end; it calls all the others
- options, material, stepping: what users choose: the method, sheet and air, the number of steps
- mesh: the grid of nodes, how it lies in memory, and its bands for threads
- state, states, start: positions and velocities, those that a frame needs, where they begin
- resampling: the same motion on another grid
- model: the constants that follow from mesh and material
- stability: how many steps a frame needs, and how far the cloth is softened if it may not
- planned_solver: the solver of a frame, with its softened model
- solvers: the methods, one module each, which take the steps
- records: the arrays that kernels take, grouped and named
- pole_frame, turning: the frame of reference of a pole that moves, and what its turn does
- forces: all forces on the nodes; it calls the next four
- springs: tension and damping of the threads and diagonals
- bending: resistance to bending
- aerodynamics: the wind on the faces, spread over the nodes
- drag: the drag laws
- added_mass: the inertia of the air that moves with the cloth; off by default
- collision: the pole and stretch_limit within a step; it calls the next five
- pole, contact: the pole and the limits, as users give them and as kernels take them
- proximity: which nodes may be near the pole or too far out
- planes: a separating plane for each cell near the pole
- attachment: no node farther from the hoist than its reach
- constraints: the same limits at the end of a frame
- divergence: whether the frame has diverged, and which step would have been stable
- normals: unit normals at the nodes, for drawing
- energy, strain, pole_load: figures about a state, in plain numpy
- self_intersection: whether the cloth passes through itself
- plain: one step in plain numpy, to be read first
"""
from flag_sim.cloth.divergence import Diverged
from flag_sim.cloth.material import Air, Material
from flag_sim.cloth.simulation import Cloth
from flag_sim.cloth.stability import Plan
from flag_sim.cloth.stepping import Stepping

__all__ = ['Air', 'Cloth', 'Diverged', 'Material', 'Plan', 'Stepping']
