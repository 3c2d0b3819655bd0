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

"""Motion: flow is exact, and what is hidden in the other frame is known."""
import dataclasses

from flag_sim.cloth import Cloth
from flag_sim.drawing import Camera, flag_scene, LastFrame, Picture
from flag_sim.drawing.motion import motion
import numpy as np
import pytest

CAMERA = Camera(160, 120, azimuth=-1.2, distance=5.0)
AFTER = dataclasses.replace(CAMERA, azimuth=-1.15, distance=4.9, roll=0.02)
CHANNELS = ['visibility', 'depth', 'labels', 'flow', 'texture_coordinates']


@pytest.fixture(scope='module')
def frames():
    """Return two neighbouring states of a flag in a strong wind, (rows, columns, 3) [m]."""
    cloth = Cloth(13, 19, pole=(0.0, 0.0, 0.05), start_noise=0.01)
    for _ in range(45):
        cloth.advance(1 / 30, (9.0, 5.0, 0.0))
    first = cloth.positions
    cloth.advance(1 / 30, (9.0, 5.0, 0.0))
    return first, cloth.positions


def seen(positions, other, camera, camera_other):
    """Return what is drawn of a frame, its objects and its Motion to the other one."""
    objects = flag_scene(positions, None, camera, last=LastFrame(other, camera_other))
    frame = Picture(1).draw_scene(objects, camera, channels=CHANNELS, camera_before=camera_other)
    frame = frame.copy()
    return frame, objects, motion(frame.visibility, objects, camera, camera_other)


def projected(points, camera):
    """Return (u, v, z) of points (n, 3) [m], by the matrices that the camera tells others."""
    local = np.c_[points, np.ones(len(points))] @ camera.pose.T
    u, v, w = (local @ camera.P.T).T
    return np.stack([u / w, v / w, local[:, 2]], axis=1)


def points_of(frame, vertices):
    """Return rows, columns, and where the points that pixels see are among moved vertices."""
    rows, columns = np.nonzero(frame.visibility.triangles >= 0)
    corners = frame.visibility.corners[frame.visibility.triangles[rows, columns]]
    b, c = frame.visibility.weights[rows, columns].astype(float).T
    weights = np.stack([1.0 - b - c, b, c], axis=1)
    return rows, columns, np.einsum('nk,nkx->nx', weights, vertices[corners])


def points_at_centres(frame, vertices, camera, moved):
    """Return rows, columns, and where the points that pixels' very centres see have moved."""
    rows, columns = np.nonzero(frame.visibility.triangles >= 0)
    corners = frame.visibility.corners[frame.visibility.triangles[rows, columns]]
    u, v, z = projected(vertices, camera).T
    # Points on the line of sight: their weighted distances from it [pixel times depth] vanish.
    depths = z[corners] if camera.is_perspective else np.ones(corners.shape)
    equations = np.stack([(u[corners] - columns[:, None]) * depths,
                          (v[corners] - rows[:, None]) * depths, np.ones(corners.shape)], axis=1)
    weights = np.linalg.solve(equations, np.broadcast_to([[0.0], [0.0], [1.0]],
                                                         (len(rows), 3, 1)))[..., 0]
    return rows, columns, np.einsum('nk,nkx->nx', weights, moved[corners])


@pytest.mark.parametrize('projection', ['perspective', 'orthographic'])
@pytest.mark.parametrize('is_forward', [False, True])
def test_flow_leads_to_the_same_material_point(frames, projection, is_forward):
    """To 0.01 pixel, from the pixel's centre, by the vertices; and it is the channel's flow."""
    cameras = [dataclasses.replace(one, projection=projection) for one in (CAMERA, AFTER)]
    (here, there), (camera, other) = ((frames, cameras) if is_forward else
                                      (frames[::-1], cameras[::-1]))
    frame, objects, found = seen(here, there, camera, other)
    vertices, before = (np.concatenate([getattr(one, name) for one in objects])
                        for name in ('vertices', 'before'))
    rows, columns, points = points_at_centres(frame, vertices, camera, before)
    u, v, _ = projected(points, other).T
    off = np.stack([columns, rows], axis=1) + found.flow[rows, columns] - np.stack([u, v], axis=1)
    assert len(rows) > 3000 and np.abs(off).max() < 0.01
    np.testing.assert_allclose(found.flow, frame.flow, atol=1e-3)
    assert np.isnan(found.flow[frame.labels == 0]).all()


def test_flow_depth_and_pose_agree(frames):
    """Of a still cloth before a moving camera: from depth and both poses, to 0.01 pixel."""
    frame, _, found = seen(frames[0], frames[0], CAMERA, AFTER)
    rows, columns = np.nonzero(frame.labels == 1)
    depth = frame.depth[rows, columns].astype(float)
    rays = np.stack([columns, rows, np.ones(len(rows))], axis=1) @ np.linalg.inv(CAMERA.K).T
    world = (np.c_[rays * depth[:, None], np.ones(len(rows))] @ np.linalg.inv(CAMERA.pose).T)
    u, v, _ = projected(world[:, :3], AFTER).T
    by_depth = np.stack([u - columns, v - rows], axis=1)
    assert np.abs(by_depth).max() > 1.0
    assert np.abs(by_depth - found.flow[rows, columns]).max() < 0.01


def covered(point, own, triangles, eye):
    """Return whether a triangle other than `own` stands between a point and the eye."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    ray = eye - point
    p = np.cross(ray, c - a)
    det = np.einsum('nk,nk->n', b - a, p)
    with np.errstate(divide='ignore', invalid='ignore'):
        u = np.einsum('k,nk->n', point, p) - np.einsum('nk,nk->n', a, p)
        q = np.cross(point - a, b - a)
        u, v, t = u / det, q @ ray / det, np.einsum('nk,nk->n', c - a, q) / det
        met = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 1e-5) & (t < 1.0)
    met[own] = False
    return bool(met.any())


def test_what_is_hidden_is_what_a_ray_says(frames):
    """Each pixel's point in the other frame, by rays to the eye through all triangles."""
    side = dataclasses.replace(AFTER, azimuth=-0.25, vertical_fov=0.3)
    frame, objects, found = seen(*frames, CAMERA, side)
    before = np.concatenate([one.before for one in objects])
    triangles = before[frame.visibility.corners]
    rows, columns, points = points_of(frame, before)
    u, v, _ = projected(points, side).T
    outside = (u < -0.5) | (u >= 159.5) | (v < -0.5) | (v >= 119.5)
    random = np.random.default_rng(3)
    wrong = 0
    for k in random.choice(len(rows), 600, replace=False):
        own = frame.visibility.triangles[rows[k], columns[k]]
        expected = outside[k] or covered(points[k], own, triangles, side.position)
        wrong += expected != found.is_hidden[rows[k], columns[k]]
    hidden = found.is_hidden[rows, columns]
    assert outside.any() and 0.1 < hidden.mean() < 0.9 and hidden[~outside].any()
    assert wrong <= 1  # a point within rounding of an edge


@pytest.mark.parametrize('what, number', [('texture_coordinates', 1), ('colour', 0)])
def test_the_next_picture_warped_is_this_one(frames, what, number):
    """
    At 35 dB and more, where nothing is hidden and its neighbours are of the same thing.

    What is painted on the cloth, whatever it does; its colour, where it stands still before a
    camera that moves, for as it turns its light changes.
    """
    frame, _, found = seen(frames[0], frames[number], CAMERA, AFTER)
    after = Picture(1).draw_scene(flag_scene(frames[number], None, AFTER), AFTER,
                                  channels=['labels', 'texture_coordinates'])
    here, there = ({'colour': one.colour / 255.0}.get(what, one.texture_coordinates)
                   for one in (frame, after))
    rows, columns = np.nonzero((frame.labels == 1) & ~found.is_hidden)
    u, v = (np.stack([columns, rows], axis=1) + found.flow[rows, columns]).T
    left, top = np.int64(np.floor(u)), np.int64(np.floor(v))
    inside = (left >= 0) & (top >= 0) & (left < 159) & (top < 119)
    rows, columns, u, v, left, top = (a[inside] for a in (rows, columns, u, v, left, top))
    total, same = np.zeros((len(rows), here.shape[2])), np.ones(len(rows), bool)
    for down, right in ((0, 0), (0, 1), (1, 0), (1, 1)):
        weight = np.abs(1 - down - (v - top)) * np.abs(1 - right - (u - left))
        total += weight[:, None] * there[top + down, left + right]
        same &= after.labels[top + down, left + right] == 1
    error = (total - here[rows, columns])[same]
    assert same.sum() > 2000
    assert -10.0 * np.log10((error**2).mean()) > 35.0


def test_what_is_behind_the_camera_or_not_known_has_no_flow(frames):
    beyond = dataclasses.replace(CAMERA, target=(1.1, 60.0, 7.85), distance=0.0, azimuth=-1.57)
    frame, _, found = seen(*frames, CAMERA, beyond)
    flag = frame.labels == 1
    assert np.isnan(found.flow[flag]).all() and found.is_hidden[flag].all()
    objects = flag_scene(frames[0], None, CAMERA)
    unknown = motion(frame.visibility, objects, CAMERA, CAMERA)
    assert np.isnan(unknown.flow).all() and not unknown.is_hidden.any()


def test_objects_of_another_frame_are_refused(frames):
    frame, objects, _ = seen(*frames, CAMERA, AFTER)
    with pytest.raises(ValueError, match='of the .* vertices'):
        motion(frame.visibility, objects[:1], CAMERA, AFTER)
