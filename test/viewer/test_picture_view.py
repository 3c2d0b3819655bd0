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

"""What is drawn of an image, by its encoding and the room that there is."""
from flag_sim.protocol.cdr_image import ImageBytes
from flag_sim.viewer.picture_view import FORMATS, PictureView, to_image
import numpy as np
import pytest
from qtpy.QtGui import QColor
from support.window import application


def picture(encoding, width, height, step, pixels):
    """Return an image of these bytes."""
    return ImageBytes(0, height, width, encoding, False, step, memoryview(pixels))


@pytest.mark.parametrize('encoding', FORMATS)
@pytest.mark.parametrize('width, padding', [(1, 0), (5, 3), (64, 0)])
def test_every_pixel_is_that_of_the_message(encoding, width, padding):
    """Whatever its encoding, and however its rows are padded."""
    size, height = FORMATS[encoding][1], 3
    pixels = np.random.default_rng(1).integers(0, 256, (height, width, size), np.uint8)
    if size == 4:
        pixels[..., 3] = 255
    rows = np.pad(pixels.reshape(height, -1), ((0, 0), (0, padding)))
    image, reason = to_image(picture(encoding, width, height, rows.shape[1], rows.tobytes()))
    assert not reason and (image.width(), image.height()) == (width, height)
    order = [2, 1, 0] if encoding.startswith('bgr') else [0, 1, 2] if size > 1 else [0, 0, 0]
    for v in range(height):
        for u in range(width):
            colour = QColor(image.pixel(u, v))
            assert (colour.red(), colour.green(), colour.blue()) == tuple(pixels[v, u, order])


@pytest.mark.parametrize('encoding, width, height, step, words', [
    ('32FC1', 2, 2, 8, "of the encoding '32FC1'; shown here are rgb8"),
    ('rgb8', 0, 2, 0, 'no pixels: 0 x 2'), ('rgb8', 2, 2, 5, 'rows of 5 bytes, too few for 2')])
def test_what_cannot_be_shown_says_why(encoding, width, height, step, words):
    image, reason = to_image(picture(encoding, width, height, step, bytes(height * step)))
    assert image is None and words in reason


@pytest.mark.parametrize('room, drawn', [
    ((640, 480), (640, 480)), ((1300, 970), (1280, 960)), ((320, 480), (320, 240)),
    ((1000, 480), (640, 480)), ((960, 2000), (960, 720))])
def test_the_picture_keeps_its_aspect_and_is_in_the_middle(room, drawn):
    """Where whole screen pixels nearly fill the room it is drawn in them: that is sharp."""
    application()
    view = PictureView()
    view.resize(*room)
    image, _ = to_image(picture('mono8', 640, 480, 640, bytes(640 * 480)))
    view.show_image(image)
    target = view.target()
    assert (target.width(), target.height()) == drawn
    assert abs(target.left() + target.right() - room[0]) <= 2


def test_what_is_drawn_is_the_image_with_its_reason_below():
    application()
    view = PictureView()
    view.resize(320, 240)
    rng = np.random.default_rng(2)
    pixels = rng.integers(0, 256, (240, 320, 3), np.uint8)
    view.show_image(to_image(picture('rgb8', 320, 240, 960, pixels.tobytes()))[0])

    def drawn():
        grabbed = view.grab().toImage()
        return np.array([[QColor(grabbed.pixel(u, v)).getRgb()[:3] for u in range(0, 320, 9)]
                         for v in range(0, 240, 7)])
    np.testing.assert_array_equal(drawn(), pixels[::7, ::9])
    view.set_reason('The wind is paused.')
    after = drawn()
    np.testing.assert_array_equal(after[:20], pixels[::7, ::9][:20])  # the picture stays
    assert (after[-4] != pixels[::7, ::9][-4]).any()
