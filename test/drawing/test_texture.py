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

"""Textures: by hand, from both sides, with samples and threads, and what is refused."""
import dataclasses

from flag_sim.drawing import (
    Camera, Dimensions, flag_scene, interpolate, Light, Materials, Object, Picture, sheet, Style,
    Surface, Texture)
from flag_sim.drawing.shading import light_levels
from flag_sim.drawing.texture import DECODE, ENCODE, halved, LARGEST

import numpy as np

import pytest

from support.flags import wave

SIZE = {'width': 320, 'height': 240}
VIEWS = {
    'default': Camera(**SIZE),
    'behind': Camera(**SIZE, azimuth=1.2, elevation=0.3, distance=7.0),
    'far': Camera(**SIZE, distance=25.0),
    'near': Camera(**SIZE, target=(1.5, 0.4, 8.1), distance=0.7, roll=0.5),
    'along the cloth': Camera(**SIZE, azimuth=0.2, distance=6.0),
    'within the cloth': Camera(**SIZE, target=(1.2, 0.45, 8.2), distance=0.0, azimuth=0.4,
                               elevation=0.2, vertical_fov=2.0),
    'orthographic': Camera(**SIZE, projection='orthographic', azimuth=-1.2, elevation=0.3),
}
STYLES = {
    'plain': Style(), 'perspective': Style(interpolation='perspective'),
    'flat': Style(shading='flat'), 'painter': Style(hidden_surface='painter'),
    'samples': Style(samples=4)}
SHINY = Surface((205, 35, 40), transmission=0.3, specular=0.2)


def picture(height=150, width=237, seed=1):
    """Return a picture of blots, large and small, whose sides are no powers of two."""
    rng, image = np.random.default_rng(seed), np.zeros((height, width, 3))
    for cells in (3, 17, 60):
        blots = rng.uniform(0.0, 255.0 / 3.0, (cells, cells, 3))
        v, u = np.mgrid[:height, :width]
        image += blots[v * cells // height, u * cells // width]
    return image.astype(np.uint8)


def decoded(image):
    """Return the linear light of sRGB bytes (IEC 61966-2-1)."""
    x = image / 255.0
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def encoded(linear):
    """Return sRGB, from 0 to 255, of linear light."""
    return 255.0 * np.where(linear <= 0.0031308, 12.92 * linear,
                            1.055 * np.maximum(linear, 1e-9) ** (1.0 / 2.4) - 0.055)


def by_area(linear, axis):
    """Return an image with half as many pixels along an axis: the average of what each covers."""
    values = np.moveaxis(linear, axis, 0)
    count = len(values)
    borders = np.linspace(0.0, count, max(1, count // 2) + 1)
    shares = [np.clip(np.minimum(np.arange(count) + 1, end) - np.maximum(np.arange(count), begin),
                      0.0, None) / (end - begin) for begin, end in zip(borders, borders[1:])]
    return np.moveaxis(np.tensordot(shares, values, axes=1), 0, axis)


def bilinear(linear, u, v):
    """Return what is between the four texels about (u, v), from 0 to 1."""
    height, width = linear.shape[:2]
    x, y = u * width - 0.5, v * height - 0.5
    left, upper = np.floor(x).astype(int), np.floor(y).astype(int)
    right, down = (x - left)[:, None], (y - upper)[:, None]

    def texel(row, column):
        return linear[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
    return ((1 - down) * ((1 - right) * texel(upper, left) + right * texel(upper, left + 1))
            + down * ((1 - right) * texel(upper + 1, left) + right * texel(upper + 1, left + 1)))


def by_hand(image, camera, style):
    """Return what pixels of the flag show, from what they see: (mask, colours)."""
    objects = flag_scene(wave(), None, camera, Materials(flag=SHINY))
    frame = Picture().draw_scene(objects, camera, channels=['visibility', 'labels'])
    seen, flag = frame.visibility, objects[0]
    mask = frame.labels == 1
    row, column = np.nonzero(mask)
    corners = seen.corners[seen.triangles[mask]]
    points = flag.vertices @ camera.pose[:3, :3].T + camera.pose[:3, 3]
    places = flag.texture_coordinates[corners]

    def at(du, dv):
        """Return texture coordinates beside the pixels' centres, on the triangles' planes."""
        x = (column + du - camera.centre[0]) / camera.focal
        y = (row + dv - camera.centre[1]) / camera.focal
        ones = np.ones_like(x)
        if camera.is_perspective:
            solved = np.linalg.solve(np.moveaxis(points[corners], 1, 2),
                                     np.stack([x, y, ones], axis=1)[..., None])[..., 0]
            weights = solved / solved.sum(axis=1, keepdims=True)
        else:
            flat = points[corners].copy()
            flat[..., 2] = 1.0
            weights = np.linalg.solve(np.moveaxis(flat, 1, 2),
                                      np.stack([x, y, ones], axis=1)[..., None])[..., 0]
        return np.einsum('ni,nij->nj', weights, places)
    size, step = np.array(image.shape[1::-1]), 1e-4
    changes = [(at(*way) - at(0.0, 0.0)) / step * size for way in ((step, 0), (0, step))]
    widest = np.maximum(*(np.hypot(*change.T) for change in changes))
    mipmaps = [decoded(image)]
    while max(mipmaps[-1].shape[:2]) > 1:
        mipmaps.append(by_area(by_area(mipmaps[-1], 0), 1))
    lod = np.clip(np.log2(np.maximum(widest, 1e-9)), 0.0, len(mipmaps) - 1)
    exact = interpolate(seen, [flag.texture_coordinates] + [
        np.zeros((len(one.vertices), 2)) for one in objects[1:]])[mask]
    levels = np.array([bilinear(mipmap, *exact.astype(float).T) for mipmap in mipmaps])
    level = np.minimum(lod.astype(int), len(mipmaps) - 2)
    share, pixel = (lod - level)[:, None], np.arange(len(row))
    linear = (1 - share) * levels[level, pixel] + share * levels[level + 1, pixel]
    sun, mirrored = np.empty((2, len(flag.vertices), 2, 3))
    light_levels(flag.vertices, normals_of(flag), camera.viewpoint, SHINY, Light(),
                 (sun, mirrored))
    rest = [np.zeros((len(one.vertices), 2, 1)) for one in objects[1:]]
    light, added = (interpolate(seen, [part[..., :1], *rest], interpolation=style.interpolation)[
        mask] for part in (sun, mirrored))
    return mask, np.minimum(encoded(linear) * (Light().ambient + light) + added, 255.0)


def normals_of(one):
    """Return normals averaged at vertices (eq. 1.13)."""
    a, b, c = np.moveaxis(one.vertices[one.triangles], 1, 0)
    normals = np.zeros_like(one.vertices)
    np.add.at(normals, one.triangles.ravel(), np.repeat(np.cross(b - a, c - a), 3, axis=0))
    return normals


@pytest.mark.parametrize('view', VIEWS)
@pytest.mark.parametrize('style', ['plain', 'perspective'])
def test_pixels_show_what_a_plain_reference_shows(view, style):
    camera, style, image = VIEWS[view], STYLES[style], picture()
    mask, expected = by_hand(image, camera, style)
    frame = Picture().draw(wave(), camera=camera, style=style,
                           materials=Materials(flag=SHINY, flag_image=Texture(image)))
    apart = np.abs(frame.colour[mask] - expected)
    assert mask.sum() > 500 and apart.mean() < 0.3  # half a level is the mean of rounding
    # Snapped to 1/256 pixel, narrow triangles change: texels there are half a pixel off.
    assert np.mean(apart.max(axis=1) > 1.0) < 0.003
    assert np.quantile(apart, 0.9999) < 8.0


# Where the near plane cuts triangles, what is linear on the screen is a matter of opinion.
@pytest.mark.parametrize('view, style', [
    *((view, style) for view in ('default', 'near', 'far', 'orthographic') for style in STYLES),
    ('within the cloth', 'perspective')])
def test_a_texture_of_one_colour_is_that_colour(view, style):
    look = {'camera': VIEWS[view], 'style': STYLES[style]}
    for colour in ((205, 35, 40), (10, 200, 3)):
        surface = dataclasses.replace(SHINY, color=colour)
        image = np.full((5, 8, 3), colour, np.uint8)
        plain = Picture().draw(wave(), materials=Materials(flag=surface), **look).colour
        shown = Picture().draw(wave(), materials=Materials(
            flag=surface, flag_image=Texture(image)), **look).colour
        apart = np.abs(shown.astype(int) - plain)
        assert apart.max() <= 1 and np.mean(apart > 0) < 0.001


def test_outlines_are_darker_on_a_texture_too():
    camera, surface = VIEWS['near'], Surface((100, 150, 200))
    image = np.full((5, 8, 3), surface.color, np.uint8)
    plain, shown = (Picture().draw(
        wave(), camera=camera, style=Style(outline=True), channels=['visibility'],
        materials=Materials(flag=surface, flag_image=texture))
        for texture in (None, Texture(image)))
    assert np.abs(shown.colour.astype(int) - plain.colour).max() <= 3
    assert shown.visibility.triangles.max() < len(shown.visibility.corners)


def test_the_back_shows_the_picture_mirrored():
    """Red at the hoist and blue at the fly, green above; whichever side is seen."""
    image = np.zeros((40, 60, 3), np.uint8)
    image[:, :20, 0] = image[:, 40:, 2] = 255
    image[:10, :, 1] = 255
    dimensions = Dimensions(pole_visible=False, platform_visible=False)
    shown = []
    for azimuth in (-np.pi / 2, np.pi / 2):
        frame = Picture().draw(
            wave(), camera=Camera(**SIZE, azimuth=azimuth), dimensions=dimensions,
            light=Light(intensity=0.0, ambient=1.0), channels=['labels'],
            materials=Materials(flag_image=Texture(image)))
        rows, columns = np.nonzero(frame.labels)
        left, right = columns.min() + 8, columns.max() - 8
        middle = int(np.median(rows[columns == columns.max() - 8]))
        shown.append((frame.colour[middle, left].argmax(), frame.colour[middle, right].argmax()))
        assert (frame.colour[rows.min() + 2, columns[rows == rows.min() + 2]][:, 1] > 250).all()
    assert shown == [(0, 2), (2, 0)]


def test_light_shines_through_a_texture():
    camera, image = VIEWS['behind'], Texture(picture())
    shut, thin = (Picture().draw(wave(), camera=camera, materials=Materials(
        flag=Surface(transmission=share), flag_image=image)).colour.astype(int)
        for share in (0.0, 0.5))
    assert (thin >= shut).all() and (thin - shut).max() > 20


def test_mipmaps_keep_the_light():
    """Of black and white in equal parts, which is 188 and not 128."""
    v, u = np.mgrid[:37, :50]
    image = np.repeat(np.uint8(255 * ((u + v) % 2))[..., None], 3, axis=2)
    texture = Texture(image)
    start, width, height = texture.levels[-1]
    assert (width, height) == (1, 1)
    assert texture.texels[4 * start] == pytest.approx(0.5, abs=1e-3)
    frame = Picture().draw(
        wave(), camera=VIEWS['far'], light=Light(intensity=0.0, ambient=1.0),
        materials=Materials(flag_image=Texture(np.tile(image, (8, 8, 1)))), channels=['labels'])
    assert np.abs(frame.colour[frame.labels == 1].astype(int) - 188).max() <= 2
    for axis, count in ((0, 2), (0, 37), (1, 50), (1, 3)):
        linear = np.random.default_rng(count).random((37, count, 3) if axis else (count, 9, 3))
        np.testing.assert_allclose(halved(linear.astype(np.float32), axis),
                                   by_area(linear, axis), atol=1e-6)


def test_each_level_is_decoded_and_encoded_to_itself():
    levels = np.arange(256)
    np.testing.assert_allclose(encoded(DECODE.astype(float)), levels, atol=0.05)
    entries = np.rint(np.sqrt(DECODE.astype(float)) * (len(ENCODE) - 1)).astype(int)
    np.testing.assert_array_equal(ENCODE[entries], levels)
    np.testing.assert_allclose(ENCODE, encoded((np.arange(len(ENCODE)) / (len(ENCODE) - 1)) ** 2),
                               atol=0.05)
    assert (np.diff(ENCODE) > 0.0).all()


def test_samples_smooth_edges_of_a_textured_flag():
    """Where pixels see the flag's edge, against the same at eight times the size, averaged."""
    texture = Texture(picture())

    def drawn(scale, samples):
        camera = Camera(160 * scale, 120 * scale)
        return Picture().draw(wave(), camera=camera, style=Style(samples=samples),
                              materials=Materials(flag_image=texture), channels=['labels'])

    def blocks(image):
        return image.reshape(120, 8, 160, 8, -1)
    frame = drawn(8, 1)
    fine, labels = blocks(frame.colour).mean(axis=(1, 3)), blocks(frame.labels)[..., 0]
    at_edge = (labels == 1).any(axis=(1, 3)) & (labels == 0).any(axis=(1, 3))
    error = [np.sqrt(np.mean((drawn(1, samples).colour - fine)[at_edge] ** 2))
             for samples in (1, 4, 16)]
    assert at_edge.sum() > 100
    assert error[1] < 0.5 * error[0] and error[2] < 0.8 * error[1]


@pytest.mark.parametrize('style', STYLES)
def test_the_same_to_the_bit_whatever_was_drawn_before_and_by_how_many(style):
    looks = [{'materials': Materials(flag_image=image), 'camera': Camera(200, 150, azimuth=turn)}
             for image, turn in ((Texture(picture()), -1.5), (None, -1.2),
                                 (Texture(picture(64, 64, 2)), 1.5), (None, 1.4))]
    one, others = Picture(), [Picture(threads) for threads in (2, 3)]
    for look in looks * 2:
        look = {**look, 'style': STYLES[style]}
        fresh = Picture().draw(wave(), **look).colour
        for kept in (one, *others):
            np.testing.assert_array_equal(kept.draw(wave(), **look).colour, fresh)


def test_several_textures_and_coordinates_beyond_the_edge():
    """Each object has its own; beyond an edge, and where there is no number, nothing breaks."""
    first, second = (Texture(np.full((3, 3, 3), level, np.uint8)) for level in (60, 200))
    flag = sheet(wave(), texture=first, label=1)
    odd = np.array(flag.texture_coordinates)
    odd[::7], odd[3::7], odd[5::7] = np.nan, 1e30, -np.inf
    other = Object(wave().reshape(-1, 3) + [0.0, 0.8, 0.4], flag.triangles, label=2,
                   texture_coordinates=odd, texture=second)
    plain = sheet(wave() + [0.0, 1.6, 0.8], label=3, surface=Surface((120, 120, 120)))
    frame = Picture().draw_scene([flag, other, plain], light=Light(intensity=0.0, ambient=1.0),
                                 channels=['labels'])
    for label, level in ((1, 60), (2, 200), (3, 120), (0, None)):
        shown = frame.colour[frame.labels == label]
        assert len(shown) > 1000 and (level is None or (shown == level).all())


def test_light_beyond_its_range_is_cut_off():
    odd = np.zeros((4, 6, 3))
    odd[0], odd[1], odd[2], odd[3] = np.nan, -5.0, 7.0, np.inf
    texture = Texture.of_light(odd)
    assert texture.texels.min() == 0.0 and texture.texels.max() == 1.0
    Picture().draw(wave(), camera=VIEWS['near'], materials=Materials(flag_image=texture))


def test_what_is_no_texture_is_refused():
    for image in (np.zeros((3, 3), np.uint8), np.zeros((3, 3, 4), np.uint8), np.zeros((3, 3, 3)),
                  np.zeros((0, 3, 3), np.uint8), np.zeros((1, LARGEST + 1, 3), np.uint8)):
        with pytest.raises(ValueError, match='^image must be'):
            Texture(image)
    texture = Texture(np.zeros((1, 1, 3), np.uint8))
    with pytest.raises(ValueError, match='texture_coordinates must be given'):
        Object(np.zeros((3, 3)), np.array([[0, 1, 2]]), texture=texture)
    with pytest.raises(ValueError, match='texture'):
        sheet(wave(), texture=picture())
    with pytest.raises(ValueError, match='flag_image'):
        Materials(flag_image='flag.png')
