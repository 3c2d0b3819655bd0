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

"""A scene of any objects, and what pixels show beside their colour."""
import dataclasses
import math

from flag_sim.drawing import (
    body, box_mesh, Camera, Dimensions, flag_scene, interpolate, Light, Materials, Picture,
    sheet, Style, Surface)

import numpy as np

import pytest

from support.flags import wave

CAMERA = Camera(320, 240)
BOX = box_mesh((0.6, -1.2, 7.4), (1.1, -0.8, 7.9))


def stand(camera=CAMERA):
    """Return the source's scene with a second flag and a box before the first one."""
    second = sheet(wave(9, 13) + [0.3, -0.6, -0.2], surface=Surface((20, 60, 200)), label=4)
    return [*flag_scene(wave(), None, camera, Materials(), Dimensions()), second,
            body(BOX, Surface((90, 160, 40)), label=5)]


def labels(objects):
    """Return a label for each triangle of each object."""
    return [np.full((len(one.triangles), 1), one.label) for one in objects]


def test_a_second_flag_and_a_box_are_an_entry_more_each():
    objects = stand()
    frame = Picture().draw_scene(objects, CAMERA, channels=['depth', 'visibility'])
    shown = interpolate(frame.visibility, labels(objects), 'triangles', nothing=0)[..., 0]
    assert set(np.unique(shown)) == {0, 1, 2, 4, 5}
    np.testing.assert_array_equal(shown == 0, np.isinf(frame.depth))
    np.testing.assert_array_equal(frame.visibility.triangles == -1, np.isinf(frame.depth))
    # Each shows no colour but a shade of its own.
    for one in objects:
        colour = frame.colour[shown == one.label].astype(float)
        level = colour / one.surface.color
        assert (np.ptp(level, axis=1) < 1.0 / min(one.surface.color)).all()
    # Without them the picture is that of the flag alone.
    alone = Picture().draw(wave(), camera=CAMERA)
    same = Picture().draw_scene(objects[:3], CAMERA)
    np.testing.assert_array_equal(same.colour, alone.colour)
    box = Picture().draw_scene(objects[-1:], CAMERA, channels=['depth'])
    assert np.nanmin(box.depth) == pytest.approx(
        ((BOX.vertices - CAMERA.position) @ CAMERA.pose[2, :3]).min(), rel=1e-2)


def test_the_order_of_objects_does_not_matter():
    objects = stand()
    frame = Picture().draw_scene(objects, CAMERA, channels=['depth'])
    other = Picture().draw_scene(objects[::-1], CAMERA, channels=['depth'])
    np.testing.assert_array_equal(frame.depth, other.depth)
    assert np.mean(np.any(frame.colour != other.colour, axis=-1)) < 1e-3


def test_one_picture_serves_changing_scenes():
    picture, objects = Picture(), stand()
    for some in (objects, objects[:2], objects[1:], objects[3:], objects):
        frame = picture.draw_scene(some, CAMERA, channels=['visibility'])
        fresh = Picture().draw_scene(some, CAMERA, channels=['visibility'])
        np.testing.assert_array_equal(frame.colour, fresh.colour)
        for array, expected in zip(frame.visibility, fresh.visibility):
            np.testing.assert_array_equal(array, expected)


def test_arrays_that_are_changed_in_place_are_read_again():
    flag, normals = wave(), np.cross(np.gradient(wave(), axis=1), np.gradient(wave(), axis=0))
    picture = Picture()
    picture.draw(flag, normals)
    flag += [0.1, 0.0, 0.0]
    np.testing.assert_array_equal(picture.draw(flag, normals).colour,
                                  Picture().draw(flag.copy(), normals).colour)


def rays(camera):
    """Return the ways through the pixels' centres, of depth 1, in the world: (h, w, 3)."""
    v, u = np.mgrid[:camera.height, :camera.width]
    ways = np.stack([(u - camera.centre[0]) / camera.focal, (v - camera.centre[1]) / camera.focal,
                     np.ones(u.shape)], axis=-1)
    return ways @ camera.pose[:3, :3]


@pytest.mark.parametrize('view', [
    {}, {'azimuth': 1.2, 'elevation': 0.3}, {'target': (1.2, 0.45, 8.2), 'distance': 0.1},
    {'target': (0.2, 0.2, 0.35), 'distance': 0.1, 'azimuth': 0.6, 'vertical_fov': 2.4}])
@pytest.mark.parametrize('hidden_surface', ['zbuffer', 'painter'])
def test_positions_are_where_rays_and_depth_say(view, hidden_surface):
    # The place of what a pixel shows, as an attribute of three channels, linear in space: also
    # where the near plane cuts.
    camera = dataclasses.replace(CAMERA, **view)
    objects = stand(camera)
    frame = Picture().draw_scene(objects, camera, style=Style(hidden_surface=hidden_surface),
                                 channels=['depth', 'visibility'])
    places = interpolate(frame.visibility, [one.vertices for one in objects])
    seen = np.isfinite(frame.depth)
    assert seen.any() and np.isnan(places[~seen]).all()
    expected = camera.position + frame.depth[seen][:, None] * rays(camera)[seen]
    apart = np.linalg.norm(places[seen] - expected, axis=1) / np.maximum(frame.depth[seen], 0.3)
    # Vertices are snapped to 1/256 pixel; a triangle seen along its edge magnifies that.
    assert np.median(apart) < 1e-4
    assert np.mean(apart > 1e-2) < 0.002


def test_orthographic_positions():
    camera = dataclasses.replace(CAMERA, projection='orthographic')
    objects = stand(camera)
    frame = Picture().draw_scene(objects, camera, channels=['depth', 'visibility'])
    places = interpolate(frame.visibility, [one.vertices for one in objects])
    seen = np.isfinite(frame.depth)
    depth = (places[seen] - camera.position) @ camera.pose[2, :3]
    np.testing.assert_allclose(depth, frame.depth[seen], atol=2e-2)
    assert np.median(np.abs(depth - frame.depth[seen])) < 1e-4


@pytest.mark.parametrize('interpolation', ['screen', 'perspective'])
@pytest.mark.parametrize('shading', ['gouraud', 'flat'])
def test_the_colour_is_an_attribute_like_others(interpolation, shading):
    # Carried along the spans for speed, but the same: computed from visibility within a level.
    light = Light()
    objects = [one for one in stand() if not one.is_closed]
    style = Style(interpolation=interpolation, shading=shading)
    frame = Picture().draw_scene(objects, CAMERA, light, style, channels=['visibility'])
    colours = []
    for one in objects:
        corners = one.vertices[one.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        if shading == 'gouraud':
            at = np.zeros_like(one.vertices)
            for corner in range(3):
                np.add.at(at, one.triangles[:, corner], normals)
            normals = at
        cosine = normals @ light.direction / np.linalg.norm(normals, axis=1)
        level = light.ambient + light.intensity * np.maximum([cosine, -cosine], 0.0)
        colours.append(np.minimum(level.T[..., None] * one.surface.color, 255.0))
    shown = interpolate(frame.visibility, colours,
                        'triangles' if shading == 'flat' else 'vertices', interpolation)
    seen = frame.visibility.triangles >= 0
    assert np.abs(shown[seen] - frame.colour[seen]).max() <= 0.51


def test_normals_and_texture_coordinates():
    columns, rows = 31, 21
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    flag = np.stack([0.05 + 2.25 * u, np.zeros_like(u), 8.9 - 1.5 * v], axis=-1)
    objects = [sheet(flag)]
    for azimuth in (-math.pi / 2, math.pi / 2):
        camera = dataclasses.replace(CAMERA, azimuth=azimuth, elevation=0.3)
        frame = Picture().draw_scene(objects, camera, channels=['depth', 'visibility'])
        seen = np.isfinite(frame.depth)
        texture = interpolate(frame.visibility, np.stack([u, v], -1).reshape(-1, 2))[seen]
        place = camera.position + frame.depth[seen][:, None] * rays(camera)[seen]
        np.testing.assert_allclose(texture, np.column_stack(
            [(place[:, 0] - 0.05) / 2.25, (8.9 - place[:, 2]) / 1.5]), atol=2e-3)
        # Towards the camera on both sides: the back's normals are the opposite ones.
        normals = np.tile([0.0, 1.0, 0.0], (rows * columns, 1))
        both = np.stack([normals, -normals], axis=1)
        front = interpolate(frame.visibility, both, nothing=0.0)
        np.testing.assert_array_equal(front[seen], np.broadcast_to(
            [0.0, math.copysign(1.0, camera.position[1]), 0.0], front[seen].shape))
        assert (front[~seen] == 0.0).all()


def test_many_channels_and_constants():
    objects = stand()
    frame = Picture().draw_scene(objects, CAMERA, channels=['visibility'])
    values = [np.broadcast_to(np.arange(7.0), (len(one.vertices), 7)) for one in objects]
    for interpolation in ('screen', 'perspective'):
        shown = interpolate(frame.visibility, values, interpolation=interpolation, nothing=-1.0)
        seen = frame.visibility.triangles >= 0
        np.testing.assert_array_equal(shown[seen], np.broadcast_to(
            np.float32(np.arange(7)), (seen.sum(), 7)))
        assert (shown[~seen] == -1.0).all()


def test_threads_samples_and_outlines_see_the_same():
    objects = stand()
    frame = Picture().draw_scene(objects, CAMERA, channels=['visibility'])
    for threads, style in ((3, Style()), (1, Style(samples=4))):
        other = Picture(threads).draw_scene(objects, CAMERA, style=style, channels=['visibility'])
        for array, expected in zip(other.visibility, frame.visibility):
            np.testing.assert_array_equal(array, expected)
    outlined = Picture().draw_scene(objects, CAMERA, style=Style(outline=True),
                                    channels=['depth', 'visibility'])
    np.testing.assert_array_equal(outlined.visibility.triangles >= 0,
                                  np.isfinite(outlined.depth))


def test_what_stands_still_is_drawn_anew_where_anything_else_changed():
    # The same objects, whose points and colours are kept from frame to frame, and others of the
    # same triangles.
    picture, box = Picture(), body(BOX, Surface((90, 160, 40)))
    moved = dataclasses.replace(box, vertices=box.vertices + 0.1)
    for array in (box.vertices, box.normals, moved.vertices, box.triangles):
        array.flags.writeable = False
    other = dataclasses.replace(box, surface=Surface((10.0, 200.0, 30.0)))
    for look in ({}, {'camera': Camera(120, 90, azimuth=1.0)}, {'light': Light(2.0)}, {},
                 {'style': Style(shading='flat')}, {}):
        for one in (box, other, box, moved, box):
            drawn = picture.draw_scene([one], **{'camera': CAMERA, **look}).colour
            expected = Picture().draw_scene([one], **{'camera': CAMERA, **look}).colour
            np.testing.assert_array_equal(drawn, expected)
