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

"""A renderer in the process of the test, and all that it publishes of a frame."""
from flag_sim.nodes.renderer import Renderer
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import camera_messages, messages
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from support.frames import parameters_message
from support.watch import eventually, Watcher

FRAME = 40_000_000  # [ns]
TYPES = {'rgb8': (np.uint8, 3), '8UC1': (np.uint8, 1), '32FC1': (np.float32, 1),
         '32FC2': (np.float32, 2), '32FC3': (np.float32, 3)}


class Film:
    """A renderer called `left` in this process, and a node that hears all that it publishes."""

    def __init__(self, domain, *given):
        rclpy.init(domain_id=domain, args=[
            '--ros-args', '-r', '__node:=left', '-p', 'width:=160', '-p', 'height:=120',
            '-p', 'camera.frame_id:=left_eye', *given])
        self.renderer = Renderer()
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.renderer)
        self.watcher = Watcher(domain)
        self.heard = {name: self.watcher.listen(name) for name in camera_messages.available()}
        self.done = self.watcher.listen('frame_done')
        self._parameters, self._vertices = map(self.watcher.publisher, ('parameters', 'vertices'))
        self.wait(lambda: self._parameters.get_subscription_count()
                  and self._vertices.get_subscription_count()
                  and len(self.renderer._listened()) == len(self.heard)
                  and self.renderer._frame_done_out.get_subscription_count())

    def wait(self, condition):
        """Handle messages until a condition holds."""
        eventually(lambda: self._executor.spin_once(timeout_sec=0.01) or condition(), self.watcher)

    def shoot(self, frame, flag, **keyed):
        """Send a frame; return {topic: message} of what is published of it."""
        for messages_heard in (*self.heard.values(), self.done):
            del messages_heard[:]
        keyed = {f'renderer.camera.{name}': value for name, value in keyed.items()}
        self._parameters.publish(parameters_message('wind', frame, [1.0, 0.0, 0.0], keyed))
        self._vertices.publish(messages.cloud_message(frame.stamp, flag, flag))
        self.wait(lambda: self.done and all(self.heard.values()))
        return {name: heard[0] for name, heard in self.heard.items()}

    def close(self):
        """Leave the graph."""
        self.watcher.__exit__()
        self._executor.shutdown()
        self.renderer.destroy_node()
        rclpy.shutdown()


def pixels_of(message):
    """Return an Image's pixels."""
    kind, channels = TYPES[message.encoding]
    pixels = np.frombuffer(message.data, kind).reshape(message.height, message.width, channels)
    return pixels[..., 0] if channels == 1 else pixels


def frame(index, take=1):
    """Return a frame in real time."""
    return FrameId(index * FRAME, take, index, index)
