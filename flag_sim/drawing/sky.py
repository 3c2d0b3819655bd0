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

"""
The sky: from the colour at the horizon to that of the zenith, where pixels see nothing.

By the sine s of the elevation at which a pixel looks, the zenith's share is s (2 - s), which
changes fastest at the horizon, and none below it. It is around the whole scene, wherever the
camera looks and however it is turned; an orthographic camera looks the same way everywhere.
"""
from typing import NamedTuple

from flag_sim.drawing.camera import Camera
from flag_sim.drawing.pixels import pack_rgb
from flag_sim.drawing.style import Style
from flag_sim.jit.kernels import late_inner_kernel

import numpy as np


class Sky(NamedTuple):
    """
    A sky for the kernels.

    is_seen: whether there is one; horizon, zenith: colours, 0 to 255; up: how much the way of a
    pixel goes upwards at column 0 and row 0, and its changes a column and a row; u, v: the same
    of its parts to the right and down; the part forward is 1.
    """

    is_seen: bool
    horizon: tuple
    zenith: tuple
    up: tuple
    u: tuple
    v: tuple


def sky_of(camera: Camera, style: Style) -> Sky:
    """Return the Sky that a camera sees."""
    right_up, down_up, forward_up = camera.pose[:3, 2]
    scale = 1.0 / camera.focal if camera.is_perspective else 0.0
    begin_u, begin_v = -scale * camera.centre[0], -scale * camera.centre[1]
    up = (forward_up + begin_u * right_up + begin_v * down_up, scale * right_up, scale * down_up)
    return Sky(style.sky_gradient, *(
        tuple(np.float32(value) for value in values) for values in (
            style.background, style.sky_zenith, up, (begin_u, scale), (begin_v, scale))))


@late_inner_kernel
def sky_colour(sky, u, v):
    """Return the colour, as pack_rgb packs it, at column u and row v."""
    x, y = sky.u[0] + sky.u[1] * u, sky.v[0] + sky.v[1] * v
    one = np.float32(1.0)
    up = (sky.up[0] + sky.up[1] * u + sky.up[2] * v) / np.sqrt(x * x + y * y + one)
    up = min(max(up, np.float32(0.0)), one)
    share = up * (np.float32(2.0) - up)
    return pack_rgb(sky.horizon[0] + share * (sky.zenith[0] - sky.horizon[0]),
                    sky.horizon[1] + share * (sky.zenith[1] - sky.horizon[1]),
                    sky.horizon[2] + share * (sky.zenith[2] - sky.horizon[2]))
