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

"""A node of the benchmark's own: it feeds others as fast as they take it, or hears the wind."""
import time

from flag_sim.protocol.cdr import serialized_stamp
from flag_sim.ros import messages
from flag_sim.ros.bag import RecordedTopics
from flag_sim.ros.dds_profile import set_dds_profile
from flag_sim.ros.lifecycle import keep_memory
from flag_sim.ros.topics import publish, subscribe
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor

WINDOW = 3  # frames in flight, as wind's
RESEND_AFTER = 0.2  # [s]
PATIENCE = 20.0  # how long a probe waits for anything [s]
IMAGES = ('camera/image_raw', 'camera/camera_info')
# What each node is fed, and what it says of a frame that it has done.
INPUTS = {'physics': ('parameters',), 'renderer': ('parameters', 'vertices'),
          'recorder': ('parameters', 'vertices', *IMAGES)}
ANSWERS = {'physics': 'vertices', 'renderer': 'frame_done', 'recorder': 'frame_done'}


class Probe:
    """A node in a ROS domain, to be used in a with statement."""

    def __init__(self, domain):
        keep_memory()
        set_dds_profile()
        self._context = rclpy.Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = rclpy.create_node('probe', context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.shutdown()

    def wait(self, is_done, work=lambda: None):
        """Answer callbacks, and work, until something is done; raises TimeoutError."""
        end = time.monotonic() + PATIENCE
        while not is_done():
            if time.monotonic() > end:
                raise TimeoutError('a node does not answer the benchmark')
            work()
            self._executor.spin_once(timeout_sec=0.01)


def recorded_frames(path, count):
    """Return the first whole frames of a bag, serialised: {stamp [ns]: {topic: bytes}}."""
    bag = RecordedTopics(path)
    frames = {}
    for name, at, data in bag.messages(INPUTS['recorder']):
        if len(frames) == count and at not in frames:
            break
        frames.setdefault(at, {})[name] = data
    bag.close()
    return {at: frame for at, frame in frames.items() if len(frame) == len(INPUTS['recorder'])}


def feed(probe, name, frames):
    """
    Return how many frames a second a running node does that never waits for its input.

    A few frames are always in flight, and all that is on the machine is this node and the probe.
    """
    outputs = {topic: publish(probe.node, topic) for topic in INPUTS[name]}
    done, in_flight, left = {}, {}, iter(frames.items())

    def hear(data):
        stamp = serialized_stamp(data)
        if in_flight.pop(stamp, None):
            done[stamp] = time.perf_counter()
    answers = subscribe(probe.node, ANSWERS[name], hear, raw=True)
    if name == 'renderer':  # draws only what somebody listens to
        for topic in IMAGES:
            subscribe(probe.node, topic, lambda _: None, raw=True)
    probe.wait(lambda: all(out.get_subscription_count() for out in outputs.values())
               and probe.node.count_publishers(answers.topic_name))

    def send(stamp, frame):
        for topic, out in outputs.items():
            out.publish(frame[topic])
        in_flight[stamp] = frame, time.perf_counter()

    def keep_busy():
        while len(in_flight) < WINDOW and (following := next(left, None)):
            send(*following)
        # Large messages are lost now and then; wind too sends again what is not answered.
        for stamp, (frame, sent) in list(in_flight.items()):
            if time.perf_counter() - sent > RESEND_AFTER:
                send(stamp, frame)
    probe.wait(lambda: len(done) == len(frames), keep_busy)
    return rate(list(done.values()))


def answer_wind(probe, count):
    """Return how many frames a second the wind sends in lockstep if each is done at once."""
    done = publish(probe.node, 'frame_done')
    times = []

    def answer(message):
        times.append(time.perf_counter())
        done.publish(messages.header(messages.to_stamp(message.stamp), 'renderer'))
    subscribe(probe.node, 'parameters', answer)
    probe.wait(lambda: len(times) >= count)
    return rate(times)


def rate(times):
    """Return frames per second; the first quarter, in which everything warms up, is left out."""
    times = times[len(times) // 4:]
    return (len(times) - 1) / (times[-1] - times[0])


def sending_jitter(probe, frames_per_second, count):
    """
    Return how far from an even beat the wind sends frames [ms]: (median, 99th percentile).

    By the time that the middleware stamps a message with as it is published. The beat is the
    stamps', set so that half of the frames come before it.
    """
    late = []

    def hear(message, info):
        late.append(info['source_timestamp'] - messages.to_stamp(message.stamp))
    subscribe(probe.node, 'parameters', hear)
    for topic in IMAGES:  # lest the renderer has nothing to do
        subscribe(probe.node, topic, lambda _: None, raw=True)
    probe.wait(lambda: len(late) >= 0.9 * count)
    late = np.array(late[round(frames_per_second):], float)  # the first second brings all together
    return tuple(1e-6 * np.percentile(np.abs(late - np.median(late)), (50, 99)))
