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

"""The cloth as its users meet it: parameters and grids that change, input that is wrong."""
import copy
import dataclasses
import math
import pickle
import sys

from flag_sim.cloth import Air, Cloth, Diverged, Material, simulation, Stepping
from flag_sim.cloth.divergence import validate
from flag_sim.cloth.mesh import Mesh, resample
from flag_sim.cloth.normals import node_normals
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.state import State
import numpy as np
import pytest

WIND = (5.0, 2.0, 0.5)


def running(frames=10, **parameters):
    """Return a cloth that has been in the wind for some frames."""
    cloth = Cloth(9, 13, **parameters)
    for _ in range(frames):
        cloth.advance(0.02, WIND)
    return cloth


def test_it_starts_flat_along_x_below_its_upper_hoist_corner():
    """Row 0 is the upper edge, column 0 the hoist; z is up."""
    cloth = Cloth(3, 5, 2.0, 1.0, (0.05, 0.0, 8.9), start_noise=0.0)
    assert cloth.positions.shape == (3, 5, 3) and cloth.positions.dtype == np.float64
    assert cloth.positions[0, 0] == pytest.approx((0.05, 0.0, 8.9))
    assert cloth.positions[0, 4] == pytest.approx((2.05, 0.0, 8.9))
    assert cloth.positions[2, 4] == pytest.approx((2.05, 0.0, 7.9))
    assert np.all(cloth.velocities == 0.0)
    np.testing.assert_array_equal(cloth.normals(), np.broadcast_to((0.0, 1.0, 0.0), (3, 5, 3)))


def test_pins_stay_to_the_bit_and_the_rest_moves():
    """The hoist is where it was hung."""
    cloth = Cloth(9, 13)
    start = cloth.positions
    for _ in range(5):
        cloth.advance(0.02, WIND)
    assert np.array_equal(cloth.positions[:, 0], start[:, 0])
    assert np.all(cloth.positions[:, 1:] != start[:, 1:])


def test_same_input_same_output_to_the_bit():
    """Also after a reset."""
    first, second = running(), running()
    assert np.array_equal(first.positions, second.positions)
    assert np.array_equal(first.velocities, second.velocities)
    second.reset()
    for _ in range(10):
        second.advance(0.02, WIND)
    assert np.array_equal(first.positions, second.positions)


def test_the_wind_of_a_frame_blows_in_it():
    """Not that of the frame before: a flat sheet at rest begins to move with it."""
    cloth = Cloth(5, 7, gravity=0.0, start_noise=0.0)
    cloth.advance(0.01)
    assert np.all(cloth.velocities[..., 1] == 0.0)
    cloth.advance(0.01, (0.0, 3.0, 0.0))
    assert cloth.velocities[:, 1:, 1].min() > 0.01


@pytest.mark.parametrize('changes', [
    {'material': Material(stiffness=50.0)}, {'material': Material(stiffness=3e5)},
    {'material': Material(damping=0.0)}, {'material': Material(bend_stiffness=0.0)},
    {'material': Material(area_density=2.0)}, {'air': Air(density=0.0)}, {'gravity': 0.0},
    {'stepping': Stepping(substeps=200)}, {'air': Air(law='linear')},
    *({'solver': solver} for solver in SOLVERS)], ids=str)
def test_parameters_change_between_frames_without_a_jump(changes):
    """The state stays as it is; the next frame goes by the new parameter."""
    cloth, same = running(), running()
    before = cloth.positions
    for name, value in changes.items():
        setattr(cloth, name, value)
        assert getattr(cloth, name) == value
    assert np.array_equal(cloth.positions, before)
    cloth.advance(1e-3, WIND)
    same.advance(1e-3, WIND)
    moved = np.abs(cloth.positions - before).max()
    assert 0.0 < moved < 0.02
    if 'solver' not in changes:
        assert not np.array_equal(cloth.positions, same.positions)


def test_whole_numbers_count_as_numbers():
    """Parameters of 1000 and 1000.0 are one parameter, to the bit and without compiling anew."""
    whole = running(material=Material(1, 1000, 500, 0, 0, 0), air=Air(1, 1), gravity=9)
    real = running(material=Material(1.0, 1000.0, 500.0, 0.0, 0.0, 0.0), air=Air(1.0, 1.0),
                   gravity=9.0)
    assert np.array_equal(whole.positions, real.positions)


@pytest.mark.parametrize('grid', [(17, 25), (9, 13), (5, 7), (2, 2), (30, 4)], ids=str)
def test_a_new_grid_keeps_the_motion(grid):
    """
    Edges and corners stay; a finer grid's nodes lie on the old cloth.

    Two columns, or four, cannot hold this cloth between its corners without pressing it together
    (3 J and 1.7 J for 0.05 J): there the free ones give way, by less than a tenth of its length.
    """
    cloth = running()
    old, speed = cloth.positions, cloth.velocities
    cloth.regrid(*grid)
    new = cloth.positions
    assert new.shape == grid + (3,)
    for corner in ((0, 0), (0, -1), (-1, 0), (-1, -1)):
        way = 0.225 if grid[1] < 5 and corner[1] else 1e-12
        np.testing.assert_allclose(new[corner], old[corner], rtol=0.0, atol=way)
        np.testing.assert_allclose(cloth.velocities[corner], speed[corner], atol=1e-12)
    if grid == (17, 25):
        np.testing.assert_allclose(new[::2, ::2], old, atol=1e-12)
        np.testing.assert_allclose(new[1::2, ::2], 0.5 * (old[1:] + old[:-1]), atol=1e-12)
    steps = cloth.advance(0.02, WIND)
    assert steps.stiffness_factor == 1.0
    assert np.abs(cloth.positions - new).max() < 0.5


def test_resampling_is_exact_for_bilinear_fields():
    """A field that is bilinear over the cloth comes through any grid unchanged."""
    def field(rows, columns):
        v, u = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns), indexing='ij')
        return np.stack([u, v, 1.0 + 2.0 * u - v + 3.0 * u * v], axis=-1)

    np.testing.assert_allclose(resample(field(5, 8), 11, 3), field(11, 3), atol=1e-14)


def test_a_new_size_or_place_starts_at_rest():
    """The flag is hung anew."""
    cloth = running()
    cloth.start_noise = 0.0
    cloth.hang((0.1, 0.2, 5.0), 3.0, 2.0)
    np.testing.assert_array_equal(cloth.positions,
                                  Mesh(9, 13, 3.0, 2.0).rest((0.1, 0.2, 5.0)))
    assert cloth.hoist_top == (0.1, 0.2, 5.0)
    assert np.all(cloth.velocities == 0.0)


def test_a_bad_state_is_not_let_out():
    """The frame's start is held, the reason is told, and the cloth goes on after a reset."""
    cloth = running()
    fast = np.zeros((9, 13, 3))
    fast[4, 5] = 1e11
    cloth.place(cloth.positions, fast)
    start = cloth.positions
    with pytest.raises(Diverged, match='beyond'):
        cloth.advance(0.02, WIND)
    assert np.array_equal(cloth.positions, start)
    cloth.reset()
    cloth.advance(0.02, WIND)
    assert np.isfinite(cloth.positions).all()


@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf, 1e10])
@pytest.mark.parametrize('row, what', [(0, 'position'), (2, 'position'), (5, 'velocity')])
def test_one_bad_number_breaks_a_bound(row, what, value):
    """Not a number is out of bounds too, although it compares with nothing."""
    state = State(Mesh(3, 4, 1.0, 1.0))
    validate(state)
    state.mesh.grid(state.data[row])[1, 2] = value
    with pytest.raises(Diverged, match=f'a {what} is not finite or beyond'):
        validate(state)


@pytest.mark.parametrize('arguments, rule', [
    ({'rows': 1}, 'rows must be a whole number from 2'),
    ({'columns': 0}, 'columns must be a whole number from 2'),
    ({'rows': 2.5}, 'rows must be a whole number from 2 to 1001 [nodes], not 2.5'),
    ({'rows': 100000, 'columns': 100000},
     'rows must be a whole number from 2 to 1001 [nodes], not 100000'),
    ({'length': 0.0}, 'length must be between'),
    ({'width': math.nan}, 'width must be finite, not nan'),
    ({'hoist_top': (0.0, 1.0)}, 'hoist_top must have shape (3,), not (2,)'),
    ({'hoist_top': (0.0, 1.0, math.inf)},
     'hoist_top must be finite and at most 1e+06 in size, not inf'),
    ({'hoist_top': ('0', '1', '2')}, 'hoist_top must hold numbers, not'),
    ({'gravity': math.nan}, 'gravity must be a number from 0 to 1000 [m/s2], not nan'),
    ({'solver': 'magic'}, "seed, not 'magic'")])
def test_bad_cloths_are_refused(arguments, rule):
    """The message names the rule and the value."""
    with pytest.raises(ValueError) as error:
        Cloth(**arguments)
    assert rule in str(error.value)


@pytest.mark.parametrize('change, rule', [
    (lambda cloth: cloth.advance(0.0), 'dt must be greater than 0 and at most 3600, not 0'),
    (lambda cloth: cloth.advance(-0.1), 'dt must be greater than 0 and at most 3600, not -0.1'),
    (lambda cloth: cloth.advance(math.nan), 'dt must be finite, not nan'),
    (lambda cloth: cloth.advance(1e6), 'dt must be greater than 0 and at most 3600, not 1e+06'),
    (lambda cloth: cloth.advance(0.02, (1.0, 2.0)), 'wind must have shape (3,), not (2,)'),
    (lambda cloth: cloth.advance(0.02, (1.0, 2.0, math.nan)), 'wind must be finite'),
    (lambda cloth: cloth.advance(0.02, (0.0, 1e5, 0.0)), 'wind must be finite and at most 10000'),
    (lambda cloth: cloth.advance(0.02, 'north'), "wind must hold numbers, not 'north'"),
    (lambda cloth: cloth.regrid(1, 5), 'rows must be a whole number from 2'),
    (lambda cloth: cloth.hang((0.0, 0.0, 1.0), -1.0, 1.0), 'length must be between'),
    (lambda cloth: cloth.place(np.zeros((2, 2, 3))), 'positions must have shape (9, 13, 3)'),
    (lambda cloth: cloth.place(cloth.positions, np.full((9, 13, 3), np.nan)),
     'velocities must be finite'),
    (lambda cloth: setattr(cloth, 'solver', 'magic'), 'solver must be one of'),
    (lambda cloth: setattr(cloth, 'solver', ['rk4']), "not ['rk4']"),
    (lambda cloth: setattr(cloth, 'material', None), 'material must be of class Material'),
    (lambda cloth: setattr(cloth, 'air', 'storm'), "air must be of class Air, not 'storm'"),
    (lambda cloth: setattr(cloth, 'stepping', 5), 'stepping must be of class Stepping, not 5'),
    (lambda cloth: setattr(cloth, 'precision', 'float16'), 'precision must be one of'),
    (lambda cloth: setattr(cloth, 'stretch_limit', -1.0), 'stretch_limit must be a number from 0'),
    (lambda cloth: setattr(cloth, 'pole', (0.0, 0.0, 0.0)), 'radius of the pole must be greater'),
    (lambda cloth: setattr(cloth, 'gravity', 'down'),
     "gravity must be a number from 0 to 1000 [m/s2], not 'down'")])
def test_bad_changes_are_refused_and_change_nothing(change, rule):
    """The cloth goes on exactly as if they had not been asked for."""
    cloth, same = running(3), running(3)
    with pytest.raises(ValueError) as error:
        change(cloth)
    assert rule in str(error.value)
    cloth.advance(0.02, WIND)
    same.advance(0.02, WIND)
    assert np.array_equal(cloth.positions, same.positions)


@pytest.mark.parametrize('change', [
    lambda cloth: setattr(cloth, 'material', Material(stiffness=5.0)),
    lambda cloth: setattr(cloth, 'solver', 'rk4'),
    lambda cloth: setattr(cloth, 'precision', 'float32'),
    lambda cloth: cloth.regrid(5, 7),
    lambda cloth: cloth.hang((1.0, 2.0, 3.0), 2.0, 1.0)])
def test_a_change_that_memory_does_not_suffice_for_changes_nothing(change, monkeypatch):
    """Not even in part: what is new is made before anything old is given up."""
    cloth, same = running(3), running(3)

    def fail(*arguments):
        raise MemoryError

    with monkeypatch.context() as patch:
        for kind in SOLVERS.values():
            patch.setattr(kind, '__init__', fail)
        with pytest.raises(MemoryError):
            change(cloth)
    assert cloth.material == same.material and cloth.solver == same.solver
    assert cloth.mesh.precision == same.mesh.precision and cloth.hoist_top == same.hoist_top
    cloth.advance(0.02, WIND)
    same.advance(0.02, WIND)
    assert np.array_equal(cloth.positions, same.positions)


def test_values_that_stay_cost_nothing(monkeypatch):
    """Neither model nor work arrays are made anew; a softened model stays as it is too."""
    cloth = Cloth(9, 13, stepping=Stepping(substeps_limit=2))
    assert cloth.advance(0.02, WIND).stiffness_factor < 1.0
    softened = cloth.model
    made = []
    monkeypatch.setattr(simulation, 'Model', lambda *arguments: made.append(arguments))
    for frame in range(3):
        cloth.material, cloth.air, cloth.stepping = Material(), Air(), Stepping(substeps_limit=2)
        cloth.gravity, cloth.solver, cloth.precision = 9.81 - frame, 'symplectic', 'float64'
        cloth.stretch_limit, cloth.pole = 1.0, None
        cloth.advance(0.02, WIND)
    assert made == [] and cloth.model is softened


def test_whole_numbers_of_steps_may_come_as_floats():
    """The compiled loops over them would not take one."""
    stepping = Stepping(substeps=30.0, substeps_limit=100.0)
    assert [type(stepping.substeps), type(stepping.substeps_limit)] == [int, int]
    assert Cloth(3, 3, stepping=stepping).advance(0.01, WIND).granted == 30
    with pytest.raises(ValueError, match='substeps must be a whole number from 0 .*, not 3.5'):
        Stepping(substeps=3.5)


def test_terms_with_coefficient_zero_are_as_if_they_were_not_there():
    """They neither ask for steps nor leave a trace of the term in the work arrays."""
    here = (0.0, 0.0, 0.0)  # so that positions given out and taken in are to the bit those inside
    stiff = Cloth(5, 7, hoist_top=here, material=Material(stiffness=1e4, damping=0.5))
    stiff.advance(0.01, WIND)
    off = dataclasses.replace(stiff.material, stiffness=0.0, shear_stiffness=0.0,
                              bend_stiffness=0.0)
    stiff.material = off
    fresh = Cloth(5, 7, hoist_top=here, material=off)
    fresh.place(stiff.positions, stiff.velocities)
    assert stiff.advance(0.01, WIND) == fresh.advance(0.01, WIND) == (1, 1, 1.0, 1.0)
    assert np.array_equal(stiff.positions, fresh.positions)


def test_normals_of_a_sphere_point_away_from_its_centre():
    """Averaged over faces, they are the surface's to second order in the spacing."""
    def worst(count):
        v, u = np.meshgrid(np.linspace(1.0, 2.0, count), np.linspace(0.0, 1.0, count),
                           indexing='ij')
        sphere = np.stack([np.sin(v) * np.sin(u), np.sin(v) * np.cos(u), np.cos(v)], axis=-1)
        normals = node_normals(sphere)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0, atol=1e-14)
        return np.abs(normals - sphere)[1:-1, 1:-1].max()

    assert worst(11) < 1e-2
    assert worst(21) < 0.3 * worst(11)


def test_normals_of_a_collapsed_cloth_are_still_unit_vectors():
    """Where there is no face there is a default."""
    np.testing.assert_array_equal(node_normals(np.ones((3, 4, 3))),
                                  np.broadcast_to((0.0, 1.0, 0.0), (3, 4, 3)))


def test_a_frame_costs_little_beyond_its_steps():
    """A frame of one step on the smallest grid calls few functions: 300 take 0.1 ms."""
    cloth = Cloth(2, 2, stepping=Stepping(substeps_limit=1))
    cloth.advance(1e-3, WIND)
    called = []
    sys.setprofile(lambda frame, event, _: called.append(event) if 'call' in event else None)
    cloth.advance(1e-3, WIND)
    sys.setprofile(None)
    assert 0 < len(called) < 600


@pytest.mark.parametrize('way', [copy.copy, copy.deepcopy,
                                 lambda cloth: pickle.loads(pickle.dumps(cloth))])
@pytest.mark.parametrize('parameters', [
    {}, {'solver': 'implicit', 'precision': 'float32', 'threads': 1},
    {'threads': 2, 'pole': (0.0, 0.0, 0.05), 'stepping': Stepping(substeps_limit=1)}], ids=str)
def test_a_copy_goes_on_equally_and_alone(way, parameters):
    """To the bit, by any way of copying; what one does is nothing to the other."""
    cloth = Cloth(5, 7, **parameters)
    cloth.advance(1.0 / 30.0, WIND)
    other, before = way(cloth), cloth.positions
    assert other.model.factors == cloth.model.factors and other.held == cloth.held
    for _ in range(3):
        other.advance(1.0 / 30.0, WIND)
    assert np.array_equal(cloth.positions, before)
    for _ in range(3):
        cloth.advance(1.0 / 30.0, WIND)
    assert np.array_equal(cloth.positions, other.positions)
    assert np.array_equal(cloth.velocities, other.velocities)
    with pytest.raises(AttributeError):
        other.stiffness = 1.0
