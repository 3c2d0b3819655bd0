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

"""An ideal camera: where it stands, what it sees, and the matrices that say so to others."""
import dataclasses
import functools
import math

from flag_sim.drawing import ranges, transforms
from flag_sim.parameters import checks
from flag_sim.parameters.declaration import TURN
from flag_sim.parameters.declared import Declared, declared

import numpy as np

PROJECTIONS = ('perspective', 'orthographic')


@dataclasses.dataclass(frozen=True)
class Camera(Declared):
    """
    A camera that circles its target at a distance.

    It stands at target + distance (cos el cos az, cos el sin az, sin el) and looks at the target;
    the right camera of a stereo pair is that same one, moved to its right by a baseline.
    Its optical frame is that of REP 103: x right, y down, z forward. "Right" is the horizontal
    (-sin az, cos az, 0), so that straight up and straight down are views like any other, and so
    is distance 0. Roll turns the camera right-handed about its forward axis: the picture turns
    the other way. Pixel (u, v) has its CENTRE at integer (u, v), as in CameraInfo.

    width, height: [pixel]; projection: one of PROJECTIONS; vertical_fov: [rad], perspective only;
    scale: [m] of world that fill the height, orthographic only; target: (3,) [m]; distance [m];
    azimuth, elevation, roll: [rad]; near: [m], nothing nearer along the optical axis is drawn;
    baseline: [m], 0 for the left camera of a pair, and for one alone.

    Raises ValueError for a value out of its range. Frozen: use dataclasses.replace for another.
    """

    # Sides within the 2^15 pixels for which the rasterizer's exactness is proved.
    width: int = declared(640, 'image width', 'pixels', 1, 7680, name='width')
    height: int = declared(480, 'image height', 'pixels', 1, 4320, name='height')
    projection: str = declared('perspective', 'how space is mapped to the image',
                               choices=PROJECTIONS)
    vertical_fov: float = declared(0.56, 'perspective: angle that the height sees', 'rad',
                                   0.001, 3.1)
    scale: float = declared(3.0, 'orthographic: height that the image shows', 'm', 0.001, 10000.0)
    target: tuple = declared((1.1, 0.0, 7.85), 'point in the middle of the image', 'm', -1e4, 1e4)
    distance: float = declared(5.5, 'from the target', 'm', 0.0, 10000.0)
    azimuth: float = declared(-math.pi / 2.0, 'of the camera seen from the target', 'rad',
                              -TURN, TURN)
    elevation: float = declared(-0.1, 'of the camera seen from the target', 'rad',
                                -math.pi / 2.0, math.pi / 2.0)
    roll: float = declared(0.0, 'turn about the line of sight', 'rad', -TURN, TURN)
    near: float = declared(0.05, 'nothing nearer is drawn', 'm', 0.001, 1000.0)
    baseline: float = declared(0.0, 'to the right of the left camera of a stereo pair', 'm',
                               -1000.0, 1000.0)

    @property
    def is_perspective(self) -> bool:
        """Whether distant things look smaller."""
        return self.projection == 'perspective'

    @functools.cached_property
    def position(self) -> np.ndarray:
        """Where the camera stands: (3,) [m]."""
        return (np.array(self.target) - self.distance * self._axes[2]
                + self.baseline * self._axes[0])

    @functools.cached_property
    def viewpoint(self) -> np.ndarray:
        """
        Return the eye as a homogeneous point (4,): the way from p to it is [:3] - [3] p.

        In orthographic projection it is infinitely far against the optical axis.
        """
        if self.is_perspective:
            return np.append(self.position, 1.0)
        return np.append(-self._axes[2], 0.0)

    @functools.cached_property
    def pose(self) -> np.ndarray:
        """World to optical frame: (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self._axes
        return matrix @ transforms.translate(-self.position)

    @property
    def focal(self) -> float:
        """Perspective: the focal length [pixel]; orthographic: the scale [pixel/m]."""
        if self.is_perspective:
            return 0.5 * self.height / math.tan(0.5 * self.vertical_fov)
        return self.height / self.scale

    @property
    def centre(self) -> tuple:
        """Where the optical axis meets the image: (u, v) [pixel]."""
        return 0.5 * self.width - 0.5, 0.5 * self.height - 0.5

    @functools.cached_property
    def K(self) -> np.ndarray:
        """
        Return the intrinsic matrix of CameraInfo: (3, 3).

        It takes a point of the optical frame to (u, v, 1) z. It is all zero, which is
        CameraInfo's way to say "no pinhole", where the projection is orthographic.
        """
        return self.P[:, :3] if self.is_perspective else np.zeros((3, 3))

    @functools.cached_property
    def P(self) -> np.ndarray:
        """
        Return the projection matrix of CameraInfo, from (x, y, z, 1) to (u, v, 1) w: (3, 4).

        Of a stereo pair both cameras' take points of the left one's optical frame.
        """
        focal, (cu, cv) = self.focal, self.centre
        shift = -focal * self.baseline
        if self.is_perspective:
            return np.array([[focal, 0.0, cu, shift], [0.0, focal, cv, 0.0], [0.0, 0.0, 1.0, 0.0]])
        return np.array([[focal, 0.0, 0.0, cu + shift], [0.0, focal, 0.0, cv],
                         [0.0, 0.0, 0.0, 1.0]])

    def pixels_per_metre(self, distance: float) -> float:
        """Return how long [pixel] a metre across the view is at `distance` [m] from the camera."""
        distance = ranges.number('distance', distance)
        checks.require(distance >= 0.0, 'distance', 'at least 0', distance)
        return self.focal / max(distance, self.near) if self.is_perspective else self.focal

    @functools.cached_property
    def _axes(self):
        """Right, down and forward in the world, one a row: (3, 3)."""
        cos_az, sin_az = math.cos(self.azimuth), math.sin(self.azimuth)
        cos_el, sin_el = math.cos(self.elevation), math.sin(self.elevation)
        level = np.array([[-sin_az, cos_az, 0.0],
                          [sin_el * cos_az, sin_el * sin_az, -cos_el],
                          [-cos_el * cos_az, -cos_el * sin_az, -sin_el]])
        return transforms.rotate_z(-self.roll)[:3, :3] @ level
