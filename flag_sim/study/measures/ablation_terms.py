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

"""The terms of the model and of the light, and what it is to switch each of them off."""
from collections.abc import Callable
import dataclasses
from typing import NamedTuple

from flag_sim.cloth import Cloth
from flag_sim.cloth.aerodynamics import add_wind_forces, set_face_forces
from flag_sim.cloth.planned_solver import PlannedSolver
from flag_sim.cloth.records import Nodes
from flag_sim.cloth.solvers.symplectic import Symplectic
from flag_sim.declarations.factories import hang_of
from flag_sim.study.measures.reference import on_grid
from flag_sim.study.measures.settings import changed, defaults, Settings


class TrueWind(Symplectic):
    """
    Symplectic steps (eqs. 1.7 to 1.11) in the true wind: on the faces as if they stood still.

    Only the ablation asks for it: no parameter does. The apparent wind of all other solvers is the
    true wind less the cloth's own velocity. The wind's force depends on the positions alone here,
    like that of a spring. So it is taken as it is at a step's start, without the drag's implicit
    part, and added to a step in still air.
    """

    def advance(self, state, spare, forcing, dt, count, pool=None):
        """Take count steps of dt [s] from state; return the one of the two with the result."""
        still_air = forcing._replace(air=dataclasses.replace(forcing.air, density=0.0))
        number, inverse_mass = self.model.mesh.number, self.model.sheet.inverse_mass
        kept = number(dt / (1.0 + dt * self.model.material.node_damping))
        for _ in range(count):
            wind_force = self.wind_force(state, forcing)
            state, spare = super().advance(state, spare, still_air, dt, 1), state
            for x, v, f in zip(*state.nodes, wind_force):
                gained = kept * f * inverse_mass
                v += gained
                x += number(dt) * gained
        return state

    def wind_force(self, state, forcing):
        """Return the wind's force (eqs. 1.3, 1.4) on every node at rest: a Field [N]."""
        mesh, faces = self.model.mesh, self._work.faces
        wind = self.model.coefficients(forcing, self.drag_order).wind
        force, standstill = tuple(mesh.fields(3)), tuple(mesh.fields(3))
        set_face_forces(Nodes(state.nodes.position, standstill), wind, mesh.number(0.0),
                        self.model.sheet.weights, faces, mesh.band())
        add_wind_forces(faces, force, mesh.band())
        return force


def in_true_wind(cloth: Cloth) -> Cloth:
    """Let a cloth step by TrueWind from now on, until its solver or material is changed."""
    cloth._planned = PlannedSolver(cloth.mesh, cloth.material, TrueWind)
    return cloth


class Term(NamedTuple):
    """
    A term: the parameters {name: value} that it has when it is on, and those that switch it off.

    A value may be a function of the other settings. shots: names of SHOTS that it may matter in.
    why: it is on, or off, by default. offset: first displacement [m] of the run without the term,
    for the control. replace: makes a Cloth one without the term, where no parameter does; the time
    that it takes tells nothing.
    """

    name: str
    on: dict
    off: dict
    shots: tuple
    why: str
    offset: float = 0.0
    replace: Callable = None


SHOTS = {
    'fresh': {},
    'calm': {'speed': 2.0, 'gust.intensity': 0.3},
    'storm': {'speed': 18.0, 'gust.intensity': 0.25, 'gust.length': 8.0},
    'behind': {'speed': 8.0, 'azimuth': 3.0, 'camera.target': [0.0, 0.0, 7.85],
               'camera.distance': 7.0},
    'whole pole': {'camera.target': [0.5, 0.0, 4.7], 'camera.distance': 18.0},
    'close-up': {'camera.target': [1.1, 0.0, 8.2], 'camera.distance': 1.5},
    'against the sun': {'sun.azimuth': 1.2, 'sun.elevation': 0.4},
}
"""Changes to the default settings: other winds, other views and another sun."""

WINDS = ('fresh', 'calm')


def seed_speed(settings: Settings) -> float:
    """
    Return the wind [m/s] in which the seed's law presses as hard as the quadratic one.

    On a face at rest and square to the wind: n (n . w), newtons for metres per second, against
    rho C_d / 2 A w^2. At other angles the two still differ, and in a wind that changes.
    """
    _, length, width = hang_of(settings)
    area = 0.5 * (length / (settings['grid.columns'] - 1)) * (width / (settings['grid.rows'] - 1))
    drag = 0.5 * settings['air.density'] * settings['air.drag_coefficient']
    return drag * area * settings['speed']**2


def linear_density(settings: Settings) -> float:
    """
    Return the density [kg/m3] with which the linear law presses as hard as the quadratic one.

    On a face at rest and square to the shot's mean wind: rho' times 1 m/s times w is rho w^2.
    """
    return settings['air.density'] * settings['speed']


def finer() -> Settings:
    """Return the parameters of the same sheet on a grid twice as fine."""
    coarse = defaults()
    fine = on_grid(coarse, *(2 * coarse[name] - 1 for name in ('grid.rows', 'grid.columns')))
    return {name: value for name, value in fine.items() if value != coarse[name]}


CONTROL = 'nothing'  # the name of the control: what is left where only the last digits differ

TERMS = (
    Term(CONTROL, {}, {}, WINDS, 'the control: its second run begins a nanometre aside',
         offset=1e-9),
    Term('gravity', {}, {'gravity': 0.0}, WINDS,
         'on: without it the flag does not hang'),
    Term('wind', {}, {'air.density': 0.0}, WINDS,
         'on: without it the flag hangs still'),
    Term('wind relative to the cloth', {}, {}, ('fresh',),
         'on: the air brakes the cloth, which else moves too much', replace=in_true_wind),
    Term('square of the wind, else linear', {},
         {'air.law': 'linear', 'air.density': linear_density}, ('fresh', 'storm'),
         'on: costs the same; matched in one wind, the linear law is wrong in every other'),
    Term("wind law, else the course project's", {}, {'air.law': 'seed', 'speed': seed_speed},
         ('fresh',), 'on: the other knows neither the size of a face nor its velocity'),
    Term('inertia of the air', {'air.added_mass': 0.53}, {}, ('fresh',),
         'off: drag and waves come nearer to real ones, the swing goes farther from them'),
    Term('shear', {}, {'shear_stiffness': 0.0}, WINDS,
         'on: without it the sheet folds up along its diagonals'),
    Term('bending', {}, {'bend_stiffness': 0.0}, WINDS,
         'on: else the finest wave of the grid decides on the folds'),
    Term('damping', {}, {'damping': 0.0}, WINDS,
         'on: stills the finest stretch waves, which nothing else does'),
    Term('node damping', {'node_damping': 0.5}, {}, WINDS,
         'off: the air slows the cloth already'),
    Term('gusts', {'gust.intensity': 0.25}, {}, ('fresh',),
         'off: a matter of the weather, not of accuracy'),
    Term('pole collision', {}, {'pole_collision': False}, ('fresh', 'behind'),
         'on: a flag that hangs, or whose wind turns, would go through its pole'),
    Term('sun', {}, {'sun.intensity': 0.0}, ('fresh',),
         'on: shows the folds'),
    Term('ambient', {}, {'ambient': 0.0}, ('fresh',),
         'on: else the side away from the sun is black'),
    Term('Gouraud', {}, {'shading': 'flat'}, ('fresh',),
         'on: else the triangles show'),
    Term('specular', {'flag.specular': 0.3}, {}, ('fresh',),
         'off: flag cloth is dull'),
    Term('transmission', {}, {'flag.transmission': 0.0}, ('fresh', 'against the sun'),
         'on: else the flag is one dark area against the sun'),
    Term('pole', {}, {'pole.visible': False}, ('fresh', 'whole pole'),
         'on: the flag hangs from it'),
    Term('platform', {}, {'platform.visible': False}, ('fresh', 'whole pole'),
         'on: costs nothing where the camera does not see it'),
    Term('perspective-correct light', {'interpolation': 'perspective'}, {}, ('fresh', 'close-up'),
         'off: below what an eye sees on the default grid'),
    Term('4 samples', {'samples': 4}, {}, ('fresh',),
         'off: smooths edges, for about three times the time of drawing'),
    Term('Z-buffer', {}, {'hidden_surface': 'painter'}, WINDS,
         'on: right where triangles cross, too'),
    Term('finer grid', finer(), {}, ('fresh',),
         'off: costs more time than all else'),
)
"""In the order in which they are measured."""


def settings_of(term: Term, scene: Settings) -> tuple[Settings, Settings]:
    """Return the settings with a term and without it in a scene {parameter: value}."""
    base = changed(defaults(), scene)
    return tuple(changed(base, {name: value(base) if callable(value) else value
                                for name, value in changes.items()})
                 for changes in (term.on, term.off))
