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

"""The pole and the platform: closed, the right size, and a hole that is one."""
import collections
import dataclasses
import math

from flag_sim.drawing import Camera, Dimensions
from flag_sim.drawing.mesh import face_normals, grid_triangles, vertex_normals
from flag_sim.drawing.shapes import platform_mesh, pole_mesh

import numpy as np

import pytest

DIMENSIONS = Dimensions()


def polygon_area(segments, radius):
    """Return the area of a regular polygon."""
    return 0.5 * segments * radius ** 2 * math.sin(2.0 * math.pi / segments)


def volume(mesh):
    """Return the volume inside of a closed mesh by the divergence theorem."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return np.einsum('ij,ij->', a, np.cross(b, c)) / 6.0


@pytest.mark.parametrize('build', [pole_mesh, platform_mesh])
@pytest.mark.parametrize('segments', [8, 12, 28, 256])
def test_meshes_are_closed(build, segments):
    mesh = build(DIMENSIONS, segments)
    edges = collections.Counter()
    places = [tuple(point) for point in np.round(mesh.vertices, 9) + 0.0]
    for triangle in mesh.triangles:
        a, b, c = (places[vertex] for vertex in triangle)
        edges.update([(a, b), (b, c), (c, a)])
    # Each edge once in each direction.
    assert set(edges.values()) == {1}
    assert all((end, begin) in edges for begin, end in edges)


@pytest.mark.parametrize('build', [pole_mesh, platform_mesh])
def test_normals_point_out_of_the_front_and_hard_edges_are_hard(build):
    mesh = build(DIMENSIONS, 64)
    faces = face_normals(mesh.vertices, mesh.triangles)
    faces /= np.linalg.norm(faces, axis=1)[:, None]
    corners = mesh.normals[mesh.triangles]
    corners /= np.linalg.norm(corners, axis=2)[:, :, None]
    cosines = np.einsum('tca,ta->tc', corners, faces)
    # 64 chords turn by 0.1 rad: a smoothed right angle would be far below.
    assert cosines.min() > math.cos(0.1)


def test_the_platforms_volume_and_extent():
    mesh = platform_mesh(DIMENSIONS, 32)
    assert volume(mesh) == pytest.approx((1.0 - polygon_area(32, 0.05)) * 0.3)
    np.testing.assert_allclose(mesh.vertices.min(axis=0), [-0.5, -0.5, 0.0])
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [0.5, 0.5, 0.3])


def test_the_poles_volume_and_extent():
    mesh = pole_mesh(DIMENSIONS, 256)
    exact = math.pi * 0.05 ** 2 * 9.0 + 2.0 / 3.0 * math.pi * 0.1 ** 3
    assert volume(mesh) == pytest.approx(exact, rel=1e-3)
    # The tip's radius is the pole's diameter.
    assert mesh.vertices[:, 2].max() == pytest.approx(9.1)
    np.testing.assert_allclose(mesh.vertices.min(axis=0), [-0.1, -0.1, 0.0], atol=1e-12)


def test_the_hole_is_open_and_has_a_wall():
    mesh = platform_mesh(DIMENSIONS, 32)
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)

    def hits(origin, direction):
        """Count the triangles that a ray meets, by Moeller and Trumbore."""
        p, q = b - a, c - a
        h = np.cross(direction, q)
        with np.errstate(divide='ignore', invalid='ignore'):
            inverse = 1.0 / np.einsum('ij,ij->i', p, h)
            s = np.array(origin) - a
            u = inverse * np.einsum('ij,ij->i', s, h)
            k = np.cross(s, p)
            v = inverse * (k @ np.array(direction, dtype=float))
            t = inverse * np.einsum('ij,ij->i', q, k)
            return int(np.sum((u > 0) & (v > 0) & (u + v < 1) & (t > 0)))

    down = (0.0, 0.0, -1.0)
    for angle in np.linspace(0.01, 6.0, 23):
        x, y = math.cos(angle), math.sin(angle)
        assert hits((0.049 * x, 0.049 * y, 5.0), down) == 0
        assert hits((0.051 * x, 0.051 * y, 5.0), down) == 2
        assert hits((0.0, 0.0, 0.123), (x, y, 0.0)) == 2


def test_pole_and_hole_fit():
    pole, platform = pole_mesh(DIMENSIONS, 20), platform_mesh(DIMENSIONS, 20)

    def on_the_ground(mesh):
        points = np.round(mesh.vertices[mesh.vertices[:, 2] == 0.0], 12) + 0.0
        return {tuple(p) for p in points if math.hypot(*p[:2]) == pytest.approx(0.05)}

    assert on_the_ground(pole) == on_the_ground(platform)
    assert len(on_the_ground(pole)) == 20


def test_round_things_are_cut_as_finely_as_pixels_show():
    far, close = Camera(distance=500.0), Camera(distance=2.0)
    assert DIMENSIONS.segments(far) == 8
    assert DIMENSIONS.segments(far) < DIMENSIONS.segments(close) <= 256
    assert DIMENSIONS.segments(Camera(target=(0, 0, 5), distance=0, near=1e-3)) == 256
    for camera in (far, Camera(), close, Camera(width=7680, height=4320)):
        assert DIMENSIONS.segments(camera) % 4 == 0


@pytest.mark.parametrize('camera, distance', [
    (Camera(distance=20.0), 20.0), (Camera(1280, 720, distance=0.4), 0.4),
    # Above the tip and below the ground it is the way there that counts.
    (Camera(target=(0, 0, 9), distance=4.0, elevation=1.2), 4.0),
    (Camera(target=(0, 0, 0), distance=4.0, elevation=-1.2), 4.0),
    (Camera(projection='orthographic', scale=0.7), 1.0)])
def test_chords_miss_their_circle_by_a_fifth_of_a_pixel_but_hardly_by_less(camera, distance):
    camera = dataclasses.replace(camera, target=(0, 0, camera.target[2]))
    # The nearest point of the dome, of radius 0.1, is that much nearer than the axis.
    pixels = 0.1 * camera.pixels_per_metre(distance - 0.1)

    def missed(segments):
        return pixels * (1.0 - math.cos(math.pi / segments))

    segments = DIMENSIONS.segments(camera)
    assert 8 < segments < 256
    assert missed(segments) <= 0.2 < missed(segments - 4)


@pytest.mark.parametrize('name, value, rule', [
    ('pole_height', 0.0, 'pole_height must be a number from 0.1 to 1000 .m., not 0.0'),
    ('pole_diameter', -0.1, 'pole_diameter must be a number from 0.001 to 10 .m., not -0.1'),
    ('platform_side', math.nan, 'platform_side must be a number from 0.01 to 100 .m., not nan'),
    ('platform_height', math.inf,
     'platform_height must be a number from 0.01 to 100 .m., not inf'),
    ('platform_side', 0.1, 'platform_side must be greater than pole_diameter 0.1, not 0.1'),
    ('pole_diameter', 1.0, 'platform_side must be greater than pole_diameter 1.0, not 1.0')])
def test_invalid_dimensions_are_refused(name, value, rule):
    with pytest.raises(ValueError, match=rule):
        Dimensions(**{name: value})


def test_grid_triangles_are_the_cells_halves():
    np.testing.assert_array_equal(
        grid_triangles(2, 3), [[0, 1, 3], [4, 3, 1], [1, 2, 4], [5, 4, 2]])
    assert grid_triangles(21, 31).shape == (2 * 20 * 30, 3)


def test_vertex_normals_are_weighted_by_area():
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 1]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    np.testing.assert_allclose(face_normals(vertices, triangles), [[0, 0, 4], [2, 0, 0]])
    np.testing.assert_allclose(vertex_normals(vertices, triangles),
                               [[2, 0, 4], [0, 0, 4], [2, 0, 4], [2, 0, 0]])
