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

"""How wrong a motion or a picture is: in metres, in pixels of a camera, and as people see it."""
import math

from flag_sim.drawing import Camera
import numpy as np

Array = np.ndarray

LUMA = np.array([0.299, 0.587, 0.114])
"""Shares of red, green and blue in what the eye sees as brightness (ITU-R BT.601)."""
SIGMA, REACH = 1.5, 5  # of SSIM's Gaussian window [pixel]: 11 x 11
C1, C2 = (0.01 * 255.0)**2, (0.03 * 255.0)**2  # SSIM's constants against division by zero


def distances(positions: Array, reference: Array) -> Array:
    """Return the distances [m] of vertices (rows, columns, 3) [m]: (rows, columns)."""
    return np.linalg.norm(positions - reference, axis=-1)


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


def psnr(picture: Array, reference: Array) -> float:
    """Return the peak signal-to-noise ratio [dB] of (height, width, 3) uint8, inf if equal."""
    mean_square = np.mean((picture.astype(np.float64) - reference)**2)
    return 10.0 * math.log10(255.0**2 / mean_square) if mean_square > 0.0 else math.inf


def ssim(picture: Array, reference: Array) -> float:
    """
    Return the structural similarity of two pictures (height, width, 3) uint8: 1 if equal.

    Wang, Bovik, Sheikh, Simoncelli, Image Quality Assessment: From Error Visibility to Structural
    Similarity, 2004: of their brightness, as the mean over all windows that fit in the picture.
    """
    x, y = (image @ LUMA for image in (picture, reference))
    mean_x, mean_y = _blur(x), _blur(y)
    var_x, var_y = _blur(x * x) - mean_x**2, _blur(y * y) - mean_y**2
    covariance = _blur(x * y) - mean_x * mean_y
    return float(np.mean((2.0 * mean_x * mean_y + C1) * (2.0 * covariance + C2)
                         / ((mean_x**2 + mean_y**2 + C1) * (var_x + var_y + C2))))


def _blur(image):
    """Return the Gaussian means of all windows inside an image, which lose it its border."""
    at = np.arange(-REACH, REACH + 1)
    weights = np.exp(-0.5 * (at / SIGMA)**2)
    weights /= weights.sum()
    for _ in range(2):
        count = image.shape[0] - 2 * REACH
        image = sum(w * image[k:k + count] for k, w in enumerate(weights)).T
    return image


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
