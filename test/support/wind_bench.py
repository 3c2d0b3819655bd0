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

"""A wind node in this process: every call is the whole of its work, without a network."""
from flag_sim.nodes.wind import Wind
from flag_sim.ros import frame_message
import rclpy
from rclpy.parameter import Parameter
from std_msgs.msg import Empty
from support.nodes import hear


class WindBench:
    """A wind, and what it sends; nothing is spun, every call is the whole of its work."""

    def __init__(self, domain, *arguments):
        given = [part for argument in arguments for part in ('-p', argument)]
        self._ros = rclpy.init(domain_id=domain, args=['--ros-args', *given])
        self.node = Wind()
        self.frames = []  # (frame, wind)
        publish = self.node._parameters_out.publish

        def keep(message):
            self.frames.append(frame_message.read_parameters(message)[:2])
            publish(message)
        self.node._parameters_out.publish = keep

    def hear(self, topic, message):
        """Let a message arrive."""
        hear(self.node, topic, message)

    def put(self, **values):
        """Set parameters as the service does."""
        result = self.node.set_parameters_atomically(
            [Parameter(name.replace('__', '.'), value=value) for name, value in values.items()])
        assert result.successful, result.reason

    def step(self, count=1):
        """Let it send single frames; return the last one's (frame, wind)."""
        for _ in range(count):
            self.hear('step', Empty())
        return self.frames[-1]

    def __enter__(self):
        """Return self."""
        return self

    def __exit__(self, *_):
        """End the node."""
        self.node.destroy_node()
        self._ros.__exit__(*_)
