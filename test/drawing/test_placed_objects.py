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

"""A pole that stands elsewhere or leans, and boxes: in the picture and in all its channels."""
import dataclasses
import math

from flag_sim.drawing import (
    Box, Camera, Dimensions, flag_scene, LastFrame, Light, Picture, Style, Surface)
from flag_sim.drawing.scene import BOXES, PLATFORM, POLE
from flag_sim.drawing.transforms import apply

import numpy as np

import pytest

from support.flags import wave

SIZE = {'width': 320, 'height': 240}
LEANING = Dimensions(pole_position=(2.0, -1.0, 0.5), pole_yaw=0.8, pole_tilt=0.3)
BEFORE = Dimensions(pole_position=(1.9, -1.1, 0.5), pole_yaw=0.7, pole_tilt=0.25)
CRATES = (Box((1.0, 0.6, 0.5), (3.0, 0.0, 0.0), 0.4, Surface((200, 120, 40))),
          Box((0.4, 2.0, 1.5), (-2.0, 1.0, 0.2)))
VIEW = Camera(**SIZE, target=(1.5, 0.0, 1.0), distance=9.0, azimuth=-1.2, elevation=0.3)


def on_its_pole(dimensions):
    """Return the nodes of a flag that hangs from the pole."""
    return apply(dimensions.place.pose, wave())


def test_a_scene_that_is_turned_with_its_camera_is_the_same_picture():
    """Flag, pole, platform, sun and shadows; corners are snapped to 1/256 pixel."""
    turned = dataclasses.replace(LEANING, pole_position=(30.0, -20.0, 0.0), pole_tilt=0.0)
    camera, light = Camera(**SIZE, target=(0.5, 0.0, 6.5), distance=12.0), Light(azimuth=-1.0)
    target = tuple(apply(turned.place.pose, np.array(camera.target)))
    look = {'style': Style(shadows=True), 'channels': ('labels', 'depth')}
    here = Picture().draw(wave(), camera=camera, light=light, **look)
    there = Picture().draw(
        on_its_pole(turned), dimensions=turned, light=Light(azimuth=-1.0 + 0.8),
        camera=dataclasses.replace(camera, target=target, azimuth=camera.azimuth + 0.8), **look)
    same = here.labels == there.labels
    assert same.mean() > 0.999
    assert np.median(np.abs(here.depth[same & (here.labels > 0)]
                            - there.depth[same & (here.labels > 0)])) < 1e-4
    close = np.abs(here.colour.astype(int) - there.colour).max(axis=-1) <= 2
    assert close.mean() > 0.995


def test_a_pole_that_leans_is_where_its_maps_say():
    """Tilted towards its own x, then turned from x to y, then shifted: by hand."""
    objects = {one.label: one for one in flag_scene(on_its_pole(LEANING), dimensions=LEANING)}
    lean = np.array([math.sin(0.3) * math.cos(0.8), math.sin(0.3) * math.sin(0.8),
                     math.cos(0.3)])
    top = np.array(LEANING.pole_position) + (9.0 + 0.1) * lean
    assert np.linalg.norm(objects[POLE].vertices - top, axis=-1).min() < 1e-9
    along = (objects[PLATFORM].vertices - LEANING.pole_position) @ lean
    np.testing.assert_allclose([along.min(), along.max()], [0.0, 0.3], atol=1e-12)
    np.testing.assert_allclose(np.unique(np.round(objects[PLATFORM].normals @ lean, 9)),
                               [-1.0, 0.0, 1.0], atol=1e-9)


@pytest.mark.parametrize('yaw', [0.0, 0.5])
def test_boxes_are_seen_from_above_as_large_as_they_are(yaw):
    """And each has its own label, from 5 on in their order, its colour and its depth."""
    boxes = (Box((1.0, 2.0, 0.5), (3.0, 1.0, 0.0), yaw, Surface((10, 200, 30))),
             Box((0.5, 0.5, 2.0), (2.0, -1.0, 1.0)))
    camera = Camera(**SIZE, projection='orthographic', scale=6.0, target=(2.5, 0.0, 0.0),
                    distance=20.0, elevation=math.pi / 2)
    frame = Picture().draw(wave(), camera=camera, channels=('labels', 'depth', 'normals'),
                           dimensions=Dimensions(pole_visible=False, platform_visible=False,
                                                 boxes=boxes))
    pixel = (6.0 / 240) ** 2
    for number, box in enumerate(boxes):
        seen = frame.labels == BOXES + number
        length, width, height = box.size
        assert seen.sum() * pixel == pytest.approx(length * width, rel=0.03)
        np.testing.assert_allclose(frame.depth[seen], 20.0 - box.position[2] - height, atol=1e-4)
        np.testing.assert_allclose(frame.normals[seen], [[0.0, 0.0, -1.0]] * seen.sum(), atol=1e-6)
    red, green, blue = frame.colour[frame.labels == BOXES][0].astype(int)
    assert green > 5 * red and green > 5 * blue


def test_flow_is_that_of_the_pole_that_moves():
    """What depth and the poses of pole and camera say of each pixel; a box goes its own way."""
    now = dataclasses.replace(LEANING, boxes=CRATES)
    gone = (dataclasses.replace(CRATES[0], position=(2.9, 0.1, 0.0), yaw=0.35), CRATES[1])
    before = dataclasses.replace(BEFORE, boxes=gone)
    seen_before = dataclasses.replace(VIEW, azimuth=-1.21)
    objects = flag_scene(on_its_pole(now), camera=VIEW, dimensions=now,
                         last=LastFrame(on_its_pole(before), seen_before, before))
    frame = Picture().draw_scene(objects, VIEW, channels=('labels', 'depth', 'flow'),
                                 camera_before=seen_before)
    places = {POLE: (now.place, before.place), PLATFORM: (now.place, before.place),
              BOXES: (CRATES[0].place, gone[0].place),
              BOXES + 1: (CRATES[1].place, gone[1].place)}
    for label, (here, there) in places.items():
        v, u = np.nonzero(frame.labels == label)
        assert len(u) > 100
        depth = frame.depth[v, u][:, None]
        optical = np.column_stack([(u - VIEW.centre[0]) / VIEW.focal,
                                   (v - VIEW.centre[1]) / VIEW.focal, np.ones(len(u))]) * depth
        world = apply(np.linalg.inv(VIEW.pose), optical)
        last = apply(seen_before.pose @ there.pose @ np.linalg.inv(here.pose), world)
        expected = VIEW.focal * last[:, :2] / last[:, 2:] + VIEW.centre - np.column_stack([u, v])
        error = np.abs(frame.flow[v, u] - expected).max(axis=-1)
        assert np.median(error) < 0.01 and np.quantile(error, 0.99) < 0.05
        assert np.abs(expected).max() > 0.5


def test_what_stands_still_elsewhere_does_not_flow():
    look = dataclasses.replace(LEANING, boxes=CRATES)
    for dimensions in (look, dataclasses.replace(look, boxes=CRATES[:1])):
        objects = flag_scene(on_its_pole(look), camera=VIEW, dimensions=look,
                             last=LastFrame(on_its_pole(look), VIEW, dimensions))
        frame = Picture().draw_scene(objects, VIEW, channels=('labels', 'flow'))
        known = (frame.labels > 0) & ~(np.isin(frame.labels, BOXES + 1)
                                       & (len(dimensions.boxes) < 2))
        assert known.sum() > 3000
        assert not frame.flow[known].any()
        assert np.isnan(frame.flow[(frame.labels > 0) & ~known]).all()


@pytest.mark.parametrize('options, words', [
    ({'size': (1.0, 0.0, 1.0)}, 'size must be between 0.001 and 1000, not 0'),
    ({'size': (1.0, 1.0)}, 'size must have shape'), ({'position': (math.nan, 0.0, 0.0)}, 'finite'),
    ({'yaw': 'north'}, 'yaw must be a number'), ({'surface': 3}, 'surface must be of class')],
    ids=str)
def test_what_is_no_box_is_refused(options, words):
    with pytest.raises(ValueError, match=words):
        Box(**options)
    with pytest.raises(ValueError, match='at most 250'):
        Dimensions(boxes=[Box()] * 251)
    with pytest.raises(ValueError, match='each of boxes must be of class Box'):
        Dimensions(boxes=['crate'])
