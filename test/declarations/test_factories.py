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

"""What values make: each reaches the part of the library that it is named for, and no other."""
import inspect

from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.cloth.material import DRAG_LAWS
from flag_sim.cloth.mesh import PRECISIONS
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.declarations.factories import air_of, cloth_of, hang_of, look_of, material_of
from flag_sim.declarations.factories import stepping_of
from flag_sim.declarations.nodes import defaults, named
from flag_sim.declarations.physics import GRID, OPTIONS
from flag_sim.drawing import Camera, Dimensions, Light, Materials, Style, Surface
from flag_sim.drawing.style import SAMPLES
import pytest

RED = (205.0, 35.0, 40.0)
MAKES = {  # a parameter, a value, and the part of the look that is no longer as it is born
    'width': (100, 'camera', Camera(width=100)),
    'camera.distance': (3.0, 'camera', Camera(distance=3.0)),
    'sun.azimuth': (0.5, 'light', Light(azimuth=0.5)),
    'ambient': (0.1, 'light', Light(ambient=0.1)),
    'flag.transmission': (0.5, 'materials', Materials(flag=Surface(RED, transmission=0.5))),
    'pole.color': ([1.0, 2.0, 3.0], 'materials', Materials(pole=Surface((1.0, 2.0, 3.0)))),
    'platform.height': (0.5, 'dimensions', Dimensions(platform_height=0.5)),
    'pole.visible': (False, 'dimensions', Dimensions(pole_visible=False)),
    'samples': (4, 'style', Style(samples=4)),
}


def values_of(node, **changes):
    """Return {parameter: value} of a node: defaults, changed; `__` in a name stands for a dot."""
    changes = {name.replace('__', '.'): value for name, value in changes.items()}
    return defaults(node) | changes


def test_every_solver_law_precision_and_number_of_samples_can_be_chosen():
    """The choices of the node are those of the library."""
    physics = named('physics')
    assert set(physics['solver'].choices) == set(SOLVERS)
    assert set(physics['air.law'].choices) == set(DRAG_LAWS)
    assert physics['precision'].choices == PRECISIONS
    renderer = named('renderer')
    assert renderer['samples'].choices == SAMPLES


def test_defaults_are_those_of_the_library():
    """The nodes and the classes below them start from the same values."""
    physics = defaults('physics')
    assert material_of(physics) == Material()
    assert air_of(physics) == Air()
    assert stepping_of(physics) == Stepping()
    cloth = inspect.signature(Cloth).parameters
    for argument, default in {**GRID.arguments(physics), **OPTIONS.arguments(physics)}.items():
        assert cloth[argument].default == default, argument
    renderer = defaults('renderer')
    assert look_of(renderer) == (Camera(), Light(), Materials(), Dimensions(), Style())


@pytest.mark.parametrize('declaration', MAKES)
def test_a_parameter_of_the_look(declaration):
    """It changes its own part; all others are as they are born."""
    value, part, expected = MAKES[declaration]
    born = look_of(values_of('renderer'))
    look = look_of(values_of('renderer', **{declaration: value}))
    assert look == born._replace(**{part: expected})


def test_a_colour_that_fades_to_black_passes_what_people_may_not_give():
    look = look_of(values_of('renderer', background=[0.5, 0.2, 0.0], flag__color=[0.9, 0.0, 0.0]))
    assert look.style.background == look.materials.flag.color == (0.0, 0.0, 0.0)


def test_the_parameters_of_the_cloth():
    """Every one that is not born so is found in the cloth."""
    cloth = cloth_of(values_of(
        'physics', grid__rows=5, grid__columns=7, flag__length=1.0, flag__width=0.5, stiffness=2.0,
        air__law='linear', air__density=1.0, substeps=70, solver='verlet', gravity=1.0,
        stretch_limit=0.5, precision='float32', pole__diameter=0.2))
    mesh = cloth.mesh
    assert (mesh.rows, mesh.columns, mesh.length, mesh.width) == (5, 7, 1.0, 0.5)
    assert cloth.material == Material(stiffness=2.0)
    assert cloth.air == Air(density=1.0, law='linear')
    assert cloth.stepping == Stepping(substeps=70)
    assert (cloth.solver, cloth.gravity, cloth.stretch_limit) == ('verlet', 1.0, 0.5)
    assert (cloth.precision, cloth.pole) == ('float32', (0.0, 0.0, 0.1))
    assert cloth.hoist_top == (0.1, 0.0, 8.8)
    assert cloth_of(values_of('physics', pole_collision=False)).pole is None


def test_a_flag_without_a_size_follows_from_its_pole():
    """Its width is a sixth of the pole, its length one and a half times the width (sec. 1.2)."""
    hoist_top, length, width = hang_of(values_of('physics', pole__height=6.0))
    assert (hoist_top, length, width) == ((0.05, 0.0, 5.9), 1.5, 1.0)
    assert hang_of(values_of('physics', flag__width=2.0))[1:] == (3.0, 2.0)
    assert hang_of(values_of('physics', flag__length=2.0))[1:] == (2.0, 1.5)


@pytest.mark.parametrize('make, node, name, value', [
    (material_of, 'physics', 'stiffness', -1.0), (air_of, 'physics', 'air.law', 'cubic'),
    (cloth_of, 'physics', 'air.density', 1e9), (look_of, 'renderer', 'sun.azimuth', 90.0),
    (look_of, 'renderer', 'platform.height', 0.0), (look_of, 'renderer', 'pole.shininess', 0.5)])
def test_what_is_refused_is_named_as_its_user_has_typed_it(make, node, name, value):
    """With its node's prefix, not as the library's field."""
    with pytest.raises(ValueError) as error:
        make({**defaults(node), name: value})
    assert str(error.value).startswith(f'{name} must be ')
    assert str(error.value).endswith(f', not {value!r}')
