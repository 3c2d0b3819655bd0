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

"""Coverage against exact whole-number arithmetic, values against formulas."""
from fractions import Fraction

from flag_sim.drawing.attributes import new_slots
from flag_sim.drawing.batched import new_batch
from flag_sim.drawing.clipping import GUARD
from flag_sim.drawing.culling import CHUNK, collect, cull, LARGE, Margin, MEDIUM, Order, SMALL
from flag_sim.drawing.geometry import Geometry, Lens, project, SUBPIXELS, Vertices
from flag_sim.drawing.large import new_polygon
from flag_sim.drawing.visibility import Colours, Pass, rasterize, Target

import numpy as np

import pytest

WIDTH, HEIGHT = 61, 43
STRIDE = 64
NO_NUMBERS, NO_SLOTS = np.empty(0, np.uint32), new_slots(0)
BATCH, POLYGON = new_batch(), new_polygon()


def draw(corners, reversed_z=1.0, colours=255.0, is_perspective_correct=False, bands=1,
         is_painter=False, shift=(0.0, 0.0), kind=None):
    """
    Draw triangles of corners (m, 3, 2) [pixel]; return reversed Z and words, (HEIGHT, WIDTH).

    kind: how all are drawn: LARGE, MEDIUM or SMALL; None leaves that to their widths.
    """
    snapped = np.asarray(np.round(np.asarray(corners) * SUBPIXELS), dtype=np.int32).reshape(-1, 2)
    points, count = len(snapped), len(snapped) // 3
    near = np.array(np.broadcast_to(reversed_z, (count, 3)), dtype=float).ravel()
    matter = np.empty((points, 2, 3))
    matter[:] = np.broadcast_to(colours, (count, 3, 3)).reshape(-1, 1, 3)
    vertices = Vertices(np.empty((points, 3)), *np.ascontiguousarray(snapped.T), near,
                        np.zeros(points, np.int32))
    geometry, order = scene(vertices, Lens(np.eye(4), 0.0, 0.0, 0.1, True), SUBPIXELS)
    if kind is not None:
        geometry.sizes[:] = kind
    numbers = np.empty(count + 1, np.int32)
    depth, words = np.zeros((HEIGHT, STRIDE), np.float32), np.zeros((HEIGHT, STRIDE), np.uint32)
    how = Pass(*np.int32(np.multiply(shift, SUBPIXELS)),
               np.float32(-np.inf if is_painter else np.inf), False, is_perspective_correct)
    for top in range(0, HEIGHT, -(-HEIGHT // bands)):
        end = min(top + -(-HEIGHT // bands), HEIGHT)
        found, _, _ = collect(order, top, end, numbers)
        target = Target(words[top:end].reshape(-1), depth[top:end].reshape(-1), NO_NUMBERS,
                        NO_SLOTS, top, end, WIDTH, STRIDE)
        rasterize(geometry, Colours(matter, False), numbers[:found], how, target, BATCH, POLYGON)
    return depth[:, :WIDTH], words[:, :WIDTH]


def scene(vertices, lens, margin):
    """Return the Geometry of triangles of three vertices each, and their Order."""
    points = len(vertices.u)
    count = points // 3
    geometry = Geometry(np.arange(points, dtype=np.int32).reshape(-1, 3),
                        np.zeros(count, np.uint8), np.empty(count, np.uint8), vertices, lens)
    chunks = -(-count // CHUNK)
    order = Order(np.arange(count, dtype=np.int32), np.empty((2, count), np.int16),
                  np.empty((4, chunks), np.int32))
    cull(geometry, order, Margin(WIDTH, HEIGHT, margin), 0, chunks)
    return geometry, order


def covered(snapped):
    """Return by exact edge functions which pixels a triangle (3, 2) [subpixels] covers."""
    a, b, c = (np.asarray(corner, dtype=np.int64) for corner in snapped)
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if area == 0:
        return np.zeros((HEIGHT, WIDTH), bool)
    if area < 0:
        b, c = c, b
    x, y = SUBPIXELS * np.arange(WIDTH), SUBPIXELS * np.arange(HEIGHT)[:, None]
    inside = np.ones((HEIGHT, WIDTH), bool)
    for begin, end in ((a, b), (b, c), (c, a)):
        dx, dy = end - begin
        edge = dx * (y - begin[1]) - dy * (x - begin[0])
        is_top_or_left = dy < 0 or (dy == 0 and dx > 0)
        inside &= edge >= 0 if is_top_or_left else edge > 0
    return inside


def some_triangles(kind, count, rng):
    """Make triangles of a kind: (count, 3, 2) [subpixels]."""
    spread = np.array([WIDTH, HEIGHT]) * SUBPIXELS
    triangles = rng.integers(-spread // 4, spread * 5 // 4, (count, 3, 2))
    if kind == 'sliver':
        # The third corner lies within two subpixels of the line through the others.
        along = rng.random((count, 1))
        triangles[:, 2] = triangles[:, 0] + np.round(
            along * (triangles[:, 1] - triangles[:, 0])) + rng.integers(-2, 3, (count, 2))
    elif kind == 'thin':
        # About a centre, no wider than what is drawn in groups.
        centre = triangles[:, 0] // SUBPIXELS * SUBPIXELS
        way = rng.integers((-7 * SUBPIXELS, -999 * SUBPIXELS), (7 * SUBPIXELS, 1000 * SUBPIXELS),
                           (count, 2))
        triangles = np.stack([centre - way, centre + way + rng.integers(-1, 2, (count, 2)),
                              centre + rng.integers(-1, 2, (count, 2))], axis=1)
    elif kind == 'small':
        triangles = triangles[:, :1] + rng.integers(-400, 401, (count, 3, 2))
    elif kind == 'narrow':
        # Up to as high as vertices can be apart: what is beyond is clipped.
        triangles[:, :, 0] = triangles[:, :1, 0] + rng.integers(0, 64 * SUBPIXELS, (count, 3))
        reach = int(GUARD) * SUBPIXELS
        triangles[:, :, 1] = np.clip(triangles[:, :, 1] * 8 ** rng.integers(0, 5, (count, 1)),
                                     -reach, reach)
    elif kind == 'centres':
        triangles = triangles // SUBPIXELS * SUBPIXELS
    elif kind == 'halves':
        triangles = triangles // (SUBPIXELS // 2) * (SUBPIXELS // 2)
    elif kind == 'axes':
        triangles[:, 1, 1] = triangles[:, 0, 1]
        triangles[:, 2, 0] = triangles[:, 0, 0]
    elif kind == 'huge':
        reach = int(GUARD) * SUBPIXELS
        triangles = rng.integers(-reach, reach + 1, (count, 3, 2))
        # A corner in the picture, or else most of them miss it.
        triangles[:, 0] = rng.integers(0, spread, (count, 2))
    elif kind == 'huge sliver':
        # Opposite ends of the band, the line through them crossing the picture near a centre.
        reach = int(GUARD) * SUBPIXELS
        triangles[:, 0] = rng.integers(-reach, reach + 1, (count, 2))
        centre = triangles[:, 2] // SUBPIXELS * SUBPIXELS
        triangles[:, 1] = np.clip(2 * centre - triangles[:, 0], -reach, reach)
        triangles[:, 2] = centre + rng.integers(-1, 2, (count, 2))
    return triangles


KINDS = ['random', 'sliver', 'small', 'narrow', 'centres', 'halves', 'axes', 'huge', 'huge sliver']


@pytest.mark.parametrize('kind, way', [
    *((kind, None) for kind in KINDS), ('small', LARGE), ('small', MEDIUM), ('narrow', LARGE),
    ('narrow', SMALL)])
def test_coverage_is_exact(kind, way):
    rng = np.random.default_rng(2021)
    some = False
    for triangle in some_triangles(kind, 1500, rng):
        depth, _ = draw([triangle / SUBPIXELS], kind=way)
        expected = covered(triangle)
        some |= expected.any()
        np.testing.assert_array_equal(depth > 0, expected, err_msg=str(triangle))
    assert some


@pytest.mark.parametrize('shift', [(-0.375, 0.125), (0.46875, -0.46875)])
def test_coverage_of_a_sample_is_exact(shift):
    # A sample at a pixel's centre + shift sees what the centre sees of shifted triangles.
    rng = np.random.default_rng(2022)
    for triangle in some_triangles('random', 500, rng):
        depth, _ = draw([triangle / SUBPIXELS], shift=shift)
        moved = triangle - np.array(shift) * SUBPIXELS
        np.testing.assert_array_equal(depth > 0, covered(moved.astype(int)))


@pytest.mark.parametrize('scale', [1, SUBPIXELS])
def test_a_shared_edge_mesh_has_no_gaps_and_no_doubles(scale):
    rng = np.random.default_rng(7)
    rows, columns = 9, 11
    grid = np.stack(np.meshgrid(np.linspace(-8, WIDTH + 8, columns),
                                np.linspace(-8, HEIGHT + 8, rows)), axis=-1)
    grid += rng.uniform(-2, 2, grid.shape)
    # Snapped to subpixels, or to pixel centres, where every edge goes through centres.
    grid = np.round(grid * SUBPIXELS / scale) * scale / SUBPIXELS
    times = np.zeros((HEIGHT, WIDTH), int)
    for i in range(rows - 1):
        for j in range(columns - 1):
            a, b, c, d = grid[i, j], grid[i, j + 1], grid[i + 1, j], grid[i + 1, j + 1]
            for triangle in ((a, b, c), (d, c, b)):
                times += draw([triangle])[0] > 0
    np.testing.assert_array_equal(times, 1)


def test_a_fan_about_a_pixel_centre_covers_it_once():
    rng = np.random.default_rng(3)
    for _ in range(100):
        angles = 2 * np.pi / 9 * (np.arange(9) + rng.uniform(-0.4, 0.4, 9))
        rim = np.round((np.column_stack([np.cos(angles), np.sin(angles)]) * 19 + (30, 21))
                       * SUBPIXELS) / SUBPIXELS
        rim = np.vstack([rim, rim[:1]])
        times = sum((draw([[(30, 21), p, q]])[0] > 0).astype(int)
                    for p, q in zip(rim[:-1], rim[1:]))
        assert times.max() == 1 and times[21, 30] == 1


def test_reversed_z_and_colour_are_planes():
    corners = np.array([[(-5.0, -3.0), (70.0, 10.0), (8.0, 60.0)]])
    reversed_z, colours = np.array([[0.2, 0.5, 0.9]]), np.diag([255.0, 200.0, 100.0])[None]
    depth, words = draw(corners, reversed_z, colours)
    v, u = np.nonzero(depth)
    ones = np.column_stack([corners[0], np.ones(3)])
    weights = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(ones)
    np.testing.assert_allclose(depth[v, u], weights @ reversed_z[0], rtol=1e-6)
    levels = words[v, u][:, None] >> np.array([0, 8, 16], np.uint32) & 255
    np.testing.assert_allclose(levels, weights @ colours[0], atol=0.5 + 1e-3)


def test_triangles_in_groups_and_alone_make_the_same_picture():
    # Colours are interpolated from other starting points, so rounding may differ by one level.
    rng = np.random.default_rng(11)
    corners = some_triangles('small', 400, rng) / SUBPIXELS
    reversed_z, colours = rng.uniform(0.5, 0.6, (400, 3)), rng.uniform(0, 255, (400, 3, 3))
    for is_perspective_correct in (False, True):
        for is_painter in (False, True):
            (one, words), (same, same_words), (other, others) = (
                draw(corners, reversed_z, colours, is_perspective_correct, is_painter=is_painter,
                     kind=kind) for kind in (SMALL, MEDIUM, LARGE))
            np.testing.assert_array_equal(same, one)
            np.testing.assert_array_equal(same_words, words)
            np.testing.assert_allclose(one, other, rtol=1e-5)
            shifts = np.array([0, 8, 16], np.uint32)
            apart = np.abs((words[..., None] >> shifts & 255).astype(int)
                           - (others[..., None] >> shifts & 255))
            assert apart.max() <= 1


def test_perspective_correct_colour_is_linear_in_space():
    corners = np.array([[(-5.0, -3.0), (70.0, 10.0), (8.0, 60.0)]])
    reversed_z, colours = np.array([[0.1, 0.5, 1.0]]), np.diag([255.0, 200.0, 100.0])[None]
    depth, words = draw(corners, reversed_z, colours, is_perspective_correct=True)
    v, u = np.nonzero(depth)
    ones = np.column_stack([corners[0], np.ones(3)])
    weights = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(ones) * reversed_z[0]
    weights /= weights.sum(axis=1)[:, None]
    levels = words[v, u][:, None] >> np.array([0, 8, 16], np.uint32) & 255
    np.testing.assert_allclose(levels, weights @ colours[0], atol=0.5 + 1e-3)


def test_the_nearer_wins_in_any_order():
    corners = [[(0, 0), (50, 0), (0, 40)], [(5, 5), (60, 8), (2, 42)]]
    reversed_z = [[0.1, 0.9, 0.5], [0.6, 0.2, 0.4]]
    colours = [[[250] * 3] * 3, [[20] * 3] * 3]
    first = draw(corners, reversed_z, colours)
    second = draw(corners[::-1], reversed_z[::-1], colours[::-1])
    np.testing.assert_array_equal(first, second)


def test_a_painter_covers_what_is_nearer():
    corners = [[(0, 0), (50, 0), (0, 40)], [(5, 5), (60, 8), (2, 42)]]
    colours = [[[250] * 3] * 3, [[20] * 3] * 3]
    depth, words = draw(corners, [[0.9] * 3, [0.2] * 3], colours, is_painter=True)
    second = draw(corners[1:])[0] > 0
    assert (words[second] == 20 | 20 << 8 | 20 << 16).all()
    np.testing.assert_allclose(depth[second], 0.2, rtol=1e-6)
    assert (words[(depth > 0) & ~second] == 250 | 250 << 8 | 250 << 16).all()


def test_row_bands_make_the_same_picture():
    rng = np.random.default_rng(5)
    corners = some_triangles('random', 300, rng) / SUBPIXELS
    reversed_z, colours = rng.uniform(0.1, 1, (300, 3)), rng.uniform(0, 255, (300, 3, 3))
    whole = draw(corners, reversed_z, colours)
    for bands in (2, 3, 7):
        np.testing.assert_array_equal(draw(corners, reversed_z, colours, bands=bands), whole)


def test_colours_of_slivers_do_not_wrap():
    rng = np.random.default_rng(6)
    corners = some_triangles('sliver', 3000, rng) / SUBPIXELS
    colours = np.tile([[0.0, 255.0, 128.0], [0.0, 255.0, 128.0], [0.0, 255.0, 128.0]],
                      (3000, 1, 1))
    for is_perspective_correct in (False, True):
        _, words = draw(corners, rng.uniform(0.1, 1, (3000, 3)), colours, is_perspective_correct)
        assert set(np.unique(words)) <= {0, 128 << 16 | 255 << 8}


def shift_of(words, channel):
    """Return a channel of packed words."""
    return words >> np.uint32(8 * channel) & np.uint32(255)


@pytest.mark.parametrize('kind', [LARGE, MEDIUM, SMALL])
@pytest.mark.parametrize('is_painter', [False, True])
@pytest.mark.parametrize('shift', [(0.0, 0.0), (0.46875, -0.46875)])
def test_no_value_leaves_its_triangles_own_range(kind, is_painter, shift):
    # Slivers, of which reversed Z and colours change by more from pixel to pixel than from corner
    # to corner: whatever is rounded, a pixel shows something of the triangle.
    rng = np.random.default_rng(10)
    drawn, whole_shift = 0, np.int64(np.array(shift) * SUBPIXELS)
    for triangle in some_triangles('thin', 400, rng) + whole_shift:
        reversed_z, colours = rng.uniform(1 / 5.5, 1 / 4, 3), rng.uniform(0, 255, (3, 3))
        for is_perspective_correct in (False, True):
            depth, words = draw([triangle / SUBPIXELS], reversed_z, colours,
                                is_perspective_correct, is_painter=is_painter, shift=shift,
                                kind=kind)
            expected = covered(triangle - whole_shift)
            np.testing.assert_array_equal(depth > 0, expected)
            drawn += expected.sum()
            least, most = np.float32(reversed_z.min()), np.float32(reversed_z.max())
            assert ((depth[expected] >= least) & (depth[expected] <= most)).all()
            for channel in range(3):
                levels = shift_of(words[expected], channel)
                assert (levels >= int(colours[:, channel].min() + 0.5)).all()
                assert (levels <= int(colours[:, channel].max() + 0.5)).all()
    assert drawn > 100


@pytest.mark.parametrize('kind', [LARGE, MEDIUM, SMALL])
def test_values_by_exact_arithmetic(kind):
    # Barycentric weights in whole numbers; one step of the grid in area tells how exact it can be.
    rng = np.random.default_rng(12)
    for triangle in some_triangles('thin', 300, rng):
        reversed_z = rng.uniform(1 / 5.5, 1 / 4, 3)
        depth, _ = draw([triangle / SUBPIXELS], reversed_z, kind=kind)
        a, b, c = (tuple(int(x) for x in corner) for corner in triangle)

        def area(p, q, r):
            return (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])

        whole = area(a, b, c)
        for v, u in zip(*np.nonzero(depth)):
            centre = int(u) * SUBPIXELS, int(v) * SUBPIXELS
            weights = (Fraction(area(centre, b, c), whole), Fraction(area(a, centre, c), whole),
                       Fraction(area(a, b, centre), whole))
            exact = float(sum(w * Fraction(s) for w, s in zip(weights, reversed_z)))
            # The change a pixel, times some pixels, times float32's step.
            slope = np.ptp(reversed_z) * 1000 * SUBPIXELS ** 2 / abs(whole)
            assert abs(depth[v, u] - exact) <= 2e-7 * (1.0 + 64 * slope)


def test_hostile_vertices_write_nothing_outside():
    rng = np.random.default_rng(8)
    values = [0.0, 1.0, -1.0, 0.05, 1e3, -1e3, 1e15, 1e30, -1e30, 1e300, 1e308, -1e308, 5e-324,
              np.inf, -np.inf, np.nan]
    vertices = rng.choice(values, (12000, 3)) * rng.choice([1.0, 0.37], (12000, 1))
    ordinary = rng.random(12000) < 0.5
    vertices[ordinary] = rng.uniform(-3, 3, (ordinary.sum(), 3))
    matrix = np.diag([40.0, 40.0, 1.0, 1.0])
    size, margin = STRIDE * HEIGHT, 500
    for is_perspective in (True, False):
        seen = Vertices(np.empty((12000, 3)), *np.empty((2, 12000), np.int32), np.empty(12000),
                        np.empty(12000, np.int32))
        lens = Lens(matrix, 30.0, 21.0, 0.05, is_perspective)
        project(vertices, lens, seen)
        geometry, order = scene(seen, lens, 0)
        numbers = np.empty(4001, np.int32)
        count, _, _ = collect(order, 0, HEIGHT, numbers)
        # The rows lie between margins that must stay as they are.
        depth = np.full(size + 2 * margin, np.float32(-1e30))
        words = np.full(size + 2 * margin, 77, np.uint32)
        target = Target(words[margin:margin + size], depth[margin:margin + size], NO_NUMBERS,
                        NO_SLOTS, 0, HEIGHT, WIDTH, STRIDE)
        rasterize(geometry, Colours(np.full((12000, 2, 3), 128.0), False), numbers[:count],
                  Pass(np.int32(0), np.int32(0), np.float32(np.inf), False, True), target, BATCH,
                  POLYGON)
        for buffer, clear in ((depth, np.float32(-1e30)), (words, 77)):
            assert (buffer[:margin] == clear).all() and (buffer[-margin:] == clear).all()
        assert np.isfinite(depth).all()
        assert set(np.unique(words)) == {77, 128 | 128 << 8 | 128 << 16}
