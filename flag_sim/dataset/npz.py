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
A clip as a file .npz, written frame by frame: no more than a part of it is in memory.

An .npz is a ZIP of .npy files, one an array. Its arrays grow side by side here, each in a
temporary file once it is large, and are put together at the end. Images are deflated (see
deflated), all else is stored. The same arrays are the same bytes.
"""
from collections.abc import Mapping
import contextlib
import hashlib
import io
from pathlib import Path
import struct
import tempfile
import zlib

from flag_sim.dataset.deflated import deflated, END, stored
import numpy as np

IN_MEMORY = 32 << 20
"""Bytes of one array that are kept in memory."""
COPIED = 1 << 20
"""Bytes that are copied at a time."""
SMALLEST_IMAGE = 256
"""Pixels of what is deflated."""
MOST_CHANNELS = 4
STORED, DEFLATED = 0, 8
# Records of the ZIP format (PKWARE, APPNOTE.TXT), all with 64-bit sizes (4.5.3).
LOCAL = struct.Struct('<4s5HL2L2H')
CENTRAL = struct.Struct('<4s6H3L5H2L')
SIZES = struct.Struct('<2H2Q')
SIZES_AND_PLACE = struct.Struct('<2H3Q')
END_64 = struct.Struct('<4sQ2H2L4Q')
LOCATOR = struct.Struct('<4sLQL')
END_RECORD = struct.Struct('<4s4H2LH')
VERSION, MIDNIGHT_1980 = 45, (0, 33)
IN_64 = 0xFFFFFFFF


class Growing:
    """One array of a clip that grows frame by frame; frames: how many there will be."""

    def __init__(self, first: np.ndarray, frames: int, folder: Path):
        channels = first.shape[2] if first.ndim == 3 else 1
        self._is_image = (first.ndim in (2, 3) and channels <= MOST_CHANNELS
                          and first.size >= SMALLEST_IMAGE * channels)
        self._kind = first.dtype, first.shape
        self.method = DEFLATED if self._is_image else STORED
        self.file = tempfile.SpooledTemporaryFile(IN_MEMORY, dir=folder)
        header = io.BytesIO()
        np.lib.format.write_array_header_1_0(header, {
            'descr': np.lib.format.dtype_to_descr(first.dtype), 'fortran_order': False,
            'shape': (frames, *first.shape)})
        self.size = self.packed = self.crc = 0
        self._write(header.getvalue(), stored(header.getvalue()))

    def append(self, part: np.ndarray) -> None:
        """Add a frame; raise ValueError for another shape or type, OSError on a full disk."""
        if (part.dtype, part.shape) != self._kind:
            raise ValueError(f'a frame of {part.dtype} {part.shape} among {self._kind}')
        data = np.ascontiguousarray(part).reshape(-1).view(np.uint8).data
        self._write(data, deflated(part) if self._is_image else data)

    def end(self) -> None:
        """Say that all frames are there."""
        if self._is_image:
            self._write(b'', END)

    def _write(self, plain, packed):
        self.size += len(plain)
        self.crc = zlib.crc32(plain, self.crc)
        packed = packed if self._is_image else plain
        self.packed += len(packed)
        self.file.write(packed)


class NpzWriter:
    """
    Writes a clip at `path`, which should be a temporary name; frames: how many it will have.

    A context: what it has opened is closed when that is left.
    """

    def __init__(self, path: Path, frames: int):
        self._path, self._frames = path, frames
        self._arrays = {}
        self._open = contextlib.ExitStack()

    def append(self, arrays: Mapping[str, np.ndarray], view: object = None) -> None:
        """Add a frame, {array: its part}; raises OSError where the disk is full."""
        del view  # from which a bag makes its messages
        for name, part in arrays.items():
            if name not in self._arrays:
                growing = Growing(part, self._frames, self._path.parent)
                self._arrays[name] = growing
                self._open.callback(growing.file.close)
            self._arrays[name].append(part)

    def finish(self) -> dict[str, object]:
        """Write the file; return its size in bytes and its SHA-256: {'bytes': , 'sha256': }."""
        digest, place, directory = hashlib.sha256(), 0, []
        with open(self._path, 'wb') as file:
            def write(data):
                nonlocal place
                file.write(data)
                digest.update(data)
                place += len(data)
            for name, array in self._arrays.items():
                array.end()
                name = f'{name}.npy'.encode()
                common = VERSION, 0, array.method, *MIDNIGHT_1980, array.crc, IN_64, IN_64
                directory.append(CENTRAL.pack(
                    b'PK\1\2', VERSION, *common, len(name), SIZES_AND_PLACE.size, 0, 0, 0, 0,
                    IN_64) + name + SIZES_AND_PLACE.pack(
                        1, SIZES_AND_PLACE.size - 4, array.size, array.packed, place))
                write(LOCAL.pack(b'PK\3\4', *common, len(name), SIZES.size) + name
                      + SIZES.pack(1, SIZES.size - 4, array.size, array.packed))
                array.file.seek(0)
                while part := array.file.read(COPIED):
                    write(part)
            begin, records = place, b''.join(directory)
            count = len(directory)
            write(records)
            end = place
            write(END_64.pack(b'PK\6\6', END_64.size - 12, VERSION, VERSION, 0, 0, count, count,
                              len(records), begin))
            write(LOCATOR.pack(b'PK\6\7', 0, end, 1))
            write(END_RECORD.pack(b'PK\5\6', 0, 0, count, count, len(records) & IN_64,
                                  IN_64, 0))
        return {'bytes': place, 'sha256': digest.hexdigest()}

    def __enter__(self) -> 'NpzWriter':
        return self

    def __exit__(self, *_):
        """Close what is open."""
        self._open.close()
