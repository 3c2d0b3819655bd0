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

"""A frame as a ParameterEvent on `parameters`: its place in a take, its wind, its keyed values."""
import array
from collections.abc import Mapping, Sequence
import contextlib
import math

from builtin_interfaces.msg import Time
from flag_sim.protocol.cdr import EventLayout
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
from flag_sim.ros.parameter_node import to_parameter
import numpy as np
from rcl_interfaces.msg import ParameterEvent, ParameterType
from rclpy.parameter import parameter_value_to_python
from rclpy.serialization import deserialize_message, serialize_message

FRAME_NAMES = ('frame.take', 'frame.index', 'frame.oldest')
VALUE_FIELDS = {
    ParameterType.PARAMETER_BOOL: 'bool_value',
    ParameterType.PARAMETER_INTEGER: 'integer_value',
    ParameterType.PARAMETER_DOUBLE: 'double_value',
    ParameterType.PARAMETER_STRING: 'string_value',
    ParameterType.PARAMETER_DOUBLE_ARRAY: 'double_array_value',
}
"""The field of a ParameterValue that holds the value, by its type."""


class FrameMessage:
    """
    The ParameterEvent of one frame after another.

    node_name: of the sender. The message is made once and then only filled, as making one takes
    several times as long; what `fill` returns is good until the next call.
    """

    def __init__(self, node_name: str):
        self._message = ParameterEvent(node=node_name)
        self._names = ()
        self._slots = []  # of each parameter, its value's message and the field that holds it

    def fill(self, frame: FrameId, wind: Sequence[float], keyed: Mapping) -> ParameterEvent:
        """
        Return the message of a frame.

        wind: (3,) [m/s]; keyed: {'node.parameter': value}, each name always of the same type.
        """
        values = {'wind': array.array('d', wind),
                  **dict(zip(FRAME_NAMES, (frame.take, frame.index, frame.oldest))), **keyed}
        if self._names != tuple(values):
            self._make({**values, 'wind': [0.0] * 3})
        for (slot, field), value in zip(self._slots, values.values()):
            setattr(slot, field, value)
        self._message.stamp = messages.to_time(frame.stamp)
        return self._message

    def _make(self, values):
        self._names = tuple(values)
        parameters = [to_parameter(name, value).to_parameter_msg()
                      for name, value in values.items()]
        self._slots = [(parameter.value, VALUE_FIELDS[parameter.value.type])
                       for parameter in parameters]
        self._message.changed_parameters = parameters


def read_parameters(message: ParameterEvent) -> tuple[FrameId, np.ndarray, dict]:
    """
    Return (frame, wind (3,) [m/s], {'node.parameter': value}) of a ParameterEvent of a frame.

    A message without the frame's place in a take, such as one typed by hand, has take None: it is
    ordered by its stamp alone. Raises ValueError for one without a finite wind.
    """
    return _checked(*_values(message))


def _values(message):
    """Return (Time, {name: value}) of a ParameterEvent."""
    try:
        return message.stamp, {p.name: parameter_value_to_python(p.value)
                               for p in message.changed_parameters}
    except RuntimeError as error:  # a type that does not exist
        raise ValueError(str(error)) from None


def _checked(time, values):
    """Return what read_parameters returns of these values."""
    wind = values.pop('wind', ())
    wind = wind.tolist() if hasattr(wind, 'tolist') else wind
    if not (isinstance(wind, (list, tuple)) and len(wind) == 3
            and all(type(w) is float for w in wind)):
        raise ValueError(f'wind must be a list of 3 numbers, not {wind}')
    if not all(map(math.isfinite, wind)):
        raise ValueError(f'wind must be finite, not {list(wind)}')
    stamp = messages.checked_stamp(time)
    place = [values.pop(name, None) for name in FRAME_NAMES]
    if any(type(part) is not int for part in place):
        if place != [None, None, None]:
            raise ValueError(f'{", ".join(FRAME_NAMES)} must be whole numbers, not {place}')
        place = [None, stamp, stamp]
    if not 0 <= place[2] <= place[1]:
        raise ValueError(f'frame.oldest {place[2]} is not from 0 to frame.index {place[1]}')
    return FrameId(stamp, *place), np.array(wind), values


class NoMessage(ValueError):
    """Bytes are no ParameterEvent."""


class FrameReader:
    """
    Reads one frame after another from the bytes of its ParameterEvent.

    Those of one sender differ in their numbers alone. Where these stand is found once, which takes
    as long as to read ten messages field by field, and remembered.
    """

    def __init__(self):
        self._layout = None
        self._values = {}  # of the message that has this layout

    def read(self, data: bytes) -> tuple[FrameId, np.ndarray, dict]:
        """Return what read_parameters does; raise NoMessage, too, for what is none."""
        numbers = self._layout and self._layout.numbers(data)
        if numbers is None:
            try:
                message = deserialize_message(data, ParameterEvent)
            except RuntimeError:  # of the middleware; it names a line in its source
                raise NoMessage(f'its {len(data)} bytes are no ParameterEvent') from None
            time, values = _values(message)
            self._learn(data, values)
        else:
            time = Time(sec=numbers[0], nanosec=numbers[1])
            values = {name: old if new is None else new for (name, old), new in zip(
                self._values.items(), numbers[2:])}
        return _checked(time, values)

    def _learn(self, data, values):
        """Remember where the numbers of a message stand that has just been read."""
        self._layout = None
        with contextlib.suppress(ValueError):
            layout = EventLayout(data)
            found = layout.numbers(data)[2:]
            # A name may come twice; and it is rclpy that knows what a message says.
            if len(found) == len(values) and all(
                    number in (None, value) for number, value in zip(found, values.values())):
                self._layout, self._values = layout, values.copy()


def as_oldest(data: bytes) -> bytes:
    """
    Return a frame's serialised ParameterEvent with the frame itself as the oldest waited for.

    The wind sends a frame again in this way: a node that waits for an older one goes on with this
    one. Bytes that are no such message are returned as they are.
    """
    try:
        message = deserialize_message(data, ParameterEvent)
        frame, _, _ = read_parameters(message)
    except (RuntimeError, ValueError):
        return data
    for parameter in message.changed_parameters if frame.take is not None else ():
        if parameter.name == 'frame.oldest':
            parameter.value.integer_value = frame.index
    return serialize_message(message)
