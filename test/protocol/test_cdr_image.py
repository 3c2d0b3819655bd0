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

"""Images are read from their bytes as rclpy reads them."""
import array

from flag_sim.protocol.cdr_image import read_image
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image


def image(encoding='rgb8', frame_id='camera_optical_frame', width=5, height=3, step=17):
    """Return a message whose rows are padded."""
    message = Image(encoding=encoding, width=width, height=height, step=step, is_bigendian=1)
    message.header.frame_id = frame_id
    message.header.stamp.sec, message.header.stamp.nanosec = 7, 5
    message.data = array.array('B', [n % 256 for n in range(height * step)])
    return message


@pytest.mark.parametrize('frame_id', ['', 'a', 'abc', 'camera_optical_frame'])
@pytest.mark.parametrize('encoding', ['rgb8', 'mono8', '32FC1', 'mono16', 'bayer_rggb16'])
def test_it_is_what_rclpy_reads(encoding, frame_id):
    """Whatever the lengths of the texts, by which all that follows is aligned."""
    message = image(encoding, frame_id)
    read = read_image(serialize_message(message))
    assert read[:6] == (7 * 10**9 + 5, 3, 5, encoding, True, 17)
    assert bytes(read.pixels) == message.data.tobytes()


def test_what_is_no_image_is_refused():
    """Bytes that end anywhere, and rows that do not make up the data."""
    data = serialize_message(image())
    end = data.rindex(bytes([50])) + 1  # of the pixels; what follows them pads the message
    for length in range(0, end):
        with pytest.raises(ValueError):
            read_image(data[:length])
    with pytest.raises(ValueError, match='an image of 3 rows of 16 bytes has 51 bytes'):
        message = image()
        message.step = 16
        read_image(serialize_message(message))
