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

"""The sheet is the material that is asked for, whatever the grid and the shape of its cells."""
import math

from flag_sim.cloth.energy import bending_energy, elastic_energy
from flag_sim.cloth.material import Air, Material
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.model import Model
from flag_sim.cloth.stepping import Stepping
import numpy as np
import pytest

K, G, B = 1200.0, 500.0, 3e-3
SIZE = (2.0, 1.5)
GRIDS = [(16, 21), (31, 41), (16, 31), (31, 28), (11, 17)]


def sheet(rows, columns, length=SIZE[0], width=SIZE[1], **parameters):
    """Return a model of the test's material, and its flat positions."""
    parameters = {'stiffness': K, 'shear_stiffness': G, 'bend_stiffness': B, **parameters}
    mesh = Mesh(rows, columns, length, width)
    return Model(mesh, Material(**parameters)), mesh.rest((0.0, 0.0, 0.0))


@pytest.mark.parametrize('rows, columns', GRIDS)
@pytest.mark.parametrize('strain, modulus', [
    ((1.0, 0.0, 0.0), K + G), ((0.0, 1.0, 0.0), K + G), ((0.0, 0.0, 1.0), G),
    ((1.0, 1.0, 0.0), 2.0 * (K + G) + 2.0 * G), ((1.0, -1.0, 0.0), 2.0 * (K + G) - 2.0 * G)])
def test_uniform_strain_has_the_energy_of_the_sheet(rows, columns, strain, modulus):
    """E / area = (C11 e1^2 + C22 e2^2 + 2 C12 e1 e2 + C66 g^2) / 2 with C11 = C22 = K + G."""
    model, rest = sheet(rows, columns)
    size = 1e-6
    along, down, shear = (size * part for part in strain)
    moved = rest.copy()
    moved[..., 0] += along * rest[..., 0] + 0.5 * shear * rest[..., 2]
    moved[..., 2] += down * rest[..., 2] + 0.5 * shear * rest[..., 0]
    expected = 0.5 * modulus * size**2 * SIZE[0] * SIZE[1]
    # The strain is finite: the error is of the order of the strain itself, and of rounding.
    assert elastic_energy(model, moved) == pytest.approx(expected, rel=1e-5)


def test_cells_too_long_for_the_material_are_too_stiff_along_their_length_only():
    """Beyond (dx/dy)^2 = 1 + K/G no spring constant may turn negative: the documented limit."""
    model, rest = sheet(31, 11)
    aspect2 = (model.mesh.dx / model.mesh.dy)**2
    assert aspect2 > 1.0 + K / G
    assert min(model.spring_k) == 0.0
    for axis, modulus in ((0, G * aspect2), (2, K + G)):
        moved = rest.copy()
        moved[..., axis] *= 1.0 + 1e-6
        expected = 0.5 * modulus * 1e-12 * SIZE[0] * SIZE[1]
        assert elastic_energy(model, moved) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize('rows, columns', GRIDS)
@pytest.mark.parametrize('turn', [0.0, 0.3, math.pi / 4, math.pi / 2])
def test_a_gentle_cylinder_has_the_energy_of_a_plate(rows, columns, turn):
    """B/2 curvature^2 per area, whichever way the sheet is rolled and whatever the cells."""
    model, rest = sheet(rows, columns)
    radius = 5.0
    across = np.cos(turn) * rest[..., 0] + np.sin(turn) * rest[..., 2]
    along = -np.sin(turn) * rest[..., 0] + np.cos(turn) * rest[..., 2]
    rolled = np.stack([radius * np.sin(across / radius), radius * np.cos(across / radius), along],
                      axis=-1)
    curvature = np.array([np.cos(turn)**2, np.sin(turn)**2])
    # Curvature along the rows is summed over all but the two border columns' half cells, and
    # likewise down the columns: natural edges bear no moment.
    covered = np.array([(columns - 2) / (columns - 1), (rows - 2) / (rows - 1)])
    twist = 2.0 * (np.cos(turn) * np.sin(turn))**2
    per_area = 0.5 * B / radius**2 * (np.sum(curvature**2 * covered) + twist)
    assert bending_energy(model, rolled) == pytest.approx(per_area * SIZE[0] * SIZE[1], rel=1e-3)
    assert per_area == pytest.approx(0.5 * B / radius**2, rel=0.15)


@pytest.mark.parametrize('rows, columns', GRIDS)
def test_a_saddle_has_the_energy_of_a_plate_with_poissons_ratio_zero(rows, columns):
    """
    Of w = a u^2 / 2 + c v^2 / 2 + t u v: B/2 ((a + c)^2 - 2 (a c - t^2)) per area.

    Exact on every grid, but for the strips beside the edges, half a cell wide, that lack the
    curvature across them.
    """
    model, flat = sheet(rows, columns)
    u, v = flat[..., 0], flat[..., 2]
    a, c, t = 0.03, -0.02, 0.05
    bent = flat.copy()
    bent[..., 1] = 0.5 * a * u**2 + 0.5 * c * v**2 + t * u * v
    lacking = 0.5 * B * (a**2 / (columns - 1) + c**2 / (rows - 1))
    plate = 0.5 * B * ((a + c)**2 - 2.0 * (a * c - t**2))
    per_area = bending_energy(model, bent) / (SIZE[0] * SIZE[1])
    assert per_area == pytest.approx(plate - lacking, rel=1e-9)


def test_bending_energy_neither_sees_motion_nor_stretch():
    """It is zero in every flat state, wherever it lies and however it is sheared."""
    model, rest = sheet(11, 16)
    rng = np.random.default_rng(1)
    for _ in range(5):
        flat = rest @ rng.normal(size=(3, 3)) + rng.normal(size=3)
        assert bending_energy(model, flat) < 1e-20


@pytest.mark.parametrize('rows, columns', GRIDS)
def test_mass_is_the_same_on_every_grid(rows, columns):
    """Lumped by area: the sheet's mass in all, a quarter of a cell's at a corner."""
    model, _ = sheet(rows, columns)
    mass = model.mesh.grid(model.mass)
    assert mass.sum() == pytest.approx(0.2 * SIZE[0] * SIZE[1], rel=1e-12)
    assert mass[0, 0] == pytest.approx(0.25 * model.cell_mass)
    assert mass[0, 1] == pytest.approx(0.5 * model.cell_mass)
    assert mass[1, 1] == pytest.approx(model.cell_mass)


@pytest.mark.parametrize('rows, columns', GRIDS)
def test_damping_is_the_ratio_of_two_nodes_on_a_spring(rows, columns):
    """Their distance d obeys m/2 d'' + c d' + k d = 0, which is critical where c^2 = 2 k m."""
    model, _ = sheet(rows, columns, damping=0.3)
    for k, c in zip(model.spring_k, model.spring_c):
        assert c == pytest.approx(0.3 * math.sqrt(2.0 * k * model.cell_mass), rel=1e-12)


@pytest.mark.parametrize('kind, parameters, rule', [
    (Material, {'area_density': 0.0},
     'area_density must be a number from 1.0e-06 to 1.0e+06 [kg/m2], not 0'),
    (Material, {'area_density': -1.0},
     'area_density must be a number from 1.0e-06 to 1.0e+06 [kg/m2], not -1'),
    (Material, {'stiffness': -1.0}, 'stiffness must be a number from 0'),
    (Material, {'stiffness': math.nan},
     'stiffness must be a number from 0 to 1.0e+09 [N/m], not nan'),
    (Material, {'shear_stiffness': math.inf},
     'shear_stiffness must be a number from 0 to 1.0e+09 [N/m], not inf'),
    (Material, {'bend_stiffness': 'soft'},
     "bend_stiffness must be a number from 0 to 1.0e+06 [N m], not 'soft'"),
    (Material, {'damping': None}, 'damping must be a number from 0 to 1.0e+06, not None'),
    (Material, {'node_damping': -0.1}, 'node_damping must be a number from 0'),
    (Air, {'density': -1.2}, 'density must be a number from 0'),
    (Air, {'drag_coefficient': math.nan},
     'drag_coefficient must be a number from 0 to 100, not nan'),
    (Stepping, {'substeps': -1}, 'substeps must be a whole number from 0'),
    (Stepping, {'substeps': 1.5}, 'substeps must be a whole number from 0 to 100000, not 1.5'),
    (Stepping, {'step_safety': 0.0}, 'step_safety must be a number from 0.01 to 1, not'),
    (Stepping, {'step_safety': 1.01}, 'step_safety must be a number from 0.01 to 1, not'),
    (Stepping, {'substeps_limit': 0}, 'substeps_limit must be a whole number from 1')])
def test_bad_parameters_are_refused_by_name(kind, parameters, rule):
    """The message names the parameter, the rule and the value."""
    with pytest.raises(ValueError) as error:
        kind(**parameters)
    assert rule in str(error.value)
