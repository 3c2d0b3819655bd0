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

"""Shadows against rays to the sun, and against what a shadow must and must not do."""
import dataclasses

from flag_sim.drawing import (
    body, box_mesh, Camera, Dimensions, flag_scene, interpolate, Light, Materials, Picture, Style,
    Surface, Texture)
from flag_sim.drawing.shadows import LARGEST, sun_view

import numpy as np

import pytest

from support.flags import wave

SIZE = {'width': 640, 'height': 480}
SHADOWS = Style(shadows=True)
WHITE = Materials(Surface(transmission=0.3), Surface(), Surface())
VIEWS = {
    'default': (Camera(**SIZE), Light(azimuth=-1.9, elevation=0.5)),
    'from above': (Camera(**SIZE, elevation=0.6, distance=7.0),
                   Light(azimuth=-1.2, elevation=1.2)),
    'behind': (Camera(**SIZE, azimuth=1.2, elevation=0.3, distance=7.0), Light(azimuth=-2.7)),
    'platform': (Camera(**SIZE, target=(0.2, 0.0, 0.2), distance=3.0, elevation=0.5),
                 Light(azimuth=-0.8, elevation=0.9)),
    'along the cloth': (Camera(**SIZE, azimuth=0.3, distance=5.0),
                        Light(azimuth=2.9, elevation=0.2)),
    'orthographic': (Camera(**SIZE, projection='orthographic', azimuth=-1.2, elevation=0.3),
                     Light(azimuth=-2.8, elevation=0.4)),
}


def scene(camera):
    """Return the source's scene, with what stands in the light of its flag and platform."""
    posts = [body(box_mesh(low, high), Surface(), label) for label, low, high in (
        (4, (0.5, -1.6, 7.2), (0.6, -1.5, 9.0)), (5, (0.3, -0.45, 0.3), (0.4, -0.35, 0.7)))]
    return [*flag_scene(wave(41, 61), None, camera, WHITE), *posts]


def drawn(objects, camera, light, style=SHADOWS, **more):
    return Picture().draw_scene(objects, camera, light, style, **more)


def share_of_light(objects, camera, light):
    """Return the share of the sun that pixels show, and where it can be told."""
    def levels(light, style):
        return drawn(objects, camera, light, style).colour.sum(axis=2).astype(float)
    dark = levels(dataclasses.replace(light, intensity=0.0), Style())
    full, shown = levels(light, Style()), levels(light, SHADOWS)
    known = full - dark > 30.0  # ten levels
    return np.where(known, (shown - dark) / np.maximum(full - dark, 1.0), 1.0), known


def seen_by_the_sun(objects, camera, light):
    """Return where rays from what pixels see reach the sun, and how far from grazing it."""
    scenes = pytest.importorskip('embreex.rtcore_scene', reason='embreex is not installed')
    from embreex.mesh_construction import TriangleMesh
    seen = drawn(objects, camera, light, channels=['visibility']).visibility
    points = np.concatenate([one.vertices for one in objects])
    middle = points.mean(axis=0)
    places = interpolate(seen, [one.vertices - middle for one in objects], nothing=0.0)
    embree = scenes.EmbreeScene()
    TriangleMesh(embree, (points - middle)[seen.corners].astype(np.float32))
    ways = np.tile(np.float32(light.direction), (places.shape[0] * places.shape[1], 1))
    # So far from the surface that single precision does not meet it again.
    begins = places.reshape(-1, 3) + np.float32(1e-3) * ways
    hits = embree.run(np.ascontiguousarray(begins, np.float32), ways)
    a, b, c = np.moveaxis(points[seen.corners[seen.triangles]], 2, 0)
    normals = np.cross(b - a, c - a)
    with np.errstate(invalid='ignore'):
        steep = np.abs(normals @ light.direction) / np.linalg.norm(normals, axis=2)
    return (hits < 0).reshape(places.shape[:2]), np.where(seen.triangles >= 0, steep, 0.0)


def near_edge(lit):
    """Return the pixels within one of the edge of a shadow."""
    edge = np.zeros_like(lit)
    across, down = lit[:, 1:] != lit[:, :-1], lit[1:] != lit[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    wide = edge.copy()
    for axis in (0, 1):
        for step in (1, -1):
            wide |= np.roll(edge, step, axis)
    return wide


@pytest.mark.parametrize('view', VIEWS)
def test_shadows_are_where_rays_do_not_reach_the_sun(view):
    camera, light = VIEWS[view]
    objects = scene(camera)
    share, known = share_of_light(objects, camera, light)
    lit, cosines = seen_by_the_sun(objects, camera, light)
    differs = ((share > 0.5) != lit) & known & (cosines > 0.0)
    # Where the sun grazes a triangle, a texel of the map is many pixels long on it.
    met = known & (cosines > 0.2)
    assert met.sum() > 3000 and (~lit & met).sum() > 200
    assert differs.sum() <= 0.012 * known.sum()
    assert (differs & met).sum() <= 0.005 * met.sum()
    assert (differs & met & ~near_edge(lit)).sum() <= 2e-5 * met.sum()


def test_what_is_lit_looks_as_without_shadows():
    """A cloth that faces the sun, alone: it does not shade itself, nor is it any darker."""
    alone = Dimensions(pole_visible=False, platform_visible=False)
    camera, light = Camera(**SIZE, distance=7.0), Light(azimuth=-1.6, elevation=0.3)
    x, z = np.meshgrid(np.linspace(0.0, 2.25, 31), np.linspace(8.9, 7.4, 21))
    for bend in (0.0, 0.05, 0.1):
        flag = np.stack([x, bend * np.sin(3.0 * x + z), z], axis=-1)
        for azimuth in (-1.5, 1.5):  # both sides
            plain, shown = (Picture().draw(
                flag, camera=dataclasses.replace(camera, azimuth=azimuth), light=light,
                materials=WHITE, dimensions=alone, style=Style(shadows=shadows),
                channels=['labels'])
                for shadows in (False, True))
            on_flag = plain.labels == 1
            apart = np.abs(shown.colour.astype(int) - plain.colour)[on_flag]
            assert on_flag.sum() > 10000 and apart.max() <= 1 and np.mean(apart > 0) < 1e-3


@pytest.mark.parametrize('light', [
    Light(elevation=-0.1), Light(intensity=0.0), Light(intensity=0.0, ambient=0.0)])
def test_without_the_sun_there_are_no_shadows(light):
    plain, shown = (Picture().draw(wave(), light=light, style=Style(shadows=shadows)).colour
                    for shadows in (False, True))
    np.testing.assert_array_equal(shown, plain)


def test_edges_are_soft():
    """From light to shadow there are levels between, over three texels or so."""
    ground = body(box_mesh((-2.0, -2.0, -0.1), (2.0, 2.0, 0.0)), Surface((255, 255, 255)), 1)
    block = body(box_mesh((-0.5, -0.5, 0.0), (0.5, 0.5, 1.0)), Surface((255, 0, 0)), 2)
    camera = Camera(400, 400, 'orthographic', scale=4.0, target=(0.0, 0.0, 0.0), distance=5.0,
                    elevation=np.pi / 2)
    light = Light(azimuth=0.0, elevation=np.pi / 4, intensity=0.8, ambient=0.2)
    shown = drawn([ground, block], camera, light).colour[200, :, 1].astype(int)
    row = shown[np.flatnonzero(drawn([ground, block], camera, light,
                                     channels=['labels']).labels[200] == 1)]
    lit, dark = row.max(), row.min()
    assert (lit, dark) == (round(255 * (0.2 + 0.8 * np.sin(np.pi / 4))), 51)
    between = (row > dark + 5) & (row < lit - 5)
    first = np.flatnonzero(between)[0]
    assert 2 <= between[first:first + 20].sum() <= 5


@pytest.mark.parametrize('style', [
    {}, {'samples': 4}, {'shading': 'flat'}, {'interpolation': 'perspective'},
    {'hidden_surface': 'painter'}, {'outline': True}])
def test_the_same_to_the_bit_by_any_number_of_threads(style):
    texture = Texture(np.random.default_rng(1).integers(0, 256, (40, 60, 3), np.uint8))
    pictures = [Picture(threads) for threads in (1, 2, 3)]
    for phase, image in enumerate((None, texture, None)):
        shown = [one.draw(wave(phase=phase), camera=Camera(200, 150),
                          light=Light(azimuth=-2.7, elevation=0.4 + 0.1 * phase),
                          materials=Materials(flag_image=image),
                          style=Style(shadows=phase != 1, **style)).colour.copy()
                 for one in (*pictures, Picture())]
        for other in shown[1:]:
            np.testing.assert_array_equal(other, shown[0])


@pytest.mark.parametrize('elevation', [-np.pi / 2, 0.0, 0.3, np.pi / 2])
def test_odd_scenes_have_shadows_or_none_but_no_error(elevation):
    light = Light(elevation=abs(elevation))
    odd = wave()
    odd[3, 4], odd[5, 6], odd[0, 0] = np.nan, 1e9, -np.inf
    for flag in (odd, np.full((2, 2, 3), np.nan), wave() * 1e4, wave() * 0.0):
        for camera in (Camera(64, 48, elevation=elevation), Camera(64, 48, distance=0.0),
                       Camera(64, 48, target=(9.0, 900.0, 0.0))):
            Picture().draw(flag, camera=camera, light=light, style=SHADOWS)


def test_the_map_is_as_fine_as_the_picture_and_no_larger_than_it_may_be():
    points = np.concatenate([one.vertices for one in scene(Camera(**SIZE))])
    for width, height in ((320, 240), (1280, 720), (7680, 4320)):
        camera = Camera(width, height)
        sun = sun_view(points, np.full(len(points), True), camera, Light())
        assert max(sun.width, sun.height) <= LARGEST
        if width < 2000:
            assert sun.focal >= camera.pixels_per_metre(5.0)
    # Texels stay where they are while the flag moves.
    moved = [np.concatenate([points, [[2.5 + shift, 0.2, 8.0]]]) for shift in (0.0, 0.4)]
    first, second = (sun_view(now, np.full(len(now), True), Camera(**SIZE), Light())
                     for now in moved)
    offset = first.transform.matrix[:2, 3] - second.transform.matrix[:2, 3]
    assert first.focal == second.focal and np.any(offset != 0.0)
    np.testing.assert_array_equal(offset, np.rint(offset))
