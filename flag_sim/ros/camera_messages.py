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

"""What the camera publishes: for each topic the message that is made of a frame."""
from collections.abc import Callable
import functools
import importlib.util
import io
from typing import NamedTuple

from flag_sim.drawing import Camera, Frame, transforms
from flag_sim.drawing.mesh import grid_triangles
from flag_sim.ros import messages, serialized
from flag_sim.ros.messages import WORLD
from geometry_msgs.msg import (
    Point, Pose, PoseStamped, Quaternion, Transform, TransformStamped, Vector3)
import numpy as np
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

PNG_LEVEL = 3  # as image_transport's


class Shot(NamedTuple):
    """
    All that the messages of a frame are made of.

    stamp [ns]; camera, frame_id: of the frame; frame: what was drawn; vertices: (rows, columns, 3)
    [m]; values: {parameter: value} of the renderer.
    """

    stamp: int
    camera: Camera
    frame_id: str
    frame: Frame | None
    vertices: np.ndarray
    values: dict


class CameraTopic(NamedTuple):
    """
    A topic of the camera's.

    channels: of the frame that it needs (see drawing.Picture.draw_scene), or None if it needs no
    picture. message(shot): what is published, also as bytes.
    """

    channels: tuple | None
    message: Callable[[Shot], object]


def _image_of(channel):
    """Return the topic of an image of one channel of the frame."""
    def message(shot):
        pixels = getattr(shot.frame, channel)
        return serialized.image(pixels, shot.frame_id).at(shot.stamp, pixels)
    return CameraTopic(() if channel == 'colour' else (channel,), message)


def _camera_info(shot):
    return serialized.camera_info(shot.camera, shot.frame_id).at(shot.stamp)


def compressed_message(shot: Shot) -> CompressedImage:
    """Return the picture as jpeg or png, named as image_transport does."""
    from PIL import Image as PillowImage
    form, file = shot.values['compressed.format'], io.BytesIO()
    options = ({'quality': shot.values['compressed.jpeg_quality']} if form == 'jpeg' else
               {'compress_level': PNG_LEVEL})
    PillowImage.fromarray(shot.frame.colour).save(file, form, **options)
    message = CompressedImage(header=messages.header(shot.stamp, shot.frame_id),
                              format=f'rgb8; {form} compressed bgr8', check_fields=True)
    return messages.fill(message, np.frombuffer(file.getvalue(), np.uint8))


def _place(camera):
    """Return the position [m] and the orientation of a camera's optical frame in `world`."""
    x, y, z = map(float, camera.position)
    turn = transforms.quaternion(camera.pose.T)
    return {'x': x, 'y': y, 'z': z}, Quaternion(**dict(zip('xyzw', turn)))


def pose_message(shot: Shot) -> PoseStamped:
    """Return where the camera is in `world`: the pose of its optical frame."""
    position, orientation = _place(shot.camera)
    return PoseStamped(header=messages.header(shot.stamp, WORLD), pose=Pose(
        position=Point(**position), orientation=orientation))


def tf_message(shot: Shot):
    """Return the same as the transform from `world` to the camera's frame."""
    from tf2_msgs.msg import TFMessage
    position, rotation = _place(shot.camera)
    return TFMessage(transforms=[TransformStamped(
        header=messages.header(shot.stamp, WORLD), child_frame_id=shot.frame_id,
        transform=Transform(translation=Vector3(**position), rotation=rotation))])


def marker_message(shot: Shot) -> bytes:
    """
    Return a Marker, serialised: the flag as a list of triangles in its colour.

    A Point for each corner would take longer than to draw the picture, so the corners' bytes are
    put between what stands before and after the one point of a marker that is made by ROS.
    """
    color = tuple(channel / 255.0 for channel in shot.values['flag.color'])
    triangles = grid_triangles(*shot.vertices.shape[:2])
    corners = shot.vertices.reshape(-1, 3)[triangles].astype('<f8').tobytes()
    before, after = _around_points(color)
    stamp = messages.to_time(shot.stamp)
    begin = b''.join((before[:4], np.array([stamp.sec], '<i4').tobytes(),
                      np.array([stamp.nanosec], '<u4').tobytes(), before[12:]))
    count = np.array([3 * len(triangles)], '<u4').tobytes()
    # The points are numbers of 8 bytes, which begin at multiples of 8 after the first 4.
    gap = b'\0' * (-(len(begin) + len(count) - 4) % 8)
    return b''.join((begin, count, gap, corners, after))


@functools.lru_cache(maxsize=8)
def _around_points(color):
    """Return the bytes of a flag's Marker before the number of its points, and after them."""
    marker = Marker(header=messages.header(0, WORLD), ns='flag_sim', type=Marker.TRIANGLE_LIST,
                    scale=Vector3(x=1.0, y=1.0, z=1.0),
                    color=ColorRGBA(r=color[0], g=color[1], b=color[2], a=1.0))
    marker.pose.orientation.w = 1.0
    point = [np.pi, np.e, 1.0 / 3.0]  # as no other three numbers of it
    marker.points = [Point(x=point[0], y=point[1], z=point[2])]
    data, sought = serialize_message(marker), np.array(point, '<f8').tobytes()
    at = data.index(sought)
    return data[:data.rindex(np.array([1], '<u4').tobytes(), 0, at)], data[at + len(sought):]


TOPICS = {
    'camera/image_raw': _image_of('colour'),
    'camera/image_raw/compressed': CameraTopic((), compressed_message),
    'camera/camera_info': CameraTopic(None, _camera_info),
    'camera/pose': CameraTopic(None, pose_message),
    'camera/depth/image_raw': _image_of('depth'),
    'camera/depth/camera_info': CameraTopic(None, _camera_info),
    'camera/normals/image_raw': _image_of('normals'),
    'camera/labels/image_raw': _image_of('labels'),
    'camera/texture_coordinates/image_raw': _image_of('texture_coordinates'),
    'camera/flow/image_raw': _image_of('flow'),
    'marker': CameraTopic(None, marker_message),
    '/tf': CameraTopic(None, tf_message),
}
NEEDED = {'camera/image_raw/compressed': 'PIL', '/tf': 'tf2_msgs'}
"""Of topics that are only there where something is installed, what."""


def available() -> list[str]:
    """Return the names of the TOPICS that this machine can publish."""
    return [name for name in TOPICS if importlib.util.find_spec(NEEDED.get(name, 'numpy'))]
