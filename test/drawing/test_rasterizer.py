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

"""What the rasterizer makes of depth and colour against formulas and exact arithmetic."""
from fractions import Fraction

from flag_sim.drawing.culling import LARGE, MEDIUM, SMALL, triangles_in_rows
from flag_sim.drawing.geometry import project, SUBPIXELS, Vertices, ViewTransform
from flag_sim.drawing.rasterizer import Colours, rasterize, RasterizerState, Target

import numpy as np

import pytest

from support.triangles import (
    BATCH, covered, draw, geometry_of, HEIGHT, NO_FACES, POLYGON, some_triangles,
    STRIDE, WIDTH)


def test_reversed_z_and_colour_are_planes():
    corners = np.array([[(-5.0, -3.0), (70.0, 10.0), (8.0, 60.0)]])
    reversed_z, colours = np.array([[0.2, 0.5, 0.9]]), np.diag([255.0, 200.0, 100.0])[None]
    depth, colour = draw(corners, reversed_z, colours)
    v, u = np.nonzero(depth)
    ones = np.column_stack([corners[0], np.ones(3)])
    weights = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(ones)
    np.testing.assert_allclose(depth[v, u], weights @ reversed_z[0], rtol=1e-6)
    levels = colour[v, u][:, None] >> np.array([0, 8, 16], np.uint32) & 255
    np.testing.assert_allclose(levels, weights @ colours[0], atol=0.5 + 1e-3)


def test_triangles_in_batches_and_alone_make_the_same_picture():
    # Colours are interpolated from other starting points, so rounding may differ by one level.
    rng = np.random.default_rng(11)
    corners = some_triangles('small', 400, rng) / SUBPIXELS
    reversed_z, colours = rng.uniform(0.5, 0.6, (400, 3)), rng.uniform(0, 255, (400, 3, 3))
    for is_perspective_correct in (False, True):
        for is_painter in (False, True):
            (one, colour), (same, same_colour), (other, others) = (
                draw(corners, reversed_z, colours, is_perspective_correct, is_painter=is_painter,
                     size=size) for size in (SMALL, MEDIUM, LARGE))
            np.testing.assert_array_equal(same, one)
            np.testing.assert_array_equal(same_colour, colour)
            np.testing.assert_allclose(one, other, rtol=1e-5)
            shifts = np.array([0, 8, 16], np.uint32)
            apart = np.abs((colour[..., None] >> shifts & 255).astype(int)
                           - (others[..., None] >> shifts & 255))
            assert apart.max() <= 1


def test_perspective_correct_colour_is_linear_in_space():
    corners = np.array([[(-5.0, -3.0), (70.0, 10.0), (8.0, 60.0)]])
    reversed_z, colours = np.array([[0.1, 0.5, 1.0]]), np.diag([255.0, 200.0, 100.0])[None]
    depth, colour = draw(corners, reversed_z, colours, is_perspective_correct=True)
    v, u = np.nonzero(depth)
    ones = np.column_stack([corners[0], np.ones(3)])
    weights = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(ones) * reversed_z[0]
    weights /= weights.sum(axis=1)[:, None]
    levels = colour[v, u][:, None] >> np.array([0, 8, 16], np.uint32) & 255
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
    depth, colour = draw(corners, [[0.9] * 3, [0.2] * 3], colours, is_painter=True)
    second = draw(corners[1:])[0] > 0
    assert (colour[second] == 20 | 20 << 8 | 20 << 16).all()
    np.testing.assert_allclose(depth[second], 0.2, rtol=1e-6)
    assert (colour[(depth > 0) & ~second] == 250 | 250 << 8 | 250 << 16).all()


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
        _, colour = draw(corners, rng.uniform(0.1, 1, (3000, 3)), colours, is_perspective_correct)
        assert set(np.unique(colour)) <= {0, 128 << 16 | 255 << 8}


def levels_of(colour, channel):
    """Return a channel of packed colours."""
    return colour >> np.uint32(8 * channel) & np.uint32(255)


@pytest.mark.parametrize('size', [LARGE, MEDIUM, SMALL])
@pytest.mark.parametrize('is_painter', [False, True])
@pytest.mark.parametrize('shift', [(0.0, 0.0), (0.46875, -0.46875)])
def test_values_stay_in_the_range_of_their_triangle(size, is_painter, shift):
    # Slivers, of which reversed Z and colours change by more from pixel to pixel than from corner
    # to corner: whatever is rounded, a pixel shows something of the triangle.
    rng = np.random.default_rng(10)
    drawn, snapped_shift = 0, np.int64(np.array(shift) * SUBPIXELS)
    for triangle in some_triangles('thin', 400, rng) + snapped_shift:
        reversed_z, colours = rng.uniform(1 / 5.5, 1 / 4, 3), rng.uniform(0, 255, (3, 3))
        for is_perspective_correct in (False, True):
            depth, colour = draw([triangle / SUBPIXELS], reversed_z, colours,
                                 is_perspective_correct, is_painter=is_painter, shift=shift,
                                 size=size)
            expected = covered(triangle - snapped_shift)
            np.testing.assert_array_equal(depth > 0, expected)
            drawn += expected.sum()
            least, most = np.float32(reversed_z.min()), np.float32(reversed_z.max())
            assert ((depth[expected] >= least) & (depth[expected] <= most)).all()
            for channel in range(3):
                levels = levels_of(colour[expected], channel)
                assert (levels >= int(colours[:, channel].min() + 0.5)).all()
                assert (levels <= int(colours[:, channel].max() + 0.5)).all()
    assert drawn > 100


@pytest.mark.parametrize('size', [LARGE, MEDIUM, SMALL])
def test_values_by_exact_arithmetic(size):
    # Barycentric weights in whole numbers; one step of the grid in area tells how exact it can be.
    rng = np.random.default_rng(12)
    for triangle in some_triangles('thin', 300, rng):
        reversed_z = rng.uniform(1 / 5.5, 1 / 4, 3)
        depth, _ = draw([triangle / SUBPIXELS], reversed_z, size=size)
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
        transform = ViewTransform(matrix, 30.0, 21.0, 0.05, is_perspective)
        project(vertices, transform, seen)
        geometry, order = geometry_of(seen, transform, 0)
        indices = np.empty(4001, np.int32)
        count, _, _ = triangles_in_rows(order, 0, HEIGHT, indices)
        # The rows lie between margins that must stay as they are.
        depth = np.full(size + 2 * margin, np.float32(-1e30))
        colour = np.full(size + 2 * margin, 77, np.uint32)
        target = Target(colour[margin:margin + size], depth[margin:margin + size],
                        NO_FACES, 0, HEIGHT, WIDTH, STRIDE)
        rasterize(geometry, Colours(np.full((12000, 2, 3), 128.0), False), indices[:count],
                  RasterizerState(np.int32(0), np.int32(0), np.float32(np.inf), False, True),
                  target, BATCH, POLYGON, None)
        for buffer, clear in ((depth, np.float32(-1e30)), (colour, 77)):
            assert (buffer[:margin] == clear).all() and (buffer[-margin:] == clear).all()
        assert np.isfinite(depth).all()
        assert set(np.unique(colour)) == {77, 128 | 128 << 8 | 128 << 16}
