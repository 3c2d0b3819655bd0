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

"""The kernels against the page for learners, triangle by triangle."""
from flag_sim.drawing import Camera, Dimensions, Light, Materials, Picture, Style, Surface
from flag_sim.drawing.mesh import grid_triangles
from flag_sim.drawing.plain import draw_triangle

import numpy as np

import pytest

from support.flags import wave

NOTHING = Dimensions(pole_visible=False, platform_visible=False)


@pytest.mark.parametrize('interpolation', ['screen', 'perspective'])
@pytest.mark.parametrize('rows, columns', [(3, 4), (9, 13)])
def test_a_flag_triangle_by_triangle(interpolation, rows, columns):
    camera, flag = Camera(160, 120, distance=3.0, azimuth=-1.1), wave(rows, columns)
    light = Light(intensity=0.6, ambient=0.2)
    frame = Picture().draw(flag, None, camera, light, Materials(Surface((200, 120, 60))), NOTHING,
                           Style((0, 0, 0), interpolation=interpolation), channels=['depth'])
    points, triangles = flag.reshape(-1, 3), grid_triangles(rows, columns)
    seen = points @ camera.pose[:3, :3].T + camera.pose[:3, 3]
    image = seen @ camera.K.T
    # Vertices are snapped to 1/256 pixel.
    places = np.floor(image[:, :2] / image[:, 2:] * 256 + 0.5) / 256
    faces = np.cross(points[triangles[:, 1]] - points[triangles[:, 0]],
                     points[triangles[:, 2]] - points[triangles[:, 0]])
    normals = np.zeros_like(points)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], faces)
    cosine = normals @ light.direction / np.linalg.norm(normals, axis=1)
    colour, depth = np.zeros((120, 160, 3)), np.zeros((120, 160))
    for triangle in triangles:
        a, b, c = places[triangle]
        # v points down: counterclockwise triangles have a negative area.
        is_front = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < 0
        level = 0.2 + 0.6 * np.maximum(cosine[triangle] if is_front else -cosine[triangle], 0.0)
        draw_triangle(places[triangle], 1.0 / seen[triangle, 2],
                      level[:, None] * [200.0, 120.0, 60.0], colour, depth,
                      interpolation == 'perspective')
    np.testing.assert_array_equal(depth > 0.0, np.isfinite(frame.depth))
    assert np.mean(depth > 0.0) > 0.2
    np.testing.assert_allclose(1.0 / depth[depth > 0.0], frame.depth[depth > 0.0], rtol=1e-5)
    assert np.abs(colour - frame.colour).max() <= 0.51
