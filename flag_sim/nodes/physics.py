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

"""The physics node: moves the cloth to the time of every frame and publishes its vertices."""
from collections.abc import Mapping, Sequence
import sys
import time

from flag_sim.cloth.simulation import MAX_WIND
from flag_sim.declarations.moving_cloth import CLOTH_KERNELS, MovingCloth
from flag_sim.declarations.physics import check_method, PHYSICS
from flag_sim.declarations.scene import check_scene
from flag_sim.parameters import checks
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.stamp_buffer import StampBuffer
from flag_sim.ros import messages, serialized
from flag_sim.ros.compiling import compiling
from flag_sim.ros.diagnostics import ERROR, WARN
from flag_sim.ros.frame_node import FrameNode
from flag_sim.ros.kernel_switch import KernelSwitch
from flag_sim.ros.lifecycle import run
from flag_sim.ros.topics import DEPTH, publish
import numpy as np


class Physics(FrameNode):
    """
    Publishes `vertices` for every frame that `parameters` announces.

    A frame's wind and values apply to the whole time from the previous frame to it (a zero-order
    hold), so where they change the motion depends on `rate`, to first order in its period.

    A cloth that starts over (in a take's first frame, or when its size changes) first moves for
    `preroll` seconds in that frame's wind, so it depends on nothing but this frame and the
    parameters: it is the same in lockstep, in real time, after a reset and from a bag.

    A solver or precision that was never compiled here is compiled beside: see KernelSwitch.
    """

    def __init__(self):
        super().__init__('physics', PHYSICS)
        self._busy = 0.0  # how long the last frame took [s]
        with compiling(self, CLOTH_KERNELS.name(self.values)):
            self._cloth = MovingCloth(self.values)
            CLOTH_KERNELS.warm_up(self.values)
        self._kernels = KernelSwitch(self, CLOTH_KERNELS, self.values, self._server.serve)
        self._vertices_out = publish(self, 'vertices')
        self._load_out = publish(self, 'pole_load')
        self._loads = StampBuffer(DEPTH)  # messages on pole_load
        self.get_logger().info(
            f'{self.values["grid.columns"]} x {self.values["grid.rows"]} nodes, '
            'waiting for frames')

    def check(self, values: Mapping) -> None:
        """Raise ValueError for values that make no scene, or that the solver cannot take."""
        check_scene(values)
        check_method(values)

    def check_wind(self, wind: np.ndarray) -> None:
        """Raise ValueError for a wind (3,) [m/s] beyond MAX_WIND."""
        checks.vector('wind', wind, MAX_WIND)

    def restart(self, frame: FrameId) -> None:
        """Lay the cloth out again."""
        del frame
        self._kernels.restart()
        self._cloth.restart()
        self._loads.keep(())

    @property
    def is_compiling(self) -> bool:
        """Return whether kernels for other values are compiled beside."""
        return self._kernels.is_compiling

    def is_ready(self, frame: FrameId) -> bool:
        """Return whether the frame's kernels are ready, or others are to do."""
        _, keyed = self._server.inputs[frame]
        return self._kernels.may_serve(frame, {**self.values, **keyed})

    def work(self, frame: FrameId, wind: np.ndarray, values: Mapping) -> bytes:
        """Return the frame's PointCloud2, serialised."""
        begin = time.monotonic()
        self._warn_if_joined(frame, values)
        values = self._kernels.usable(values)
        # A pre-roll of a fine grid takes a while: Ctrl-C ends it.
        entries = self._cloth.advance_to(frame.stamp, wind, values, self.context.ok)
        for entry in entries:
            self._log.write_once(entry, 'steps')
        if self._cloth.divergence:
            self._log.error(self._cloth.divergence)
        if self._cloth.gap:
            self._log.warn(f'{self._cloth.gap:.3f} s between two frames is more than max_gap = '
                           f'{values["max_gap"]:g} s: it is not simulated; '
                           f'{self._cause_of_gap(self._cloth.gap)}')
        self._busy = time.monotonic() - begin
        # There is none where a signal has ended the context.
        if self.context.ok() and self._load_out.get_subscription_count():
            self._loads.put(frame.stamp, messages.wrench_message(
                frame.stamp, *self._cloth.pole_load(wind)))
        positions = self._cloth.positions
        points = np.concatenate([positions, self._cloth.normals()], axis=2, dtype=np.float32)
        return serialized.cloud(*positions.shape[:2]).at(frame.stamp, points)

    def _warn_if_joined(self, frame, values):
        """Warn where the first frame that is served is not the first of its take."""
        if self._cloth.time is None and frame.take is not None and frame.index > 0:
            state = 'from its preroll' if values['preroll'] > 0.0 else 'at rest'
            self._log.warn(f'joined the take at frame {frame.index}: the cloth begins {state} '
                           'there; reset for a whole take')

    def _cause_of_gap(self, gap):
        """Return why no frame was served for so long, or what can be done about it, in words."""
        if self._busy < 0.5 * gap:  # they were not sent, or not by this clock
            return 'a greater max_gap would simulate them'
        return f'physics itself was busy for {self._busy:.1f} s with the frame before'

    def status(self) -> tuple[bytes, str, dict]:
        """Return the level, a message and what the cloth and its steps are like."""
        level, message, _ = super().status()
        if self._cloth.divergence:
            level, message = ERROR, self._cloth.divergence
        elif self._cloth.softness():
            level, message = WARN, self._cloth.softness()
        return level, message, self._cloth.figures()

    def answer(self, stamp: int, answer: bytes) -> None:
        """Publish the frame's vertices and, for who has listened, the load on its pole."""
        with self._stopwatch.measure('publish'):
            if stamp in self._loads:
                self._load_out.publish(self._loads[stamp])
            self._vertices_out.publish(answer)

    def close(self) -> None:
        """End what is compiled beside; log where the time went."""
        self._kernels.close()
        super().close()


def main(args: Sequence[str] | None = None) -> int:
    """Run the physics node; return the exit status."""
    return run(Physics, args)


if __name__ == '__main__':
    sys.exit(main())
