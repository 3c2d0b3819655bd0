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
import math

from flag_sim.drawing import Camera, Dimensions, Light, Materials, Picture, Style, Surface

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture


@pytest.mark.parametrize('shape', [(3,), (5, 3), (5, 5, 2), (1, 5, 3), (2, 5, 5, 3)])
def test_vertices_of_another_shape_are_refused(shape):
    with pytest.raises(ValueError, match='flag_vertices|grid'):
        DepthPicture().draw(np.zeros(shape)).colour


def test_normals_of_another_shape_are_refused():
    with pytest.raises(ValueError, match='flag_normals'):
        DepthPicture().draw(wave(5, 5), np.zeros((5, 4, 3))).colour


@pytest.mark.parametrize('argument, value', [
    ('camera', 640), ('light', 0.5), ('materials', Surface()), ('dimensions', None),
    ('style', 'gouraud'), ('flag_vertices', 'flag'), ('flag_vertices', [[[1j] * 3] * 2] * 2),
    ('flag_vertices', np.full((2, 2, 3), None)), ('flag_vertices', np.zeros((2, 2, 3), bool)),
    ('flag_normals', np.zeros((21, 31))), ('flag_normals', np.full((21, 31, 3), '1'))])
def test_what_is_no_such_thing_is_refused_by_name(argument, value):
    with pytest.raises(ValueError, match=f'{argument} must be'):
        DepthPicture().draw(**{'flag_vertices': wave(), argument: value}).colour


@pytest.mark.parametrize('threads', [-1, 65, 1.5, 'two', math.nan])
def test_a_number_of_threads_that_cannot_be_is_refused(threads):
    with pytest.raises(ValueError, match='threads must be'):
        DepthPicture(threads)


def test_attributes_that_do_not_exist_are_refused():
    for thing, name in ((Picture(), 'samples'), (Camera(), 'zoom'), (Light(), 'colour'),
                        (Surface(), 'roughness'), (Style(), 'fog'), (Dimensions(), 'ground')):
        with pytest.raises(AttributeError, match=name):
            setattr(thing, name, 4)


@pytest.mark.parametrize('record, name, value', [
    (Dimensions, 'pole_visible', 'no'), (Dimensions, 'platform_visible', None), (Style, 'outline', 'false'),
    (Materials, 'flag', (205, 35, 40)), (Style, 'background', (0.7, 0.9, 1.0)),
    (Style, 'samples', True), (Style, 'samples', '4'), (Style, 'samples', [4])])
def test_what_is_of_another_type_is_refused_by_name(record, name, value):
    with pytest.raises(ValueError, match=f'{name} must be'):
        record(**{name: value})


@pytest.mark.parametrize('name, value', [
    ('background', (0, 0, 300)), ('background', (0, 0)), ('shading', 'phong'),
    ('interpolation', 'none'), ('hidden_surface', 'abuffer'), ('samples', 0), ('samples', 2),
    ('samples', 64)])
def test_a_style_that_is_none_is_refused(name, value):
    with pytest.raises(ValueError, match=name):
        Style(**{name: value})
