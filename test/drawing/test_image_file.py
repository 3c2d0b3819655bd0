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

"""Textures from files: what is read, how large ones become smaller, and what is refused."""
import os
import struct
import zlib

from flag_sim.drawing.image_file import _opaque, MOST_PIXELS, read_picture
from flag_sim.drawing.texture import ENCODE, LARGEST
from flag_sim.parameters.config import config_path
from flag_sim.tools.images import HEIGHT, IMAGES, main, WIDTH
from hypothesis import given
import numpy as np
from PIL import Image, ImageOps
import pytest
from support.damage import damaged, inputs


def shown(texture):
    """Return the bytes of a texture's largest mipmap."""
    entries = np.rint(np.sqrt(texture.mipmap(0)) * (len(ENCODE) - 1)).astype(int)
    return np.rint(ENCODE[entries]).astype(np.uint8)


def blots(height, width):
    return np.random.default_rng(5).integers(0, 256, (height, width, 3), np.uint8)


@pytest.mark.parametrize('kind', ['png', 'bmp', 'tiff', 'ppm', 'webp'])
def test_a_file_is_read_as_it_is(tmp_path, kind):
    image = blots(13, 31)
    Image.fromarray(image).save(tmp_path / f'flag.{kind}', lossless=True)
    picture = read_picture(tmp_path / f'flag.{kind}')
    assert picture.size == picture.texture.size == (31, 13)
    np.testing.assert_array_equal(shown(picture.texture), image)


def test_grey_palettes_and_what_is_transparent(tmp_path):
    grey = blots(5, 7)[..., 0]
    for mode, array in (('grey', grey), ('deep', grey.astype(np.uint16) << 8)):
        Image.fromarray(array).save(tmp_path / f'{mode}.png')
        texture = read_picture(tmp_path / f'{mode}.png').texture
        np.testing.assert_array_equal(shown(texture), np.repeat(grey[..., None], 3, axis=2))
    Image.fromarray(blots(4, 4)).quantize(16).save(tmp_path / 'palette.gif')
    expected = np.asarray(Image.open(tmp_path / 'palette.gif').convert('RGB'))
    np.testing.assert_array_equal(shown(read_picture(tmp_path / 'palette.gif').texture), expected)
    glass = np.dstack([blots(2, 3), np.uint8([[0, 255, 0], [255, 0, 255]])])
    Image.fromarray(glass).save(tmp_path / 'glass.png')
    np.testing.assert_array_equal(
        shown(read_picture(tmp_path / 'glass.png').texture),
        np.where(glass[..., 3:] == 0, 255, glass[..., :3]))


@pytest.mark.parametrize('kind', ['png', 'tiff', 'pgm'])
def test_grey_of_16_bits_is_as_bright_as_of_8(tmp_path, kind):
    grey = blots(5, 7)[..., 0]
    Image.fromarray(257 * grey.astype(np.uint16)).save(tmp_path / f'deep.{kind}')
    np.testing.assert_array_equal(shown(read_picture(tmp_path / f'deep.{kind}').texture)[..., 0],
                                  grey)


def test_grey_of_16_bits_as_older_versions_of_pillow_read_it():
    """Their mode for a PNG of 16 bits is I; what is transparent is seen before white."""
    image = Image.fromarray(np.int32([[0, 0x7fff, 0xffff, 0x1234]]))
    image.format, image.info = 'PNG', {'transparency': 0x1234}
    assert image.mode == 'I'
    assert np.asarray(_opaque(Image, image))[0, :, 0].tolist() == [0, 127, 255, 255]


@pytest.mark.parametrize('values, mode', [(np.float32([[0.0, 0.5, 1.0]]), 'F'),
                                          (np.int32([[0, 1 << 20, 1 << 30]]), 'I')])
def test_numbers_that_say_not_how_bright_they_are_are_refused(tmp_path, values, mode):
    """The first was black, and the second white where it is above 255."""
    Image.fromarray(values).save(tmp_path / 'deep.tiff')
    with pytest.raises(ValueError, match=f'deep.tiff .* mode {mode}, with 32 bits'):
        read_picture(tmp_path / 'deep.tiff')


@pytest.mark.parametrize('kind', ['png', 'tiff', 'webp'])
@pytest.mark.parametrize('orientation', range(10))
def test_a_picture_is_turned_as_its_exif_says(tmp_path, kind, orientation):
    """Also where it is not square; other numbers than 1 to 8 say nothing."""
    exif, image = Image.Exif(), Image.fromarray(blots(3, 5))
    exif[0x0112] = orientation
    image.save(tmp_path / f'a.{kind}', exif=exif, lossless=True)
    picture, upright = read_picture(tmp_path / f'a.{kind}'), image
    if 1 <= orientation <= 8:
        image.getexif()[0x0112] = orientation
        upright = ImageOps.exif_transpose(image)
    assert picture.size == picture.texture.size == upright.size
    np.testing.assert_array_equal(shown(picture.texture), np.asarray(upright))


def test_a_photograph_is_turned_and_a_broken_exif_block_says_nothing(tmp_path):
    image = Image.fromarray(np.uint8(np.linspace(0, 255, 64 * 32)).reshape(32, 64))
    exif = Image.Exif()
    exif[0x0112] = 6
    image.save(tmp_path / 'a.jpg', exif=exif, quality=95)
    turned = shown(read_picture(tmp_path / 'a.jpg').texture)[..., 0].astype(int)
    assert np.abs(turned - np.rot90(np.asarray(image), -1)).max() < 4
    image.save(tmp_path / 'b.jpg', exif=b'Exif\0\0MM\0*\xff\xff\xff\xff', quality=95)
    assert read_picture(tmp_path / 'b.jpg').size == (64, 32)


def test_a_huge_picture_is_scaled_down_in_linear_light(tmp_path):
    """Black and white in equal parts stay 188."""
    height, width = 1000, 2 * LARGEST + 6
    v, u = np.mgrid[:height, :width]
    Image.fromarray(np.uint8(255 * ((u + v) % 2))).save(tmp_path / 'huge.png')
    picture = read_picture(tmp_path / 'huge.png')
    assert picture.size == (width, height)
    assert picture.texture.size == (LARGEST, round(height * LARGEST / width))
    inner = shown(picture.texture)
    assert abs(inner.mean() - 188) < 1 and np.abs(inner.astype(int) - 188).max() < 30


def header_of(width, height):
    """Return the beginning of a PNG that says that it is that large."""
    def chunk(kind, data):
        return (struct.pack('>I', len(data)) + kind + data
                + struct.pack('>I', zlib.crc32(kind + data)))
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 2,
                                                              0, 0, 0))
            + chunk(b'IDAT', zlib.compress(b'\0' * 1000)) + chunk(b'IEND', b''))


def test_what_cannot_be_read_is_refused_with_path_and_reason(tmp_path):
    (tmp_path / 'text.png').write_text('not a picture')
    (tmp_path / 'empty.png').touch()
    (tmp_path / 'page.eps').write_text('%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n')
    (tmp_path / 'bomb.png').write_bytes(header_of(30000, MOST_PIXELS // 30000 + 1))
    (tmp_path / 'monster.png').write_bytes(header_of(2 ** 30, 2 ** 30))
    os.mkfifo(tmp_path / 'pipe.png')
    (tmp_path / 'folder').mkdir()
    Image.fromarray(blots(50, 50)).save(tmp_path / 'cut.png')
    (tmp_path / 'cut.png').write_bytes((tmp_path / 'cut.png').read_bytes()[:3000])
    for name, reason in (('gone.png', 'No such file'), ('text.png', 'not one of PNG, '),
                         ('empty.png', 'not one of PNG, '), ('page.eps', 'not one of PNG, '),
                         ('bomb.png', 'pixels'), ('monster.png', ''), ('pipe.png', 'not a file'),
                         ('folder', 'directory'), ('cut.png', 'truncated'), ('\0', 'null')):
        with pytest.raises(ValueError) as refused:
            read_picture(tmp_path / name)
        assert str(tmp_path / name) in str(refused.value) and reason in str(refused.value)
        assert '\n' not in str(refused.value)


def test_a_damaged_file_is_read_or_refused(tmp_path):
    path = tmp_path / 'flag'
    for kind in ('png', 'jpeg', 'gif', 'tiff'):
        Image.fromarray(blots(9, 9)).save(path, kind)

        @inputs(40)
        @given(damaged(path.read_bytes()))
        def read(data):
            path.write_bytes(data)
            try:
                read_picture(path)
            except ValueError as error:
                assert str(path) in str(error) and '\n' not in str(error)
        read()


def test_the_packages_own_pictures_are_what_the_tool_draws(tmp_path):
    assert main([str(tmp_path)]) == 0
    for name, draw in IMAGES.items():
        assert draw().shape == (HEIGHT, WIDTH, 3)
        for path in (tmp_path / f'{name}.png', config_path(f'{name}.png')):
            np.testing.assert_array_equal(np.asarray(Image.open(path).convert('RGB')), draw())
