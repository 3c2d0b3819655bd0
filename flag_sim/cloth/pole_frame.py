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
The pole's frame of reference, in which the cloth is computed while the pole moves.

In it the pole is upright and still, whatever it does in the world: hoist, attachment and collision
need know nothing of its motion. What acts from outside is turned instead: the wind is that which
blows past the pole, and gravity points to where down is in the world.

    world = P(t) + R(t) own    (a turn and a shift: the source's eqs. 2.1 and 2.3 to 2.5)

Within a frame of the shot, P goes straight on at a constant velocity and R turns about a constant
axis at a constant rate, its spin. A steady P' is no force (Galilei): when it changes, from one
frame of the shot to the next, free nodes keep their velocity in the world. A spin is one, also
while it is steady: see turning.
"""
from collections.abc import Iterator, Sequence
import math
from typing import NamedTuple

from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.records import Vector
from flag_sim.cloth.state import State
from flag_sim.cloth.turning import rotation
from flag_sim.parameters import checks
import numpy as np

MAX_PLACE = 1e6
"""Greatest coordinate of a pole's base [m]."""
RIGID_TOLERANCE = 1e-9
"""By how much the columns of a pose may differ from those of a rotation."""
FASTEST_HOIST = 200.0
"""
Greatest speed of the hoist that the cloth follows [m/s]: that of the strongest wind.

What is faster is no motion but another place: see Cloth.advance.
"""
FASTEST_SPIN = 100.0
"""Greatest rate of turning that the cloth follows [rad/s]: half a turn in a frame of 1/30 s."""
LARGEST_TURN = 0.01
"""How far a pole may turn while wind and gravity keep their direction in its frame [rad]."""


def checked_pose(pose: np.ndarray) -> np.ndarray:
    """Return a pose (4, 4), read-only; raise ValueError for what is no turn and shift."""
    pose = checks.array('pose', pose, (4, 4), MAX_PLACE).copy()
    turn = pose[:3, :3]
    checks.require(
        np.abs(turn @ turn.T - np.eye(3)).max() <= RIGID_TOLERANCE and np.linalg.det(turn) > 0.0
        and np.array_equal(pose[3], [0.0, 0.0, 0.0, 1.0]), 'pose', 'a turn and a shift alone',
        pose.tolist())
    pose.flags.writeable = False
    return pose


def turn_between(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return the vector (3,) [rad] along the axis by which `before` turns into `after` (3, 3)."""
    if np.array_equal(before, after):
        return np.zeros(3)
    m = before.T @ after
    sine = 0.5 * np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    size, cosine = math.hypot(*sine), 0.5 * (np.trace(m) - 1.0)
    angle = math.atan2(size, cosine)
    if cosine > -0.5:
        return sine * (angle / size if size > 0.0 else 1.0)
    # Near half a turn the sine says little of the axis; the longest column of a a^T says it all.
    columns = 0.5 * (m + m.T) - cosine * np.eye(3)
    axis = columns[:, np.argmax(np.diag(columns))]
    return axis * (math.copysign(angle, axis @ sine) / np.linalg.norm(axis))


class PoleFrame(NamedTuple):
    """
    Where the pole is, and how it moves on from there.

    velocity: of its base in the world [m/s]. spin: rate of turning about its base, in its own
    axes [rad/s].
    """

    pose: np.ndarray = checked_pose(np.eye(4))
    velocity: np.ndarray = np.zeros(3)
    spin: np.ndarray = np.zeros(3)

    @property
    def is_world(self) -> bool:
        """Return whether the frame is the world's own, at rest in it."""
        return np.array_equal(self.pose, np.eye(4)) and not (self.velocity.any()
                                                             or self.spin.any())

    def standing(self) -> 'PoleFrame':
        """Return the frame of a pole that stands where this one is."""
        is_moving = self.velocity.any() or self.spin.any()
        return PoleFrame(self.pose) if is_moving else self

    def moving_to(self, pose: np.ndarray, dt: float) -> 'PoleFrame':
        """Return this frame on its way to another pose, which it reaches in dt [s]."""
        return self._replace(
            velocity=(pose[:3, 3] - self.pose[:3, 3]) / dt,
            spin=turn_between(self.pose[:3, :3], pose[:3, :3]) / dt)

    def after(self, time: float) -> 'PoleFrame':
        """Return the frame as it is a time [s] later."""
        pose = self.pose.copy()
        pose[:3, 3] += time * self.velocity
        pose[:3, :3] = pose[:3, :3] @ rotation(time * self.spin)
        return self._replace(pose=pose)

    def way_to(self, pose: np.ndarray, dt: float, mesh: Mesh,
               hoist_top: Vector) -> tuple['PoleFrame', bool]:
        """
        Return this frame on its way to another pose, which it reaches in dt [s], and False.

        Where that is too fast for the hoist of a mesh it is there at once: then True.
        """
        if np.array_equal(pose, self.pose):
            return self.standing(), False
        moving = self.moving_to(pose, dt)
        if moving.is_too_fast(mesh.hoist(hoist_top)):
            return PoleFrame(pose), True
        return moving, False

    def is_too_fast(self, points: np.ndarray) -> bool:
        """Return whether one of some points of it (n, 3) [m], or its turning, is too fast."""
        speed = math.hypot(*self.velocity) + np.linalg.norm(
            np.cross(self.spin, points), axis=-1).max()
        return speed > FASTEST_HOIST or math.hypot(*self.spin) > FASTEST_SPIN

    # Between the world and this frame.

    def to_world(self, own: np.ndarray) -> np.ndarray:
        """Return points (..., 3) [m] of this frame in the world."""
        return own if self.is_world else own @ self.pose[:3, :3].T + self.pose[:3, 3]

    def from_world(self, points: np.ndarray) -> np.ndarray:
        """Return points (..., 3) [m] of the world in this frame."""
        return points if self.is_world else (points - self.pose[:3, 3]) @ self.pose[:3, :3]

    def velocities_to_world(self, own: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        """Return velocities (..., 3) [m/s] in this frame, of points of it, in the world."""
        if self.is_world:
            return velocities
        return (velocities + np.cross(self.spin, own)) @ self.pose[:3, :3].T + self.velocity

    def velocities_from_world(self, own: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        """Return velocities (..., 3) [m/s] in the world, of points of this frame, in it."""
        if self.is_world:
            return velocities
        return (velocities - self.velocity) @ self.pose[:3, :3] - np.cross(self.spin, own)

    def direction(self, vector: Sequence[float]) -> Vector:
        """Return a vector (3,) of the world in this frame's axes."""
        if np.array_equal(self.pose[:3, :3], np.eye(3)):
            return tuple(map(float, vector))
        return tuple((np.asarray(vector) @ self.pose[:3, :3]).tolist())

    def seen(self, forcing: Forcing) -> Forcing:
        """Return a forcing of the world as it is in this frame."""
        if self.is_world:
            return forcing
        wind, drift = np.asarray(forcing.wind), np.zeros(3)
        if forcing.air.law == 'seed':  # which does not ask what the wind blows past
            drift = self.velocity
        else:
            wind = wind - self.velocity
        return forcing._replace(wind=self.direction(wind), up=self.direction(forcing.up),
                                spin=tuple(self.spin.tolist()), drift=self.direction(drift))

    def own(self, positions: np.ndarray, velocities: np.ndarray | None, mesh: Mesh) -> tuple:
        """Return what State.place takes of positions and velocities in the world."""
        if self.is_world:
            return positions, velocities
        shape = (mesh.rows, mesh.columns, 3)
        positions = checks.array('positions', positions, shape, checks.LARGEST)
        own = self.from_world(positions)
        if velocities is None:
            return own, None
        velocities = checks.array('velocities', velocities, shape, checks.LARGEST)
        return own, self.velocities_from_world(own, velocities)

    def hand_over(self, other: 'PoleFrame', state: State) -> None:
        """See a state's velocities from another motion of the same pose from now on."""
        if other is not self:
            state.accelerate(self.change_to(other, state.positions()))

    def change_to(self, other: 'PoleFrame', own: np.ndarray) -> np.ndarray:
        """
        Return by how much velocities change that are seen from another motion of the same pose.

        own: the points (..., 3) [m].
        """
        velocity, spin = self.velocity - other.velocity, self.spin - other.spin
        return np.cross(spin, own) + velocity @ self.pose[:3, :3]

    def pieces(self, count: int, step: float) -> Iterator[tuple['PoleFrame', int]]:
        """
        Divide the way of count steps [s] so that the frame turns little in each piece.

        Yields the frame in the middle of each piece, and how many steps it has.
        """
        if not self.spin.any():
            yield self, count
            return
        angle = math.hypot(*self.spin) * count * step
        number = min(max(math.ceil(angle / LARGEST_TURN), 1), count)
        for piece in range(number):
            first, last = (count * end // number for end in (piece, piece + 1))
            yield self.after(0.5 * (first + last) * step), last - first
