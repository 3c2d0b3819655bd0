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

"""A clip as a bag: the topics that the nodes would have published, message by message."""
from collections.abc import Iterable, Mapping
from pathlib import Path

from flag_sim.drawing import Frame
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import camera_messages, messages, serialized
from flag_sim.ros.bag import Bag
from flag_sim.ros.frame_message import FrameMessage
from flag_sim.ros.topics import TOPICS
from geometry_msgs.msg import Vector3, Vector3Stamped
import numpy as np
from rosbags.typesys import get_typestore, Stores

ALWAYS = ('parameters',)
"""What every bag has: with it alone the shot can be played again."""

NUMBERS = {'octet': np.uint8, 'boolean': np.bool_, 'int64': np.int64, 'double': np.float64}
"""Of lists in a ParameterValue: the type of their values."""


class ClipBag:
    """
    A new bag at a path.

    topics: names in TOPICS, beside `parameters`; number: of the clip, which is its take.
    """

    def __init__(self, path: Path, topics: Iterable[str], number: int):
        self._topics = (*ALWAYS, *topics)
        self._number = number
        self._bag = Bag(str(path), 'mcap', 'zstd')
        self._message = FrameMessage('/wind')
        self._types = get_typestore(Stores.ROS2_KILTED)
        for name in self._topics:
            self._bag.add_topic(f'/{name}', TOPICS[name].message)

    def write(self, moment: object, frame: Frame | None, values: Mapping) -> None:
        """
        Write a frame's messages.

        moment: with index, stamp [ns], wind (3,), keyed, look, points and pole_load, as those of
        dataset.shot; frame: what was drawn; values: {parameter: value} of the renderer. Raises
        OSError where the disk is full.
        """
        shot = camera_messages.Shot(moment.stamp, moment.look.camera, values['camera.frame_id'],
                                    frame, moment.positions, values)
        for name in self._topics:
            if name == 'parameters':
                data = self._parameters(moment)
            elif name == 'wind':
                data = serialized.without_padding(Vector3Stamped(
                    header=messages.header(moment.stamp, messages.WORLD),
                    vector=Vector3(**dict(zip('xyz', map(float, moment.wind))))))
            elif name == 'pole_load':
                data = serialized.without_padding(messages.wrench_message(
                    moment.stamp, moment.pole_load[:3], moment.pole_load[3:]))
            elif name == 'vertices':
                data = serialized.cloud(*moment.points.shape[:2]).at(moment.stamp, moment.points)
            else:
                data = camera_messages.TOPICS[name].message(shot)
            self._bag.write(f'/{name}', moment.stamp, data)

    def _parameters(self, moment):
        """Return the frame's ParameterEvent, serialised by rosbags, whose padding is always 0."""
        frame = FrameId(moment.stamp, self._number + 1, moment.index, moment.index)
        message = self._message.fill(frame, np.asarray(moment.wind), moment.keyed)
        name = 'rcl_interfaces/msg/ParameterEvent'
        return bytes(self._types.serialize_cdr(_of_rosbags(message, name, self._types.types),
                                               name))

    def close(self) -> None:
        """Finish the file and its metadata; raises OSError where the disk is full."""
        self._bag.close()


def _of_rosbags(message, name, types):
    """Return a message of rclpy's as one of the rosbags library."""
    fields = {}
    for field, kind in message.get_fields_and_field_types().items():
        value, item = getattr(message, field), kind.removeprefix('sequence<').removesuffix('>')
        if '/' in item:
            inner = item.replace('/', '/msg/')
            value = ([_of_rosbags(one, inner, types) for one in value] if item != kind else
                     _of_rosbags(value, inner, types))
        elif item in NUMBERS and item != kind:
            value = np.array([ord(one) if isinstance(one, bytes) else one for one in value],
                             NUMBERS[item])
        fields[field] = value
    return types[name](**fields)
