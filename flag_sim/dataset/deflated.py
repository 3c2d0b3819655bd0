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
Images as a stream of Deflate (RFC 1951), the compression of .npz files, made for rendered ones.

Most of a picture of a flag is background, all of one value. Here runs of a pixel that is the
image's first one become what Deflate calls a match with the pixel before, and all else stays as it
is, in stored blocks. zlib looks for matches everywhere, and takes ten times as long. What comes
out is read by every zlib, and is the same bytes on every machine.
"""
import functools

from flag_sim.jit.kernels import kernel
import numpy as np

LONGEST_MATCH = 258
LONGEST_STORED = 65535
SHORTEST_RUN = 48
"""Bytes of background that are worth a match: what comes before and after it takes 12."""
END = bytes((1, 0, 0, 255, 255))
"""The last block of a stream: stored, with nothing in it."""


def stored(data: bytes) -> bytes:
    """Return a few bytes as a block of their own."""
    return b'\0' + len(data).to_bytes(2, 'little') + (
        LONGEST_STORED - len(data)).to_bytes(2, 'little') + data


@functools.lru_cache(maxsize=64)
def _match_codes(distance):
    """
    Return the codes of matches at a distance [bytes]: (259,) uint64 bits and (259,) int64 lengths.

    One for each length of a match, from 3 on: the fixed Huffman code of the length and that of the
    distance, each with its extra bits, the first bit lowest.
    """
    bits, sizes = np.zeros(LONGEST_MATCH + 1, np.uint64), np.zeros(LONGEST_MATCH + 1, np.int64)
    code, base = 0, 1
    while distance >= base + (1 << max(code // 2 - 1, 0)):
        base += 1 << max(code // 2 - 1, 0)
        code += 1
    extra = max(code // 2 - 1, 0)
    tail = _reversed(code, 5) | (distance - base) << 5, 5 + extra
    for length in range(3, LONGEST_MATCH + 1):
        symbol, more, size = _length_code(length)
        head, width = ((_reversed(symbol - 256, 7), 7) if symbol < 280 else
                       (_reversed(0b11000000 + symbol - 280, 8), 8))
        bits[length] = head | more << width | tail[0] << width + size
        sizes[length] = width + size + tail[1]
    return bits, sizes


def _length_code(length):
    """Return the symbol of a match's length, its extra bits, and how many these are."""
    if length == LONGEST_MATCH:
        return 285, 0, 0
    symbol, base = 257, 3
    for symbol in range(257, 285):
        size = max((symbol - 261) // 4, 0) if symbol >= 265 else 0
        if length < base + (1 << size):
            return symbol, length - base, size
        base += 1 << size
    raise AssertionError(length)


def _reversed(code, width):
    return int(f'{code:0{width}b}'[::-1], 2)


def deflated(image: np.ndarray) -> bytes:
    """
    Return the bytes of an image as blocks of Deflate that end at a whole byte; END is to follow.

    image: (height, width) or (height, width, channels) of any type.
    """
    pixels = np.ascontiguousarray(image)
    size = pixels.nbytes // max(image.shape[0] * image.shape[1], 1)
    data = pixels.reshape(-1).view(np.uint8)
    row = size * image.shape[1]
    words = data.view(np.uint64) if row % 8 == 0 else data
    background = np.tile(data[:size], image.shape[1]).view(words.dtype)
    bits, sizes = _match_codes(size)
    out = np.empty(data.size + data.size // LONGEST_STORED * 8 + 64 * image.shape[0] + 64,
                   np.uint8)
    edges = np.empty((image.shape[0], 2), np.int64)
    _find_edges(words.reshape(image.shape[0], -1), background, edges)
    edges[:] *= words.itemsize
    count = _write(data, (row, size), edges, (bits, sizes), out)
    return out[:count].data


@kernel
def _find_edges(rows, background, edges):
    """Write where in each row what is no background begins and ends; 0 and 0: there is none."""
    width = len(background)
    for r in range(rows.shape[0]):
        first, last = 0, width
        while first < width and rows[r, first] == background[first]:
            first += 1
        if first == width:
            edges[r, 0] = edges[r, 1] = 0
            continue
        while rows[r, last - 1] == background[last - 1]:
            last -= 1
        edges[r, 0], edges[r, 1] = first, last


@kernel
def _write(data, shape, edges, codes, out):
    """
    Write blocks; return how many bytes they have.

    shape: bytes of a row and of a pixel; edges: [byte] in each row, see _find_edges.
    """
    row, size = shape
    at, begin = 0, 0  # in out; of what is not written yet, in data
    first = size      # where a pixel of background has one before it: the run begins there
    for r in range(edges.shape[0] + 1):
        is_end = r == edges.shape[0]
        if not is_end and edges[r, 1] == 0:
            continue
        # What is no background begins at a pixel: a match is as long as its distance allows.
        end = r * row + (0 if is_end else edges[r, 0] // size * size)
        if end - first >= SHORTEST_RUN:
            at = _write_stored(data[begin:first], out, at)
            at = _write_run(end - first, codes, out, at)
            begin = end
        if not is_end:
            # After one pixel of background the next ones are as the one before.
            first = r * row + -(-edges[r, 1] // size) * size + size
    return _write_stored(data[begin:], out, at)


@kernel
def _write_stored(data, out, at):
    """Write stored blocks; return where the next one begins."""
    done = 0
    while done < len(data):
        count = min(len(data) - done, LONGEST_STORED)
        out[at] = 0
        out[at + 1], out[at + 2] = count & 255, count >> 8
        out[at + 3], out[at + 4] = ~count & 255, (~count >> 8) & 255
        out[at + 5:at + 5 + count] = data[done:done + count]
        at += 5 + count
        done += count
    return at


@kernel
def _write_run(count, codes, out, at):
    """Write so many bytes that repeat those before as a block, brought to a whole byte."""
    bits, sizes = codes
    held, width = np.uint64(0b010), 3  # the block is not the last, and has the fixed codes
    while count > 0:
        # No match is shorter than 3: the last but one leaves as many.
        length = min(count, LONGEST_MATCH)
        length = length - 3 if 0 < count - length < 3 else length
        held |= bits[length] << np.uint64(width)
        width += sizes[length]
        count -= length
        while width >= 8:
            out[at] = held & np.uint64(255)
            held >>= np.uint64(8)
            width -= 8
            at += 1
    # The block's end is seven bits of 0. An empty stored block follows, up to a whole byte.
    width += 7 + 3
    while width > 0:
        out[at] = held & np.uint64(255)
        held >>= np.uint64(8)
        width -= 8
        at += 1
    out[at], out[at + 1], out[at + 2], out[at + 3] = 0, 0, 255, 255
    return at + 4
