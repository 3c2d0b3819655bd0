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

"""Coverage against exact whole-number arithmetic."""
from flag_sim.drawing.culling import LARGE, MEDIUM, SMALL
from flag_sim.drawing.geometry import SUBPIXELS

import numpy as np

import pytest

from support.triangles import covered, draw, HEIGHT, some_triangles, WIDTH

KINDS = ['random', 'sliver', 'small', 'narrow', 'centres', 'halves', 'axes', 'huge', 'huge sliver']


@pytest.mark.parametrize('kind, size', [
    *((kind, None) for kind in KINDS), ('small', LARGE), ('small', MEDIUM), ('narrow', LARGE),
    ('narrow', SMALL)])
def test_coverage_is_exact(kind, size):
    rng = np.random.default_rng(2021)
    some = False
    for triangle in some_triangles(kind, 1500, rng):
        depth, _ = draw([triangle / SUBPIXELS], size=size)
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
