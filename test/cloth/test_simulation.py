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

"""The cloth as its users meet it: wind, parameters, sizes and grids that change, copies."""
import copy
import dataclasses
import pickle
import sys

from flag_sim.cloth import Air, Cloth, Material, simulation, Stepping
from flag_sim.cloth.mesh import Mesh, resample
from flag_sim.cloth.solvers import SOLVERS
import numpy as np
import pytest
from support.cloths import running, WIND


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
