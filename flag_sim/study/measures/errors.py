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

"""How wrong a motion is, in pixels of a camera; and pictures at another size."""
from flag_sim.drawing import Camera
import numpy as np

Array = np.ndarray


def on_screen(positions: Array, camera: Camera) -> tuple[Array, Array]:
    """Return (u, v) [pixel] of positions (..., 3) [m], and whether they are in the picture."""
    x, y, z = np.moveaxis(positions @ camera.pose[:3, :3].T + camera.pose[:3, 3], -1, 0)
    # What is nearer than the near plane is not drawn; on it, it is at least far from its place.
    depth = np.maximum(z, camera.near) if camera.is_perspective else 1.0
    u = camera.focal * x / depth + camera.centre[0]
    v = camera.focal * y / depth + camera.centre[1]
    inside = ((np.abs(u - camera.centre[0]) <= 0.5 * camera.width)
              & (np.abs(v - camera.centre[1]) <= 0.5 * camera.height))
    if camera.is_perspective:
        inside &= z >= camera.near
    return np.stack([u, v], axis=-1), inside


def pixel_distances(positions: Array, reference: Array, camera: Camera) -> Array:
    """
    Return how far apart [pixel] vertices (rows, columns, 3) [m] are in the picture: flat.

    Only those are counted whose reference is in the picture; raises ValueError if none is.
    """
    at, _ = on_screen(positions, camera)
    right, seen = on_screen(reference, camera)
    if not seen.any():
        raise ValueError('the camera does not see the flag')
    return np.linalg.norm(at - right, axis=-1)[seen]


def resized(picture: Array, height: int, width: int) -> Array:
    """
    Return a picture (h, w, 3) uint8 as one shows it at another size: (height, width, 3) uint8.

    Smaller ones are enlarged linearly between the centres of pixels; larger ones, of a whole
    multiple of the size, are averaged.
    """
    h, w = picture.shape[:2]
    if (h, w) == (height, width):
        return picture
    image = picture.astype(np.float64)
    if h % height == 0 and w % width == 0:
        image = image.reshape(height, h // height, width, w // width, 3).mean(axis=(1, 3))
    else:
        for axis, (size, wanted) in enumerate(((h, height), (w, width))):
            at = np.clip((np.arange(wanted) + 0.5) * size / wanted - 0.5, 0.0, size - 1.0)
            low = np.minimum(at.astype(int), max(size - 2, 0))
            high = np.minimum(low + 1, size - 1)
            part = (at - low).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
            image = (1.0 - part) * image.take(low, axis) + part * image.take(high, axis)
    return np.rint(image).astype(np.uint8)
