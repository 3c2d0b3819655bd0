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

"""Bags as tests make and read them."""
from flag_sim.ros import messages
from flag_sim.ros.bag import Bag, RecordedTopics
import numpy as np
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image

FRAME = 10**9 // 25
"""Between two frames [ns]."""


def recorded(path, name):
    """Return [(name, time in the bag [ns], serialised message)] of a topic."""
    bag = RecordedTopics(path)
    try:
        return list(bag.messages([name]))
    finally:
        bag.close()


def images_bag(path, images, compression='zstd'):
    """Make a bag of images of 1.2 MB, one to a chunk; return its one mcap file."""
    bag = Bag(path, 'mcap', compression)
    bag.add_topic('/camera/image_raw', Image)
    noise = np.random.default_rng(1).integers(0, 256, (400, 1000, 3), np.uint8)
    for index in range(images):
        bag.write('/camera/image_raw', index * FRAME,
                  serialize_message(messages.image_message(index * FRAME, noise)))
    bag.close()
    return next(path.glob('*.mcap'))
