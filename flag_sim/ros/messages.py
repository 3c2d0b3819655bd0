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

"""
Arrays to messages and back: pure functions, each with the checks that its message needs.

Stamps are in nanoseconds.
"""
import array
from typing import TYPE_CHECKING

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
import numpy as np
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from std_msgs.msg import Header

if TYPE_CHECKING:  # a wind needs no rasterizer
    from flag_sim.drawing import Camera

WORLD = 'world'
OPTICAL = 'camera_optical_frame'
CLOUD_FIELDS = ('x', 'y', 'z', 'normal_x', 'normal_y', 'normal_z')
FLOATS = {PointField.FLOAT32: 'f4', PointField.FLOAT64: 'f8'}
LATEST = 2**31 * 10**9 - 1
"""Latest time that a Time holds [ns]."""


def to_time(stamp: int) -> Time:
    """Return nanoseconds as a Time."""
    return Time(sec=stamp // 10**9, nanosec=stamp % 10**9)


def to_stamp(time: Time) -> int:
    """Return a Time in nanoseconds."""
    return time.sec * 10**9 + time.nanosec


def checked_stamp(time: Time) -> int:
    """Return a Time in nanoseconds; raise ValueError for one that an answer could not have."""
    stamp = to_stamp(time)
    if stamp > LATEST:
        raise ValueError(f'its stamp of {time.sec} s and {time.nanosec} ns is beyond '
                         f'{LATEST / 1e9:.0f} s')
    return stamp


def header(stamp: int, frame_id: str) -> Header:
    """Return a Header at `stamp` [ns]."""
    return Header(stamp=to_time(stamp), frame_id=frame_id)


def fill(message, values):
    """
    Give a message the bytes of an array as its data; return it.

    An array.array is the one type that a setter does not go through byte by byte, and one that
    checks keeps it; the constructor, and a setter that does not check, would copy it.
    """
    packed = array.array('B')
    packed.frombytes(np.ascontiguousarray(values).view(np.uint8).reshape(-1).data)
    message.data = packed
    return message


def cloud_message(stamp: int, positions: np.ndarray, normals: np.ndarray) -> PointCloud2:
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
    return fill(message, points)


def read_cloud(message: PointCloud2) -> tuple[np.ndarray, np.ndarray | None]:
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
    with np.errstate(invalid='ignore'):  # of a signalling NaN, which is refused below
        values = np.stack(parts, axis=2).astype(np.float64)
    finite = np.isfinite(values)
    if not finite.all():
        row, column, axis = np.argwhere(~finite)[0]
        raise ValueError(f"field '{names[axis]}' of point ({row}, {column}) is "
                         f'{values[row, column, axis]}')
    return values


def wrench_message(stamp: int, force: np.ndarray, moment: np.ndarray) -> WrenchStamped:
    """Return a force [N] and a moment [N m], (3,) each along the axes of `world`."""
    force, moment = (Vector3(**dict(zip('xyz', map(float, one)))) for one in (force, moment))
    return WrenchStamped(header=header(stamp, WORLD), wrench=Wrench(force=force, torque=moment))


def image_message(stamp: int, pixels: np.ndarray, frame_id: str = OPTICAL) -> Image:
    """
    Return an Image of pixels (height, width) or (height, width, channels).

    Three channels of uint8 are rgb8; other uint8 and float32 are 8UCn and 32FCn of n channels.
    """
    height, width = pixels.shape[:2]
    channels = pixels.shape[2] if pixels.ndim == 3 else 1
    kind = '8UC' if pixels.dtype == np.uint8 else '32FC'
    encoding = 'rgb8' if (kind, channels) == ('8UC', 3) else f'{kind}{channels}'
    return fill(Image(header=header(stamp, frame_id), height=height, width=width,
                      encoding=encoding, is_bigendian=False,
                      step=width * channels * pixels.itemsize, check_fields=True), pixels)


def camera_info_message(stamp: int, camera: 'Camera', frame_id: str = OPTICAL) -> CameraInfo:
    """
    Return the CameraInfo of a camera.

    An orthographic camera is no pinhole: its K is left at zero, which CameraInfo defines as
    uncalibrated, and P holds its scale [pixels / m].
    """
    message = CameraInfo(header=header(stamp, frame_id), height=camera.height, width=camera.width,
                         distortion_model='plumb_bob', d=[0.0] * 5, r=np.eye(3).ravel().tolist())
    if camera.projection == 'perspective':
        message.k = camera.K.ravel().tolist()
    message.p = camera.P.ravel().tolist()
    return message
