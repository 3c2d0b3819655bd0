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

"""What stands in the scene, how large it is and where: pole, platform, ground and boxes."""
import dataclasses
import math
from typing import NamedTuple

from flag_sim.drawing.camera import Camera
from flag_sim.drawing.shading import Surface
from flag_sim.drawing.transforms import rotate_y, rotate_z, translate
from flag_sim.parameters import checks
from flag_sim.parameters.declaration import TURN
from flag_sim.parameters.declared import Declared, declared

import numpy as np

# A circle is cut so finely that its chords miss it by at most this [pixel] ...
ROUNDNESS = 0.2
# ... but neither more coarsely nor more finely than this (both divisible by four: the platform's
# corners each see a quarter of the hole).
FEWEST_SEGMENTS = 8
MOST_SEGMENTS = 256
MOST_BOXES = 250  # as labels are numbers up to 255
SHORTEST_EDGE, LONGEST_EDGE = 0.001, 1000.0  # of a box [m]
FARTHEST = 1e4  # coordinate of a box or of the pole [m]


class Place(NamedTuple):
    """
    Where a thing is that stands at the origin, upright, when it is built.

    position: (x, y, z) [m] of its origin; yaw: its turn about z, tilt: then about its own y, by
    which what was up leans towards its own x [rad].
    """

    position: tuple = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    tilt: float = 0.0

    @property
    def pose(self) -> np.ndarray:
        """Return the map (4, 4) from what was built to the world (eqs. 2.1, 2.4 and 2.5)."""
        return translate(self.position) @ rotate_z(self.yaw) @ rotate_y(self.tilt)

    def seen(self, point: np.ndarray) -> np.ndarray:
        """Return a point (3,) [m] of the world as it is from the thing."""
        if self == Place():
            return point
        pose = self.pose
        return (point - pose[:3, 3]) @ pose[:3, :3]


@dataclasses.dataclass(frozen=True)
class Box:
    """
    A box on its lower face.

    size: (x, y, z) [m], its sides; position: (3,) [m] of the centre of its lower face; yaw: its
    turn about the upright through that [rad]; surface: how it looks.
    Raises ValueError for what is out of range.
    """

    size: tuple = (1.0, 1.0, 1.0)
    position: tuple = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    surface: Surface = Surface((150.0, 140.0, 125.0))

    def __post_init__(self):
        """Refuse what is no box."""
        size = tuple(checks.finite('size', side, SHORTEST_EDGE, LONGEST_EDGE)
                     for side in checks.vector('size', self.size))
        object.__setattr__(self, 'size', size)
        object.__setattr__(self, 'position', checks.vector('position', self.position, FARTHEST))
        object.__setattr__(self, 'yaw', checks.finite('yaw', self.yaw, -TURN, TURN))
        checks.instance('surface', self.surface, Surface)

    @property
    def place(self) -> Place:
        """Return where the box is."""
        return Place(self.position, self.yaw)


@dataclasses.dataclass(frozen=True)
class Dimensions(Declared):
    """
    What stands in the scene: dimensions [m] and place of pole and platform, and what is seen.

    The pole is a cylinder of pole_height with a dome on top, a half sphere whose RADIUS is the
    cylinder's DIAMETER, closed below by a flat ring. The platform is a square box of
    platform_side and platform_height with a hole of the pole's radius through its middle; it goes
    wherever the pole goes, and the ground nowhere. boxes: what else there is.
    Raises ValueError for a value out of its range, and for a hole wider than the platform.
    """

    pole_height: float = declared(9.0, 'height of the pole without its tip', 'm', 0.1, 1000.0,
                                  name='pole.height')
    pole_diameter: float = declared(0.1, 'diameter of the pole; radius of its tip', 'm',
                                    0.001, 10.0, name='pole.diameter')
    pole_position: tuple = declared(
        (0.0, 0.0, 0.0), 'where the centre of its base is; the platform goes with it', 'm',
        -FARTHEST, FARTHEST, name='pole.position')
    pole_yaw: float = declared(0.0, 'turned about the upright through its base, from +x towards '
                               '+y', 'rad', -TURN, TURN, name='pole.yaw')
    pole_tilt: float = declared(0.0, 'leaning from upright, towards where the flag lies at rest',
                                'rad', -math.pi, math.pi, name='pole.tilt')
    platform_side: float = declared(1.0, 'side of the platform, a square', 'm', 0.01, 100.0,
                                    name='platform.side')
    platform_height: float = declared(0.3, 'height of the platform', 'm', 0.01, 100.0,
                                      name='platform.height')
    pole_visible: bool = declared(True, 'draw the pole', name='pole.visible')
    platform_visible: bool = declared(True, 'draw the platform', name='platform.visible')
    ground_visible: bool = declared(False, 'draw the ground, a disc of 1 km around the pole',
                                    name='ground.visible')
    boxes: tuple = ()

    def __post_init__(self):
        """Refuse what cannot be built."""
        super().__post_init__()
        boxes = checks.listed('boxes', self.boxes)
        object.__setattr__(self, 'boxes', tuple(boxes))
        checks.require(len(boxes) <= MOST_BOXES, 'boxes', f'at most {MOST_BOXES}', len(boxes))
        for box in boxes:
            checks.instance('each of boxes', box, Box)
        check_hole(self.platform_side, self.pole_diameter)

    @property
    def place(self) -> Place:
        """Return where the pole is."""
        return Place(self.pole_position, self.pole_yaw, self.pole_tilt)

    def segments(self, camera: Camera) -> int:
        """
        Return in how many chords to cut a circle for `camera`: a multiple of four.

        The dome's circle, the widest, is measured where the pole is nearest to the camera.
        """
        checks.instance('camera', camera, Camera)
        radius = self.pole_diameter
        x, y, z = self.place.seen(camera.position)
        beside = max(z - self.pole_height, -z, 0.0)
        nearest = max(math.hypot(x, y, beside) - radius, 0.0)
        pixels = radius * camera.pixels_per_metre(nearest)
        # The height of a chord's arc, r (1 - cos(pi / n)), is about r (pi / n)^2 / 2.
        wanted = math.pi * math.sqrt(min(0.5 * pixels / ROUNDNESS, MOST_SEGMENTS ** 2))
        return min(max(4 * math.ceil(wanted / 4), FEWEST_SEGMENTS), MOST_SEGMENTS)


def check_hole(side: float, diameter: float, names=('platform_side', 'pole_diameter')) -> None:
    """Raise ValueError, by these names, unless a platform is wider than its pole [m]."""
    checks.require(side > diameter, names[0], f'greater than {names[1]} {diameter}', side)
