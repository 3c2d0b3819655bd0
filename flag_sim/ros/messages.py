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

"""Arrays to messages and back: pure functions, each with the checks that its message needs."""
import array
import struct

from builtin_interfaces.msg import Time
from flag_sim.protocol.frames import FrameId
from flag_sim.ros.parameter_node import to_parameter
import numpy as np
from rcl_interfaces.msg import ParameterEvent, ParameterType
from rclpy.parameter import parameter_value_to_python
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from std_msgs.msg import Header

WORLD = 'world'
OPTICAL = 'camera_optical_frame'
CLOUD_FIELDS = ('x', 'y', 'z', 'normal_x', 'normal_y', 'normal_z')
FLOATS = {PointField.FLOAT32: 'f4', PointField.FLOAT64: 'f8'}
FRAME_NAMES = ('frame.take', 'frame.index', 'frame.oldest')
# The field of a ParameterValue that holds what it is the value of.
VALUE_FIELDS = {
    ParameterType.PARAMETER_BOOL: 'bool_value',
    ParameterType.PARAMETER_INTEGER: 'integer_value',
    ParameterType.PARAMETER_DOUBLE: 'double_value',
    ParameterType.PARAMETER_STRING: 'string_value',
    ParameterType.PARAMETER_DOUBLE_ARRAY: 'double_array_value',
}

LATEST = 2**31 * 10**9 - 1  # that a Time holds [ns]


def to_time(stamp):
    """Return nanoseconds as a Time."""
    return Time(sec=stamp // 10**9, nanosec=stamp % 10**9)


def to_stamp(time):
    """Return a Time in nanoseconds."""
    return time.sec * 10**9 + time.nanosec


def serialized_stamp(data):
    """
    Return the stamp [ns] of a serialised message that begins with a Time or a Header.

    CDR: four bytes that say the byte order, then the seconds and the nanoseconds. Raises
    ValueError for a message that is too short for them.
    """
    if len(data) < 12:
        raise ValueError(f'its {len(data)} bytes are too few for a stamp')
    seconds, nanoseconds = struct.unpack_from('<iI' if data[1] & 1 else '>iI', data, 4)
    return seconds * 10**9 + nanoseconds


def header(stamp, frame_id):
    """Return a Header at `stamp` [ns]."""
    return Header(stamp=to_time(stamp), frame_id=frame_id)


def _fill(message, values):
    """
    Give a message the bytes of an array as its data; return it.

    An array.array is the one type that a setter does not go through byte by byte, and one that
    checks keeps it; the constructor, and a setter that does not check, would copy it.
    """
    packed = array.array('B')
    packed.frombytes(np.ascontiguousarray(values).view(np.uint8).reshape(-1).data)
    message.data = packed
    return message


def cloud_message(stamp, positions, normals):
    """
    Return the flag's grid as an organised, dense PointCloud2 in `world`.

    positions [m] and unit normals: (rows, columns, 3); sent as float32.
    """
    rows, columns = positions.shape[:2]
    points = np.concatenate([positions, normals], axis=2, dtype=np.float32)
    fields = [PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1)
              for i, name in enumerate(CLOUD_FIELDS)]
    message = PointCloud2(header=header(stamp, WORLD), height=rows, width=columns, fields=fields,
                          is_bigendian=False, point_step=24, row_step=24 * columns,
                          is_dense=True, check_fields=True)
    return _fill(message, points)


def read_cloud(message):
    """
    Return positions [m] and normals, or None for them: (rows, columns, 3) float64.

    Any layout of the fields, byte order and padding is read. Raises ValueError for a message that
    is not an organised cloud of finite points of at least 2 x 2.
    """
    rows, columns = message.height, message.width
    if rows < 2 or columns < 2:
        raise ValueError(f'a cloud must have at least 2 x 2 points, not {rows} x {columns}')
    if message.row_step < columns * message.point_step:
        raise ValueError(f'row_step {message.row_step} is less than {columns} points of '
                         f'{message.point_step} bytes')
    if len(message.data) < rows * message.row_step:
        raise ValueError(f'{len(message.data)} bytes of data are less than {rows} rows of '
                         f'{message.row_step}')
    fields = {field.name: field for field in message.fields}
    positions = _read_fields(message, fields, CLOUD_FIELDS[:3])
    has_normals = all(name in fields for name in CLOUD_FIELDS[3:])
    normals = _read_fields(message, fields, CLOUD_FIELDS[3:]) if has_normals else None
    return positions, normals


def _read_fields(message, fields, names):
    order = '>' if message.is_bigendian else '<'
    parts = []
    for name in names:
        if name not in fields:
            raise ValueError(f"the cloud has no field '{name}'")
        field = fields[name]
        if field.datatype not in FLOATS:
            raise ValueError(f"field '{name}' must be FLOAT32 or FLOAT64, not type "
                             f'{field.datatype}')
        kind = np.dtype(order + FLOATS[field.datatype])
        if field.offset + kind.itemsize > message.point_step:
            raise ValueError(f"field '{name}' at byte {field.offset} reaches beyond point_step "
                             f'{message.point_step}')
        parts.append(np.ndarray((message.height, message.width), kind, message.data,
                                field.offset, (message.row_step, message.point_step)))
    values = np.stack(parts, axis=2).astype(np.float64)
    finite = np.isfinite(values)
    if not finite.all():
        row, column, axis = np.argwhere(~finite)[0]
        raise ValueError(f"field '{names[axis]}' of point ({row}, {column}) is "
                         f'{values[row, column, axis]}')
    return values


def image_message(stamp, rgb):
    """Return an rgb8 Image of a (height, width, 3) uint8 array."""
    height, width = rgb.shape[:2]
    return _fill(Image(header=header(stamp, OPTICAL), height=height, width=width,
                       encoding='rgb8', is_bigendian=False, step=3 * width,
                       check_fields=True), rgb)


def depth_message(stamp, depth):
    """Return a 32FC1 Image of a (height, width) float32 array [m]."""
    height, width = depth.shape
    return _fill(Image(header=header(stamp, OPTICAL), height=height, width=width,
                       encoding='32FC1', is_bigendian=False, step=4 * width,
                       check_fields=True), depth)


def camera_info_message(stamp, camera):
    """
    Return the CameraInfo of a drawing.camera.Camera.

    An orthographic camera is no pinhole: its K is left at zero, which CameraInfo defines as
    uncalibrated, and P holds its scale [pixels / m].
    """
    message = CameraInfo(header=header(stamp, OPTICAL), height=camera.height, width=camera.width,
                         distortion_model='plumb_bob', d=[0.0] * 5, r=np.eye(3).ravel().tolist())
    if camera.projection == 'perspective':
        message.k = camera.K.ravel().tolist()
    message.p = camera.P.ravel().tolist()
    return message


class FrameMessage:
    """
    The ParameterEvent of one frame after another.

    node_name: of the sender. The message is made once and then only filled, as making one takes
    several times as long; what `fill` returns is good until the next call.
    """

    def __init__(self, node_name):
        self._message = ParameterEvent(node=node_name)
        self._names = ()
        self._slots = []  # of each parameter, its value's message and the field that holds it

    def fill(self, frame, wind, keyed):
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
        self._message.stamp = to_time(frame.stamp)
        return self._message

    def _make(self, values):
        self._names = tuple(values)
        parameters = [to_parameter(name, value).to_parameter_msg()
                      for name, value in values.items()]
        self._slots = [(parameter.value, VALUE_FIELDS[parameter.value.type])
                       for parameter in parameters]
        self._message.changed_parameters = parameters


def parameters_message(node_name, frame, wind, keyed):
    """Return the ParameterEvent of a single frame; see FrameMessage."""
    return FrameMessage(node_name).fill(frame, wind, keyed)


def read_parameters(message):
    """
    Return (frame, wind, keyed) of a ParameterEvent made by `parameters_message`.

    A message without the frame's place in a take, such as one typed by hand, has take None: it is
    ordered by its stamp alone. Raises ValueError for one without a finite wind.
    """
    try:
        values = {p.name: parameter_value_to_python(p.value) for p in message.changed_parameters}
    except RuntimeError as error:  # a type that does not exist
        raise ValueError(str(error)) from None
    wind = np.asarray(values.pop('wind', ()), dtype=object)
    if wind.shape != (3,) or not all(type(w) is float for w in wind):
        raise ValueError(f'wind must be a list of 3 numbers, not {wind.tolist()}')
    wind = wind.astype(float)
    if not np.isfinite(wind).all():
        raise ValueError(f'wind must be finite, not {wind.tolist()}')
    stamp = to_stamp(message.stamp)
    place = [values.pop(name, None) for name in FRAME_NAMES]
    if any(type(part) is not int for part in place):
        if place != [None, None, None]:
            raise ValueError(f'{", ".join(FRAME_NAMES)} must be whole numbers, not {place}')
        place = [None, stamp, stamp]
    if not 0 <= place[2] <= place[1]:
        raise ValueError(f'frame.oldest {place[2]} is not from 0 to frame.index {place[1]}')
    return FrameId(stamp, *place), wind, values


def owed_alone(data):
    """
    Return a serialised ParameterEvent of a frame as one that says: no older frame will come.

    As the wind sends a frame again: who waits for an older one goes on with it. Bytes that are no
    such message are returned as they are.
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
