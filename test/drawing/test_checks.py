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

"""What cannot be drawn is refused by name, with the rule and the value."""
import copy
import math
import pickle
import re
import warnings

from flag_sim.drawing import (
    body, box_mesh, Camera, Dimensions, flag_scene, interpolate, LastFrame, Light, Materials,
    Object, Picture, sheet, Style, Surface, Texture, transforms)
from flag_sim.drawing.mesh import grid_triangles
from flag_sim.drawing.shapes import platform_mesh, pole_mesh

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture

BOX = box_mesh((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))


@pytest.mark.parametrize('shape', [(3,), (5, 3), (5, 5, 2), (1, 5, 3), (2, 5, 5, 3)])
def test_vertices_of_another_shape_are_refused(shape):
    with pytest.raises(ValueError, match='flag_vertices|grid'):
        DepthPicture().draw(np.zeros(shape)).colour


def test_normals_of_another_shape_are_refused():
    with pytest.raises(ValueError, match='flag_normals'):
        DepthPicture().draw(wave(5, 5), np.zeros((5, 4, 3))).colour


@pytest.mark.parametrize('argument, value', [
    ('camera', 640), ('light', 0.5), ('materials', Surface()), ('dimensions', None),
    ('channels', 'depth'), ('channels', True), ('channels', None), ('channels', ['normal']),
    ('channels', [1]),
    ('style', 'gouraud'), ('flag_vertices', 'flag'), ('flag_vertices', [[[1j] * 3] * 2] * 2),
    ('flag_vertices', np.full((2, 2, 3), None)), ('flag_vertices', np.zeros((2, 2, 3), bool)),
    ('flag_normals', np.zeros((21, 31))), ('flag_normals', np.full((21, 31, 3), '1'))])
def test_arguments_of_an_invalid_type_are_refused_by_name(argument, value):
    with pytest.raises(ValueError, match=f'{argument} must be'):
        Picture().draw(**{'flag_vertices': wave(), argument: value})


@pytest.mark.parametrize('threads', [-1, 65, 1.5, 'two', math.nan])
def test_invalid_numbers_of_threads_are_refused(threads):
    with pytest.raises(ValueError, match='threads must be'):
        DepthPicture(threads)


def test_attributes_that_do_not_exist_are_refused():
    for thing, name in ((Picture(), 'samples'), (Camera(), 'zoom'), (Light(), 'colour'),
                        (Surface(), 'roughness'), (Style(), 'fog'), (Dimensions(), 'ground')):
        with pytest.raises(AttributeError, match=name):
            setattr(thing, name, 4)


@pytest.mark.parametrize('record, name, value', [
    (Dimensions, 'pole_visible', 'no'), (Dimensions, 'platform_visible', None),
    (Style, 'outline', 'false'),
    (Materials, 'flag', (205, 35, 40)), (Style, 'background', (0.7, 0.9, 1.0)),
    (Style, 'samples', True), (Style, 'samples', '4'), (Style, 'samples', [4])])
def test_fields_of_an_invalid_type_are_refused_by_name(record, name, value):
    with pytest.raises(ValueError, match=f'{name} must be'):
        record(**{name: value})


@pytest.mark.parametrize('name, value', [
    ('background', (0, 0, 300)), ('background', (0, 0)), ('shading', 'phong'),
    ('interpolation', 'none'), ('hidden_surface', 'abuffer'), ('samples', 0), ('samples', 2),
    ('samples', 64)])
def test_invalid_styles_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        Style(**{name: value})


@pytest.mark.parametrize('arguments, said', [
    ({'values': np.zeros(5)}, 'values.0. must be of shape'),
    ({'values': [np.zeros((5, 1))]}, 'values must be for all'),
    ({'values': [np.zeros((5, 3, 1))]}, 'values.0. must be of shape'),
    ({'values': [np.zeros((5, 1)), np.zeros((5, 2))]}, 'as many channels'),
    ({'values': [[['a']]]}, 'values.0. must be an array'), ({'values': []}, 'values must be'),
    ({'values': [[[1.0], [1.0, 2.0]]]}, 'values.0. must be an array'),
    ({'values': None}, 'values.0. must be an array'),
    ({'nothing': 'x'}, "nothing must be a number, not 'x'"),
    ({'nothing': (1.0, 2.0)}, 'nothing must be a number'),
    ({'nothing': 1e300}, 'nothing must be at most 3.40282e.38 in size, .*, not 1e.300'),
    ({'values': np.full((5, 1), -1e300)}, 'values.0. must be at most 3.40282e.38 in size'),
    ({'visibility': None}, 'visibility must be of class Visibility'),
    ({'values': [np.zeros((5, 1))], 'at': 'edges'}, 'at must be one of'),
    ({'values': [np.zeros((5, 1))], 'interpolation': 'cubic'}, 'interpolation must be one of')])
def test_invalid_attributes_are_refused(arguments, said):
    frame = Picture().draw(wave(), camera=Camera(64, 48), channels=['visibility'])
    with pytest.raises(ValueError, match=said):
        interpolate(**{'visibility': frame.visibility, 'values': np.zeros((5, 1)), **arguments})


@pytest.mark.parametrize('arguments, said', [
    ({'vertices': np.zeros((3, 2))}, 'vertices must be of shape'),
    ({'vertices': [[0.0, 0.0, 0.0], [1.0]]}, 'vertices must be an array'),
    ({'triangles': None}, 'triangles must be an array'),
    ({'triangles': [[0, 1, 3]]}, 'triangles must be indices of the 3 vertices'),
    ({'triangles': [[0.0, 1.0, 2.0]]}, 'triangles must be whole numbers'),
    ({'texture_coordinates': np.full((3, 2), -1e300)},
     'texture_coordinates must be at most 3.40282e.38 in size, .*, not -1e.300'),
    ({'normals': np.zeros((2, 3))}, 'normals must be of shape'), ({'surface': 'red'}, 'surface'),
    ({'label': -1}, 'label must be between 0 and 255'), ({'is_closed': 1}, 'is_closed')])
def test_invalid_objects_are_refused(arguments, said):
    with pytest.raises(ValueError, match=said):
        Object(**{'vertices': np.zeros((3, 3)), 'triangles': [[0, 1, 2]], **arguments})


@pytest.mark.parametrize('objects', [[], [wave()], [None], None, 5, 'flag'])
def test_invalid_scenes_are_refused(objects):
    with pytest.raises(ValueError, match='objects must be'):
        Picture().draw_scene(objects)


@pytest.mark.parametrize('low, high', [((0, 0, 0), (1, 1, 0)), ((0, 0, 0), (1, -1, 1))])
def test_invalid_boxes_are_refused(low, high):
    with pytest.raises(ValueError, match='high must be greater than low'):
        box_mesh(low, high)


def test_read_only_triangles_are_checked_too():
    # They are checked once; an array of the same triangles may meet fewer vertices.
    triangles = np.array([[0, 1, 3]], np.int32)
    triangles.flags.writeable = False
    Object(np.zeros((4, 3)), triangles)
    with pytest.raises(ValueError, match='triangles must be indices of the 3 vertices'):
        Object(np.zeros((3, 3)), triangles)
    triangles.flags.writeable = True
    triangles[0, 2] = 9
    with pytest.raises(ValueError, match=re.escape('not (0, 9)')):
        Object(np.zeros((4, 3)), triangles)


@pytest.mark.parametrize('arguments, said', [
    ((1, 2), 'mesh must be of class Mesh, not 1'), ((None,), 'mesh must be'),
    ((BOX, 'red'), 'surface must be of class Surface'), ((BOX, Surface(), 1.5), 'label must be'),
    ((BOX, Surface(), 'box'), 'label must be')])
def test_invalid_bodies_are_refused(arguments, said):
    with pytest.raises(ValueError, match=said):
        body(*arguments)


@pytest.mark.parametrize('arguments, said', [
    ((None,), '^vertices must be'), ((wave()[:1],), '2 x 2'),
    ((wave(), wave()[1:]), '^normals must be'),
    ((wave(), 'abc'), "^normals must .*, not 'abc'"),
    ((wave(), None, 'red'), 'surface must be'),
    ((wave(), None, Surface(), 256), 'label must be')])
def test_invalid_sheets_are_refused(arguments, said):
    with pytest.raises(ValueError, match=said):
        sheet(*arguments)


@pytest.mark.parametrize('arguments, said', [
    ({'flag_vertices': [[1], [2, 3]], 'last': LastFrame(wave())}, 'flag_vertices must be'),
    ({'camera': None}, 'camera must be of class Camera'), ({'materials': Surface()}, 'materials'),
    ({'dimensions': 9.0}, 'dimensions must be of class Dimensions')])
def test_invalid_flag_scenes_are_refused(arguments, said):
    with pytest.raises(ValueError, match=said):
        flag_scene(**{'flag_vertices': wave(), **arguments})


@pytest.mark.parametrize('segments', [0, 4, 9, 8.5, '8', None, 260])
@pytest.mark.parametrize('build', [pole_mesh, platform_mesh])
def test_invalid_numbers_of_segments_are_refused(build, segments):
    with pytest.raises(ValueError, match='segments must be'):
        build(Dimensions(), segments)


@pytest.mark.parametrize('function, arguments, said', [
    (transforms.translate, ((0.0, math.inf, 0.0),), 'offset must be finite, not'),
    (transforms.scale, ((1.0, math.nan, 1.0),), 'factors must be finite, not'),
    (transforms.rotate_x, (0.5, (math.inf, 0.0, 0.0)), 'centre must be finite, not'),
    (Texture, ([[1], [2, 3]],), 'image must be an array of real numbers'),
    (transforms.translate, ('x',), 'offset must be'), (transforms.translate, ((1, 2),), 'offset'),
    (transforms.scale, (2.0,), 'factors must be'), (transforms.scale, ((1, 2, 3), 0), 'centre'),
    (transforms.rotate_x, ('x',), 'angle must be'), (transforms.rotate_y, (None,), 'angle must'),
    (transforms.rotate_z, (0.5, (1, 2)), 'centre must be'),
    (transforms.apply, (np.eye(3), (1, 2, 3)), 'matrix must'),
    (transforms.apply, (np.eye(4), (1, 2)), 'points must be of shape'),
    (transforms.apply, (np.eye(4), 1.0), 'points must be of shape'),
    (transforms.apply, (np.eye(4), 'x'), 'points must be an array')])
def test_invalid_transforms_are_refused(function, arguments, said):
    with pytest.raises(ValueError, match=said):
        function(*arguments)


def test_numbers_of_any_type_are_taken_as_they_are():
    """Unsigned ones have no negative, float16 no great and infinite ones no sum."""
    centre = np.array([1, 2, 3], np.uint8)
    np.testing.assert_array_equal(transforms.rotate_z(0.5, centre),
                                  transforms.rotate_z(0.5, (1.0, 2.0, 3.0)))
    frame = Picture().draw(wave(), camera=Camera(64, 48), channels=['visibility'])
    values = np.ones((len(frame.visibility.depths), 1), np.float16)
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        assert np.nanmax(interpolate(frame.visibility, values)) == 1.0
        assert not np.isfinite(transforms.apply(np.eye(4), (math.inf, 0.0, 0.0))).all()


@pytest.mark.parametrize('distance', ['far', None, math.nan, -1.0])
def test_invalid_distances_are_refused(distance):
    with pytest.raises(ValueError, match='distance must be'):
        Camera().pixels_per_metre(distance)


@pytest.mark.parametrize('rows, columns', [('2', 3), (2.5, 3), (None, 3), (1, 5), (5, 1), (0, 0)])
def test_invalid_grids_are_refused(rows, columns):
    with pytest.raises(ValueError, match='rows|columns|2 x 2'):
        grid_triangles(rows, columns)


@pytest.mark.parametrize('draw', [
    lambda: Picture().draw('abc'), lambda: Picture().draw(wave() + 0j),
    lambda: Picture().draw_scene([wave()])])
def test_a_refusal_shows_the_value_on_one_line(draw):
    with pytest.raises(ValueError) as error:
        draw()
    said = str(error.value)
    assert re.search(", not ('abc'|array)", said) and len(said) <= 300 and '\n' not in said


@pytest.mark.parametrize('way', [copy.copy, copy.deepcopy,
                                 lambda thing: pickle.loads(pickle.dumps(thing))])
def test_a_copy_of_a_picture_draws_the_same_into_buffers_of_its_own(way):
    picture = Picture(threads=1)
    frame = picture.draw(wave(), camera=Camera(64, 48))
    again = way(picture).draw(wave(), camera=Camera(64, 48))
    assert np.array_equal(frame.colour, again.colour)
    assert not np.shares_memory(frame.colour, again.colour)
