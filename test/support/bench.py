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

"""A physics node in this process, fed with messages as the network would feed it."""
from flag_sim.cloth import Cloth
from flag_sim.nodes.physics import Physics
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
import numpy as np
import rclpy
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2
from support.frames import parameters_message
from support.nodes import hear

WIND = (6.0, 2.0, 0.5)
FRAME = 1.0 / 30.0  # [s]
COUNT = 12  # frames that are played where no other number matters


class Bench:
    """
    The node and what it answers; nothing is spun, every call is the whole of its work.

    ROS must have been initialised; `close` the bench at the end. waits: whether a call spins the
    node while it compiles for a solver that was never compiled here.
    """

    def __init__(self, waits=True):
        self._waits = waits
        self.node = Physics()
        self.clouds = []
        publish = self.node.answer

        def answer(stamp, cloud):
            self.clouds.append(deserialize_message(cloud, PointCloud2))
            publish(stamp, cloud)
        self.node.answer = answer
        self._index = 0

    def hear(self, message):
        """Let a message arrive on `parameters`; return the cloud that answers it, or None."""
        before = len(self.clouds)
        hear(self.node, 'parameters', message)
        while self._waits and self.node.is_compiling:
            rclpy.spin_once(self.node, timeout_sec=0.1)
        return self.clouds[-1] if len(self.clouds) > before else None

    def message(self, time, wind=WIND, keyed=None):
        """Return the `parameters` message of the take's next frame, at a time [s]."""
        frame = FrameId(round(time * 1e9), 1, self._index, self._index)
        self._index += 1
        return parameters_message('/wind', frame, wind, keyed or {})

    def frame(self, time, wind=WIND, keyed=None):
        """Play a frame at a time [s]; return the positions (rows, columns, 3) [m], or None."""
        cloud = self.hear(self.message(time, wind, keyed))
        return None if cloud is None else messages.read_cloud(cloud)[0]

    def put(self, **values):
        """Set parameters, all of them or none, as the service does; return its result."""
        return self.node.set_parameters_atomically(
            [Parameter(name, value=value) for name, value in values.items()])

    def close(self):
        """End the node."""
        self.node.destroy_node()


def advance(cloth, n):
    """Move a cloth of the library to frame n; stamps are whole nanoseconds."""
    cloth.advance((round(n * FRAME * 1e9) - round((n - 1) * FRAME * 1e9)) * 1e-9, WIND)


def library(frames, cloth=None):
    """Return the positions after so many frames by the library alone, as the node sends them."""
    cloth = cloth or Cloth()
    for n in range(1, frames):
        advance(cloth, n)
    return cloth.positions.astype(np.float32)


def play(bench, frames, start=0):
    """Play frames of a thirtieth of a second; return the last one's positions."""
    for n in range(start, start + frames):
        positions = bench.frame(n * FRAME)
    return positions
