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

"""Whole frames against rays cast by hand, and planes and spheres against formulas."""
import math

from flag_sim.drawing import Camera, Dimensions, Light, Materials, Style, Surface
from flag_sim.drawing.mesh import grid_triangles
from flag_sim.drawing.shapes import platform_mesh, pole_mesh

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture

NOTHING = Dimensions(pole_visible=False, platform_visible=False)
WHITE = Materials(flag=Surface((255, 255, 255)))


def cast_rays(camera, flag, dimensions):
    """
    Find the nearest surface through each pixel's centre by Moeller and Trumbore.

    Return depth (height, width), +inf where nothing is. Backs of closed bodies do not count.
    """
    segments = dimensions.segments(camera)
    surfaces = [(flag.reshape(-1, 3), grid_triangles(*flag.shape[:2]), True)]
    for mesh in (pole_mesh(dimensions, segments), platform_mesh(dimensions, segments)):
        surfaces.append((mesh.vertices, mesh.triangles, False))
    v, u = np.mgrid[:camera.height, :camera.width]
    x, y = ((u - camera.centre[0]) / camera.focal).ravel(), \
        ((v - camera.centre[1]) / camera.focal).ravel()
    nearest = np.full(x.size, np.inf)
    turn = camera.pose[:3, :3].T
    if camera.is_perspective:
        origins = np.tile(camera.position, (x.size, 1))
        ways = np.column_stack([x, y, np.ones_like(x)]) @ turn.T
    else:
        origins = camera.position + np.column_stack([x, y, np.zeros_like(x)]) @ turn.T
        ways = np.tile(turn[:, 2], (x.size, 1))
    for vertices, triangles, two_sided in surfaces:
        for a, b, c in vertices[triangles]:
            h = np.cross(ways, c - a)
            determinant = h @ (b - a)
            with np.errstate(divide='ignore', invalid='ignore'):
                s = origins - a
                k = np.cross(s, b - a)
                p = np.einsum('ij,ij->i', s, h) / determinant
                q = np.einsum('ij,ij->i', ways, k) / determinant
                t = k @ (c - a) / determinant
                hit = (p >= 0) & (q >= 0) & (p + q <= 1) & (t >= camera.near) & (t < nearest)
            # A ray that meets the front has a positive determinant.
            hit &= (determinant != 0) if two_sided else (determinant > 0)
            nearest[hit] = t[hit]
    return nearest.reshape(camera.height, camera.width)


VIEWS = {
    'default': {},
    'behind': {'azimuth': 1.2, 'elevation': 0.3, 'distance': 7.0},
    'platform': {'target': (0, 0, 0.2), 'distance': 2.5, 'elevation': 0.5},
    'below': {'target': (0, 0, 0), 'distance': 1.5, 'elevation': -1.2},
    'straight down': {'target': (0, 0, 5), 'distance': 8.0, 'elevation': math.pi / 2},
    'straight up': {'target': (0.7, 0.2, 5), 'distance': 6.0, 'elevation': -math.pi / 2,
                    'vertical_fov': 1.0},
    'within the cloth': {'target': (1.2, 0.45, 8.2), 'distance': 0.0, 'azimuth': 0.4,
                         'elevation': 0.2, 'vertical_fov': 2.0},
    'along the cloth, rolled': {'target': (1.0, 0.3, 8.2), 'distance': 0.3, 'azimuth': 3.3,
                                'roll': 0.7, 'vertical_fov': 1.8},
    'on the platform': {'target': (0.2, 0.2, 0.35), 'distance': 0.1, 'azimuth': 0.6,
                        'elevation': 0.1, 'vertical_fov': 2.4},
    'orthographic': {'projection': 'orthographic', 'target': (1.05, 0, 8.05),
                     'elevation': 0.4},
    'orthographic, cut by the near plane': {'projection': 'orthographic', 'scale': 4.0,
                                            'distance': 0.0, 'azimuth': 0.3},
}


@pytest.mark.parametrize('view', VIEWS)
def test_mask_and_depth_against_rays(view):
    camera = Camera(width=120, height=90, **VIEWS[view])
    picture, flag = DepthPicture(), wave(11, 16)
    picture.draw(flag, camera=camera).colour
    depth, expected = picture.frame.depth, cast_rays(camera, flag, Dimensions())
    drawn, cast = np.isfinite(depth), np.isfinite(expected)
    assert cast.any()
    # Corners are snapped to 1/256 pixel: a ray within that of a silhouette may differ.
    assert np.sum(drawn != cast) <= 0.001 * drawn.size
    both = drawn & cast
    error = np.abs(depth[both] - expected[both]) / np.maximum(expected[both], 1.0)
    assert np.mean(error > 1e-3) <= 0.005
    assert np.median(error) < 1e-4


def test_a_vertex_is_where_pose_and_projection_say():
    camera = Camera(width=321, height=203, vertical_fov=0.5, azimuth=-1.2, elevation=0.3, roll=0.2)
    picture = DepthPicture()
    for point in ((0.5, 0.1, 8.0), (1.9, -0.3, 8.7), (1.0, 0.0, 7.3)):
        # A tiny square about the point, that must be drawn about its pixel.
        x, y = np.meshgrid([-0.02, 0.02], [0.02, -0.02])
        square = np.array(point) + x[..., None] * camera.pose[0, :3] + \
            y[..., None] * camera.pose[1, :3]
        picture.draw(square, camera=camera, dimensions=NOTHING).colour
        v, u = np.nonzero(np.isfinite(picture.frame.depth))
        image = camera.P @ camera.pose @ np.array([*point, 1.0])
        assert u.mean() == pytest.approx(image[0] / image[2], abs=0.5)
        assert v.mean() == pytest.approx(image[1] / image[2], abs=0.5)
        assert len(u) == pytest.approx((0.04 * camera.focal / image[2]) ** 2, rel=0.3)


def test_a_plane_has_its_depth_and_colour():
    # y = 1 + x / 2, seen from the origin along +y: depth 1 / (1 - p / 2), p the ray's slope.
    # It reaches behind the eye on the left and out of the picture on all sides.
    camera = Camera(width=200, height=100, target=(0, 0, 0), distance=0.0, azimuth=-math.pi / 2,
                    elevation=0.0, vertical_fov=1.0)
    x, z = np.meshgrid([-5.0, 9.0], [30.0, -30.0])
    light = Light(azimuth=-1.0, elevation=0.3, intensity=0.6, ambient=0.2)
    picture = DepthPicture()
    rgb = picture.draw(np.stack([x, 1 + x / 2, z], -1), camera=camera, light=light,
                       materials=WHITE, dimensions=NOTHING).colour
    slope = (np.arange(200) - 99.5) / camera.focal
    expected = np.broadcast_to(1 / (1 - slope / 2), (100, 200))
    np.testing.assert_allclose(picture.frame.depth, expected, rtol=2e-4)
    cosine = np.dot(np.array([0.5, -1.0, 0.0]) / math.sqrt(1.25), light.direction)
    assert np.unique(rgb) == round(255 * (0.2 + 0.6 * cosine))


def test_a_sphere_has_its_silhouette_depth_and_light():
    centre, radius = np.array([1.0, 0.0, 8.0]), 0.8
    polar, around = np.meshgrid(np.linspace(0, math.pi, 181), np.linspace(0, 2 * math.pi, 361),
                                indexing='ij')
    normals = np.stack([np.sin(polar) * np.sin(around), np.sin(polar) * np.cos(around),
                        np.cos(polar)], axis=-1)
    camera = Camera(width=300, height=220, target=centre, distance=4.0, elevation=0.2)
    light = Light(azimuth=-1.5, elevation=0.4, intensity=0.7, ambient=0.2)
    picture = DepthPicture()
    # Around runs from y to x: along the rows it is clockwise, and the front is outside in.
    rgb = picture.draw(centre + radius * normals, normals, camera, light, WHITE, NOTHING,
                       Style(interpolation='perspective')).colour
    depth = picture.frame.depth

    v, u = np.mgrid[:220, :300]
    ways = np.stack([(u - camera.centre[0]) / camera.focal, (v - camera.centre[1]) / camera.focal,
                     np.ones(u.shape)], axis=-1) @ camera.pose[:3, :3]
    to_centre = centre - camera.position
    square, along = np.sum(ways ** 2, axis=-1), ways @ to_centre
    root = along ** 2 - square * (to_centre @ to_centre - radius ** 2)
    well_inside, outside = root > 0.02, root < 0
    assert not np.isfinite(depth[outside]).any()
    exact = (along - np.sqrt(np.maximum(root, 0))) / square
    np.testing.assert_allclose(depth[well_inside], exact[well_inside], rtol=1e-3)
    hits = camera.position + exact[..., None] * ways
    cosine = ((hits - centre) / radius) @ light.direction
    level = 255 * (0.2 + 0.7 * np.maximum(cosine, 0))
    # The terminator's kink lies between vertices.
    away = well_inside & (np.abs(cosine) > 0.03)
    assert np.abs(rgb[..., 0].astype(float) - level)[away].max() < 1.0


@pytest.mark.parametrize('elevation', [math.pi / 2, -math.pi / 2])
def test_through_the_platforms_hole_the_background_is_seen(elevation):
    dimensions, light = Dimensions(pole_visible=False), Light(intensity=0.0, ambient=1.0)
    camera = Camera(200, 200, target=(0, 0, 0.15), distance=2.0, elevation=elevation)
    picture = DepthPicture()
    rgb = picture.draw(wave() + [9.0, 0.0, 0.0], camera=camera, light=light,
                       dimensions=dimensions).colour
    u, v = np.meshgrid(*2 * [np.arange(200) - 99.5])
    # The nearer rim at depth 1.85 hides none of the farther one at 2.15, which is the smaller.
    outwards = np.hypot(u, v) / camera.focal
    is_open, is_body = outwards < 0.048 / 2.15, (outwards > 0.052 / 1.85) & (outwards < 0.2)
    assert is_open.sum() > 50
    assert (rgb[is_open] == (180, 240, 240)).all() and np.isinf(picture.frame.depth[is_open]).all()
    assert (rgb[is_body] == (150, 145, 135)).all()
    np.testing.assert_allclose(picture.frame.depth[is_body], 1.85, rtol=1e-5)


@pytest.mark.parametrize('elevation', [0.7, -0.7])
def test_the_platforms_hole_has_a_wall_and_its_light(elevation):
    # So slanted that the other end of the hole hides behind its wall.
    z = 0.3 if elevation > 0 else 0.0
    camera = Camera(200, 200, target=(0, 0, z), distance=2.0, elevation=elevation)
    picture = DepthPicture()
    rgb = picture.draw(wave(), camera=camera, dimensions=Dimensions(pole_visible=False),
                       light=Light(azimuth=-math.pi / 2, elevation=0.1, intensity=0.5,
                                   ambient=0.5)).colour
    # The ray through the hole's middle meets the wall, of radius 0.05, on the far side, y > 0,
    # whose front looks back to where the sun stands.
    assert picture.frame.depth[99:101, 99:101].mean() == pytest.approx(
        2.0 + 0.05 / math.cos(elevation), rel=2e-3)
    assert np.abs(rgb[99:101, 99:101].astype(int) - (150, 145, 135)).max() <= 1
    # The sun stands low over the level face beside the hole, or behind it.
    level = 0.5 + 0.5 * math.sin(0.1) * (elevation > 0)
    assert np.abs(rgb[100, 140] - level * np.array([150, 145, 135])).max() <= 1


def test_a_thin_triangle_is_between_its_corners():
    # 4 to 5.5 m away, and some thousandths of a pixel wide.
    rng = np.random.default_rng(3)
    camera, drawn, picture = Camera(1280, 720), 0, DepthPicture()
    for number in range(200):
        ends = camera.position + rng.uniform([-0.6, 4.0, -0.5], [0.6, 5.5, 0.5], (2, 3))
        third = ends[0] + rng.random() * (ends[1] - ends[0]) + rng.normal(scale=3e-5, size=3)
        flag = np.stack([[ends[0], ends[1]], [third, third]])
        picture.draw(flag, camera=camera, dimensions=NOTHING,
                     style=Style(hidden_surface=('zbuffer', 'painter')[number % 2])).colour
        depths = picture.frame.depth
        depths = depths[np.isfinite(depths)]
        drawn += depths.size
        corners = (flag - camera.position) @ camera.pose[2, :3]
        assert (depths >= (1 - 1e-6) * corners.min()).all()
        assert (depths <= (1 + 1e-6) * corners.max()).all()
    assert drawn > 50
