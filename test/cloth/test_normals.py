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

"""Normals of the grid's nodes, by which the cloth is lit."""
from flag_sim.cloth.normals import node_normals
import numpy as np


def test_normals_of_a_sphere_point_away_from_its_centre():
    """Averaged over faces, they are the surface's to second order in the spacing."""
    def worst(count):
        v, u = np.meshgrid(np.linspace(1.0, 2.0, count), np.linspace(0.0, 1.0, count),
                           indexing='ij')
        sphere = np.stack([np.sin(v) * np.sin(u), np.sin(v) * np.cos(u), np.cos(v)], axis=-1)
        normals = node_normals(sphere)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0, atol=1e-14)
        return np.abs(normals - sphere)[1:-1, 1:-1].max()

    assert worst(11) < 1e-2
    assert worst(21) < 0.3 * worst(11)


def test_normals_of_a_collapsed_cloth_are_still_unit_vectors():
    """Where there is no face there is a default."""
    np.testing.assert_array_equal(node_normals(np.ones((3, 4, 3))),
                                  np.broadcast_to((0.0, 1.0, 0.0), (3, 4, 3)))
