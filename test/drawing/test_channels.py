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

"""Normals, labels, texture coordinates and flow: by rays of another program, and by hand."""
import dataclasses

from flag_sim.drawing import (
    body, box_mesh, Camera, Dimensions, flag_scene, LastFrame, Picture, sheet, Style, Visibility)

import numpy as np

import pytest

from support.flags import wave

SIZE = {'width': 320, 'height': 240}
VIEWS = {
    'default': Camera(**SIZE),
    'behind': Camera(**SIZE, azimuth=1.2, elevation=0.3, distance=7.0),
    'along the cloth': Camera(**SIZE, azimuth=0.2, distance=6.0),
    'platform': Camera(**SIZE, target=(0.0, 0.0, 0.2), distance=2.5, elevation=0.5),
    'within the cloth': Camera(**SIZE, target=(1.2, 0.45, 8.2), distance=0.0, azimuth=0.4,
                               elevation=0.2, vertical_fov=2.0),
    'rolled': Camera(**SIZE, roll=0.7, elevation=0.2, target=(0.3, 0.1, 8.8), distance=1.5),
    'orthographic': Camera(**SIZE, projection='orthographic', azimuth=-1.2, elevation=0.3),
}
ALL = ('depth', 'normals', 'labels', 'texture_coordinates', 'flow', 'visibility')
TURNED = Camera(**SIZE, azimuth=-1.5, elevation=-0.07, roll=0.02, target=(1.05, 0.02, 7.9))


def ways_of(camera, shift):
    """Return where rays begin and their ways (pixels, 3), in the optical frame."""
    v, u = np.mgrid[:camera.height, :camera.width]
    x = ((u + shift[0] - camera.centre[0]) / camera.focal).ravel()
    y = ((v + shift[1] - camera.centre[1]) / camera.focal).ravel()
    z = np.zeros_like(x)
    if camera.is_perspective:
        ways = np.column_stack([x, y, z + 1.0])
        return camera.near * ways, ways
    return np.column_stack([x, y, z + camera.near]), np.column_stack([z, z, z + 1.0])


class Rays:
    """What Embree's rays through pixels' centres meet in a scene."""

    def __init__(self, objects, camera):
        scenes = pytest.importorskip('embreex.rtcore_scene', reason='embreex is not installed')
        from embreex.mesh_construction import TriangleMesh
        starts = np.cumsum([0] + [len(one.vertices) for one in objects])
        self.corners = np.concatenate([one.triangles + at for one, at in zip(objects, starts)])
        self.owner = np.repeat(np.arange(len(objects)), [len(one.triangles) for one in objects])
        points = np.concatenate([one.vertices for one in objects])
        optical = points @ camera.pose[:3, :3].T + camera.pose[:3, 3]
        scene = scenes.EmbreeScene()
        TriangleMesh(scene, optical[self.corners].astype(np.float32))

        def cast(shift):
            begins, ways = (np.ascontiguousarray(array, np.float32)
                            for array in ways_of(camera, shift))
            return scene.run(begins, ways, output=1)
        hits = cast((0.0, 0.0))
        self.triangles = hits['primID']
        # A hundredth of a pixel beside the centre there is the same triangle.
        self.is_sure = np.all([cast(shift)['primID'] == self.triangles for shift in (
            (0.01, 0.0), (-0.01, 0.0), (0.0, 0.01), (0.0, -0.01))], axis=0)
        self.hit = self.triangles >= 0
        a, b, c = np.moveaxis(optical[self.corners[self.triangles[self.hit]]], 1, 0)
        begins, ways = (array[self.hit] for array in ways_of(camera, (0.0, 0.0)))
        # By Moeller and Trumbore, as Embree's own weights are of single precision.
        across = np.cross(ways, c - a)
        determinant = np.einsum('ij,ij->i', across, b - a)
        self.is_back = determinant < 0.0
        of_b = np.einsum('ij,ij->i', begins - a, across) / determinant
        of_c = np.einsum('ij,ij->i', ways, np.cross(begins - a, b - a)) / determinant
        self.weights = np.column_stack([1.0 - of_b - of_c, of_b, of_c])

    def interpolated(self, values):
        """Return what the rays that hit meet of the vertices' values (n, count)."""
        corners = self.corners[self.triangles[self.hit]]
        return np.einsum('ik,ikj->ij', self.weights, values[corners])


def stand(camera, last=None):
    """Return the source's scene, a flag that is crossed by it, and a box."""
    second = sheet(wave(9, 13) + [0.3, -0.2, -0.2], label=4)
    box = body(box_mesh((0.6, -0.8, 7.4), (1.1, -0.4, 7.9)), label=5)
    return [*flag_scene(wave(), None, camera, last=last), second, box]


@pytest.mark.parametrize('view', VIEWS)
def test_what_pixels_are_said_to_see_is_what_rays_meet(view):
    """Every pixel whose centre is not within 0.01 pixel of an edge."""
    camera = VIEWS[view]
    objects = stand(camera)
    frame = Picture().draw_scene(objects, camera, channels=ALL)
    rays = Rays(objects, camera)
    hit, sure = rays.hit, rays.is_sure
    assert sure.mean() > 0.8 and hit[sure].any()
    labels = np.zeros(hit.shape, int)
    labels[hit] = np.array([one.label for one in objects])[rays.owner[rays.triangles[hit]]]
    np.testing.assert_array_equal(frame.labels.ravel()[sure], labels[sure])

    normals = np.concatenate([unit_normals(one) for one in objects]) @ camera.pose[:3, :3].T
    met = rays.interpolated(normals)
    met *= np.where(rays.is_back, -1.0, 1.0)[:, None] / np.linalg.norm(met, axis=1)[:, None]
    shown = frame.normals.reshape(-1, 3)[hit]
    # Vertices on the screen are snapped to 1/256 pixel, which counts in slanted triangles.
    np.testing.assert_allclose(shown[sure[hit]], met[sure[hit]], atol=5e-3)
    np.testing.assert_allclose(np.linalg.norm(shown[sure[hit]], axis=1), 1.0, atol=1e-6)
    assert not frame.normals[frame.labels == 0].any()

    coordinates = np.concatenate([
        np.full((len(one.vertices), 2), np.nan) if one.texture_coordinates is None
        else one.texture_coordinates for one in objects])
    np.testing.assert_allclose(frame.texture_coordinates.reshape(-1, 2)[hit][sure[hit]],
                               rays.interpolated(coordinates)[sure[hit]], atol=1e-3)
    is_flag = np.isin(frame.labels, (1, 4))
    np.testing.assert_array_equal(np.isfinite(frame.texture_coordinates).all(axis=-1), is_flag)


def unit_normals(one):
    """Return an object's normals at vertices: of its own, or averaged by area (eq. 1.13)."""
    normals = one.normals
    if normals is None:
        normals = np.zeros(one.vertices.shape)
        a, b, c = np.moveaxis(one.vertices[one.triangles], 1, 0)
        for corner in range(3):
            np.add.at(normals, one.triangles[:, corner], np.cross(b - a, c - a))
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def test_texture_coordinates_go_from_hoist_to_fly_and_down_on_both_sides():
    x, z = np.meshgrid([0.1, 2.3], [8.9, 7.4])
    flag = np.stack([x, 0.0 * x, z], axis=-1)
    for azimuth, step in ((-np.pi / 2, 1.0), (np.pi / 2, -1.0)):
        camera = Camera(**SIZE, azimuth=azimuth, elevation=0.0, target=(1.2, 0.0, 8.15))
        shown = Picture().draw(flag, camera=camera, channels=['texture_coordinates'])
        u, v = np.moveaxis(shown.texture_coordinates, -1, 0)
        assert (np.sign(np.diff(u[120][np.isfinite(u[120])])) == step).all()
        assert (np.diff(v[:, 160][np.isfinite(v[:, 160])]) > 0.0).all()
        assert np.nanmin(u) < 0.01 and np.nanmax(u) > 0.99
        assert np.nanmin(v) < 0.01 and np.nanmax(v) > 0.99


@pytest.mark.parametrize('now, before', [
    (VIEWS['default'], VIEWS['default']), (VIEWS['default'], TURNED),
    (VIEWS['within the cloth'], dataclasses.replace(VIEWS['within the cloth'], azimuth=0.5)),
    (VIEWS['orthographic'], dataclasses.replace(VIEWS['orthographic'], scale=3.3)),
    (VIEWS['default'], VIEWS['orthographic'])])
def test_flow_leads_to_where_the_surface_was(now, before):
    """By the vertices of both frames and both cameras, within 0.01 pixel."""
    last = LastFrame(wave(phase=-0.2), before)
    objects = flag_scene(wave(), None, now, last=last)
    frame = Picture().draw_scene(objects, now, channels=['flow', 'labels'], camera_before=before)
    rays = Rays(objects, now)
    then = np.concatenate([last.flag_vertices.reshape(-1, 3),
                           *(one.vertices for one in objects[1:])])
    u, v, w = (np.column_stack([rays.interpolated(then), np.ones(rays.hit.sum())])
               @ (before.P @ before.pose).T).T
    pixels = np.column_stack(np.mgrid[:now.height, :now.width][::-1].reshape(2, -1))[rays.hit]
    with np.errstate(divide='ignore', invalid='ignore'):
        expected = np.column_stack([u / w, v / w]) - pixels
    expected[w <= 0.0] = np.nan
    sure = rays.is_sure[rays.hit]
    # Beside the eye thousands of pixels are a millimetre.
    near = sure & (np.abs(expected).max(axis=1, initial=0.0, where=np.isfinite(expected)) < 200.0)
    shown = frame.flow.reshape(-1, 2)[rays.hit]
    assert near.sum() > 1000
    np.testing.assert_allclose(shown[near], expected[near], atol=0.01)
    assert np.isnan(frame.flow[frame.labels == 0]).all()


def test_flow_of_a_still_cloth_is_that_of_depth_and_pose():
    camera = VIEWS['default']
    objects = flag_scene(wave(), None, camera, last=LastFrame(wave(), TURNED))
    frame = Picture().draw_scene(objects, camera, channels=['depth', 'flow'], camera_before=TURNED)
    v, u = np.nonzero(np.isfinite(frame.depth))
    ways = np.linalg.inv(camera.K) @ np.stack([u, v, np.ones(u.shape)])
    points = np.vstack([ways * frame.depth[v, u], np.ones(u.shape)])
    x, y, w = TURNED.P @ TURNED.pose @ np.linalg.inv(camera.pose) @ points
    np.testing.assert_allclose(frame.flow[v, u], np.column_stack([x / w - u, y / w - v]),
                               atol=0.01)
    still = Picture().draw_scene(flag_scene(wave(), None, camera, last=LastFrame(wave(), camera)),
                                 camera, channels=['flow'])
    assert not still.flow[v, u].any()


def test_flow_is_nan_where_nothing_is_known_and_never_wrong():
    camera, picture = VIEWS['default'], Picture()

    def flow_of(last, flag=None, dimensions=Dimensions()):
        objects = flag_scene(wave() if flag is None else flag, None, camera,
                             dimensions=dimensions, last=last)
        return picture.draw_scene(objects, camera, channels=['flow', 'labels'])
    first = flow_of(None)
    assert np.isnan(first.flow).all() and (first.labels == 1).any()
    # Another grid: only what stands still is known.
    other = flow_of(LastFrame(wave(11, 16), camera))
    assert np.isnan(other.flow[other.labels == 1]).all()
    assert not other.flow[other.labels == 2].any() and (other.labels == 2).any()
    # A pole that grows moves too, although it is cut anew for every frame.
    taller = flow_of(LastFrame(wave(), camera, Dimensions(pole_height=8.7)))
    tip = np.nonzero(taller.labels == 2)[0].min()
    moved = taller.flow[tip][taller.labels[tip] == 2]
    scale = camera.pixels_per_metre(float(np.linalg.norm(camera.position - [0.0, 0.0, 9.0])))
    np.testing.assert_allclose(moved[:, 1], 0.3 * scale, rtol=0.1)


def test_what_is_asked_for_changes_nothing_else():
    """Colour and depth neither, nor the number of threads, nor what was drawn before."""
    camera, picture = VIEWS['default'], Picture(2)
    alone = Picture().draw(wave(), camera=camera, channels=['depth'])
    for phase, channels in ((1.0, ALL), (0.0, ALL[1:3]), (2.0, ()), (0.0, ALL), (0.0, ALL[4:])):
        objects = flag_scene(wave(phase=phase), None, camera, last=LastFrame(wave(), TURNED))
        frame = picture.draw_scene(objects, camera, channels=channels, camera_before=TURNED)
        fresh = Picture().draw_scene(objects, camera, channels=ALL, camera_before=TURNED)
        for name in ALL:
            shown, expected = getattr(frame, name), getattr(fresh, name)
            assert (shown is None) == (name not in channels)
            if shown is not None:
                pairs = zip(shown, expected) if name == 'visibility' else [(shown, expected)]
                for one, other in pairs:
                    np.testing.assert_array_equal(one, other)
        if phase == 0.0:
            np.testing.assert_array_equal(frame.colour, alone.colour)
    np.testing.assert_array_equal(fresh.depth, alone.depth)


def test_samples_average_the_colour_alone():
    camera = VIEWS['default']
    objects = flag_scene(wave(), None, camera, last=LastFrame(wave(), TURNED))
    frames = [Picture().draw_scene(objects, camera, style=Style(samples=samples), channels=ALL)
              for samples in (1, 8)]
    assert (frames[0].colour != frames[1].colour).any()
    for name in ALL[:-1]:
        np.testing.assert_array_equal(*(getattr(frame, name) for frame in frames))


def test_a_copy_stays_and_images_are_read_only():
    camera, picture = VIEWS['default'], Picture()
    frame = picture.draw(wave(), camera=camera, channels=ALL)
    kept = frame.copy()
    picture.draw(wave(phase=1.0), camera=camera, channels=ALL)
    assert isinstance(kept.visibility, Visibility)
    for name in ALL[:-1]:
        assert (np.nan_to_num(getattr(kept, name)) != np.nan_to_num(getattr(frame, name))).any() \
            or name == 'flow'
        with pytest.raises(ValueError, match='read-only'):
            getattr(frame, name)[0] = 0


@pytest.mark.parametrize('make, said', [
    (lambda: LastFrame(wave()[0]), 'flag_vertices must be of shape'),
    (lambda: LastFrame(wave(), 'here'), 'camera must be of class Camera'),
    (lambda: LastFrame(wave(), Camera(), 3), 'dimensions must be of class Dimensions'),
    (lambda: flag_scene(wave(), last=wave()), 'last must be of class LastFrame'),
    (lambda: sheet(wave(), before=wave(5, 5)), 'before must be of shape'),
    (lambda: body(box_mesh((0, 0, 0), (1, 1, 1)), before=np.zeros((3, 3))),
     'before must be of shape'),
    (lambda: dataclasses.replace(sheet(wave()), texture_coordinates=np.zeros((3, 2))),
     'texture_coordinates must be of shape'),
    (lambda: Picture().draw_scene(flag_scene(wave()), camera_before=1),
     'camera_before must be of class Camera'),
    (lambda: Picture().draw_scene(flag_scene(wave()), channels=['normal']), 'texture_coordinates'),
])
def test_what_is_no_frame_before_is_refused(make, said):
    with pytest.raises(ValueError, match=said):
        make()
