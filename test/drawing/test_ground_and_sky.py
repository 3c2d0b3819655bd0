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

"""The ground and the sky: what pixels see of them by formulas, and that they are kept right."""
import dataclasses

from flag_sim.drawing import (
    Camera, Dimensions, flag_scene, LastFrame, Light, Materials, Picture, Style, Surface, Texture)
from flag_sim.drawing.bands import draw_bands
from flag_sim.drawing.scene import GROUND

import numpy as np

import pytest

from support.flags import wave

SIZE = {'width': 320, 'height': 240}
SKY, GROUNDED = Style(sky_gradient=True), Dimensions(ground_visible=True)
VIEWS = {
    'default': Camera(**SIZE),
    'down': Camera(**SIZE, target=(0.0, 0.0, 0.3), distance=6.0, elevation=0.5),
    'rolled': Camera(**SIZE, roll=0.8, elevation=-0.4, vertical_fov=1.5),
    'straight up': Camera(**SIZE, elevation=-np.pi / 2, vertical_fov=2.0),
    'orthographic': Camera(**SIZE, projection='orthographic', elevation=-0.3, scale=5.0),
}


def ways(camera):
    """Return where pixels look, in the world: (height, width, 3), 1 along the optical axis."""
    v, u = np.mgrid[:camera.height, :camera.width].astype(float)
    x, y = (u - camera.centre[0]) / camera.focal, (v - camera.centre[1]) / camera.focal
    if not camera.is_perspective:
        x, y = 0.0 * x, 0.0 * y
    return np.stack([x, y, np.ones_like(x)], axis=-1) @ camera.pose[:3, :3]


@pytest.mark.parametrize('view', VIEWS)
@pytest.mark.parametrize('samples', [1, 4])
def test_the_sky_is_by_elevation(view, samples):
    camera = VIEWS[view]
    style = dataclasses.replace(SKY, samples=samples, background=(200, 220, 230),
                                sky_zenith=(10, 80, 160))
    frame = Picture().draw(wave(), camera=camera, style=style, channels=['labels', 'depth'])
    way = ways(camera)
    up = np.clip(way[..., 2] / np.linalg.norm(way, axis=-1), 0.0, 1.0)[..., None]
    expected = np.add(style.background, up * (2.0 - up) * np.subtract(style.sky_zenith,
                                                                      style.background))
    nothing = frame.labels == 0
    if samples > 1:  # beside edges, other samples see other things
        for step in np.ndindex(3, 3):
            nothing &= np.roll(frame.labels, np.subtract(step, 1), (0, 1)) == 0
    assert nothing.sum() > 10000 and np.isinf(frame.depth[frame.labels == 0]).all()
    assert np.abs(frame.colour[nothing] - expected[nothing]).max() <= 1.0
    plain = Picture().draw(wave(), camera=camera, style=Style(samples=samples))
    if samples == 1:
        np.testing.assert_array_equal(frame.colour[~nothing], plain.colour[~nothing])


@pytest.mark.parametrize('samples', [1, 4])
def test_they_come_and_go_in_a_picture_that_is_kept(samples):
    looks = [{'style': Style(samples=samples, sky_gradient=sky, shadows=shadows),
              'dimensions': Dimensions(ground_visible=ground), 'camera': camera}
             for sky, ground, shadows, camera in (
                 (True, False, False, Camera(200, 150)), (False, False, False, Camera(200, 150)),
                 (True, True, True, Camera(200, 150, azimuth=1.0)),
                 (False, True, True, Camera(200, 150, elevation=0.3)),
                 (False, False, False, Camera(200, 150)))]
    kept = [Picture(threads) for threads in (1, 2, 3)]
    for look in looks * 2:
        fresh = Picture().draw(wave(), **look).colour
        for one in kept:
            np.testing.assert_array_equal(one.draw(wave(), **look).colour, fresh)


@pytest.mark.parametrize('view', ['default', 'down'])
def test_the_ground_is_level_and_lit(view):
    camera, light = VIEWS[view], Light(elevation=0.6)
    frame = Picture().draw(wave(), camera=camera, light=light, dimensions=GROUNDED,
                           channels=['labels', 'depth', 'normals'])
    seen = frame.labels == GROUND
    slope = ways(camera)[..., 2][seen]
    depth = -camera.position[2] / slope
    near = depth < 900.0
    assert near.sum() > 1000
    np.testing.assert_allclose(frame.depth[seen][near], depth[near], rtol=2e-3)
    # All that looks down is ground, but at its rim, and nothing else is.
    looks_down = (ways(camera)[..., 2] < -camera.position[2] / 900.0) & (frame.labels == 0)
    assert not looks_down.any() and (slope < 0.0).all()
    level = light.ambient + light.intensity * np.sin(light.elevation)
    assert np.abs(frame.colour[seen] - level * np.array(Materials().ground.color)).max() <= 0.51
    np.testing.assert_allclose(frame.normals[seen], [camera.pose[:3, 2]] * seen.sum(), atol=1e-6)


def test_the_ground_moves_by_as_much_as_the_camera_turns():
    before, camera = (Camera(**SIZE, target=(0.0, 0.0, 1.0), distance=8.0, elevation=0.3,
                             azimuth=azimuth) for azimuth in (0.40, 0.42))
    objects = flag_scene(wave(), camera=camera, dimensions=GROUNDED,
                         last=LastFrame(wave(), before, GROUNDED))
    frame = Picture().draw_scene(objects, camera, camera_before=before,
                                 channels=['labels', 'flow', 'texture_coordinates'])
    seen = frame.labels == GROUND
    assert seen.sum() > 1000 and np.isnan(frame.texture_coordinates[seen]).all()
    way = ways(camera)
    depth = np.where(seen, -camera.position[2] / way[..., 2], 1.0)[..., None]
    points = np.append(camera.position + depth * way, np.ones_like(depth), axis=-1)
    then = points @ before.pose.T @ before.P.T
    v, u = np.mgrid[:camera.height, :camera.width]
    flow = then[..., :2] / then[..., 2:] - np.stack([u, v], axis=-1)
    near = seen & (depth[..., 0] < 100.0)
    np.testing.assert_allclose(frame.flow[near], flow[near], atol=0.01)
    still = Picture().draw_scene(objects, camera, channels=['labels', 'flow'])
    assert not still.flow[still.labels == GROUND].any()


def test_shadows_sky_and_pictures_are_of_the_colour_alone():
    channels = ['depth', 'normals', 'labels', 'texture_coordinates', 'flow']
    camera = VIEWS['down']
    image = Texture(np.indices((8, 8, 3)).sum(0).astype(np.uint8) * 10)
    frames = [Picture().draw_scene(
        flag_scene(wave(), None, camera, Materials(flag_image=texture), GROUNDED,
                   LastFrame(wave(), camera, GROUNDED)), camera,
        style=Style(shadows=shadows, sky_gradient=shadows), channels=channels)
        for texture, shadows in ((None, False), (image, True))]
    assert (frames[0].colour != frames[1].colour).any()
    for channel in channels:
        np.testing.assert_array_equal(*(getattr(frame, channel) for frame in frames))


def test_all_looks_are_drawn_with_one_kernel():
    image = Texture(np.zeros((2, 2, 3), np.uint8))
    before = set(draw_bands.signatures)
    for texture, style in ((image, Style()), (None, SKY), (None, Style(shadows=True)),
                           (image, Style(shadows=True, sky_gradient=True))):
        Picture().draw(wave(), materials=Materials(flag_image=texture), style=style)
    shaded = {signature for signature in draw_bands.signatures if 'Surfaces' in str(signature)}
    assert len(shaded) == 1 and len(set(draw_bands.signatures) - before) <= 2


def test_the_ground_is_not_seen_from_below_nor_unless_it_is_asked_for():
    below = Camera(**SIZE, target=(0.0, 0.0, -2.0), distance=3.0, elevation=-0.8)
    for camera, dimensions in ((below, GROUNDED), (VIEWS['default'], Dimensions())):
        frame = Picture().draw(wave(), camera=camera, dimensions=dimensions, channels=['labels'])
        assert GROUND not in frame.labels


def test_the_poles_shadow_lies_on_the_ground_where_the_sun_puts_it():
    camera = Camera(640, 480, target=(-2.0, 4.0, 0.0), distance=30.0, elevation=1.2)
    light = Light(azimuth=-1.0, elevation=0.7)
    frame = Picture().draw(wave(), camera=camera, light=light, dimensions=GROUNDED,
                           style=Style(shadows=True), channels=['labels'],
                           materials=Materials(ground=Surface((200, 200, 200))))
    to_sun = np.array(light.direction)

    def level(x, y):
        image = camera.P @ camera.pose @ [x, y, 0.0, 1.0]
        u, v = np.rint(image[:2] / image[2]).astype(int)
        assert frame.labels[v, u] == GROUND
        return int(frame.colour[v, u, 0])
    dark, lit = round(200 * light.ambient), round(200 * (light.ambient + 0.8 * to_sun[2]))
    across = np.array([-to_sun[1], to_sun[0]]) / np.hypot(*to_sun[:2])
    for height in (1.0, 2.5, 4.0):
        foot = -height * to_sun[:2] / to_sun[2]
        assert level(*foot) <= dark + 60  # narrower than the soft edges are wide
        for side in (-0.3, 0.3):
            assert abs(level(*(foot + side * across)) - lit) <= 1
    # That of the flag's middle is all dark.
    middle = wave()[10, 15]
    assert abs(level(*(middle[:2] - middle[2] * to_sun[:2] / to_sun[2])) - dark) <= 1


def test_odd_colours_are_refused():
    with pytest.raises(ValueError, match='sky_zenith must be'):
        Style(sky_zenith=(0.2, 0.4, 0.8))
    with pytest.raises(ValueError, match='ground must be'):
        Materials(ground=(1, 2, 3))
