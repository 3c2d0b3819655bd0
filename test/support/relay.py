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

"""A relay between two nodes that loses, doubles and delays messages."""
import heapq
import itertools
import os
import random
import threading
import time

from flag_sim.ros.dds_profile import set_dds_profile
from flag_sim.ros.topics import publish
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

WIRE = 'wire/'


def remap(*topics):
    """Return the ROS arguments that turn a node's topics to the relay."""
    return [part for topic in topics for part in ('-r', f'{topic}:={WIRE}{topic}')]


class Relay:
    """
    Passes each of `topics` on from wire/<topic> to <topic>, not faithfully.

    A message is lost, doubled or held back for up to `longest` seconds, each with probability
    `chance`. Works on serialised bytes, in a thread and a ROS context of its own.
    """

    def __init__(self, domain, topics, chance, longest, seed):
        set_dds_profile()
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self._node = Node('relay', context=self._context)
        self._random = random.Random(seed)
        self._chance, self._longest = chance, longest
        self._late = []
        self._count = itertools.count()
        self.lost = self.doubled = self.delayed = 0
        for topic in topics:
            out = publish(self._node, topic)
            self._listen(topic, out)
        self._node.create_timer(0.005, self._send_late)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._executor.spin, daemon=True)

    def _listen(self, topic, out):
        # The topic's type is that of <topic>; only the name is another.
        type_ = out.msg_type
        self._node.create_subscription(
            type_, WIRE + topic, lambda data: self._pass_on(out, data), 50, raw=True)

    def _pass_on(self, out, data):
        draw = self._random.random() / self._chance
        if draw < 1.0:
            self.lost += 1
        elif draw < 2.0:
            self.doubled += 1
            out.publish(data)
            out.publish(data)
        elif draw < 3.0:
            self.delayed += 1
            due = time.monotonic() + self._longest * self._random.random()
            heapq.heappush(self._late, (due, next(self._count), out, data))
        else:
            out.publish(data)

    def _send_late(self):
        while self._late and self._late[0][0] < time.monotonic():
            _, _, out, data = heapq.heappop(self._late)
            out.publish(data)

    def __enter__(self):
        """Begin to relay."""
        self._thread.start()
        return self

    def __exit__(self, *_):
        """Stop."""
        self._executor.shutdown()
        rclpy.shutdown(context=self._context)
        self._thread.join()
        del os.environ['FASTDDS_DEFAULT_PROFILES_FILE']
