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
temporary file once it is large, and are put together at the end. All are compressed by ISA-L,
which takes a tenth of the time of zlib for as few bytes, and every zlib reads them.
"""
from collections.abc import Mapping
import contextlib
import hashlib
import io
from pathlib import Path
import shutil
import tempfile
import zipfile
import zlib

from isal import isal_zlib
import numpy as np

IN_MEMORY = 32 << 20
"""Bytes of one array that are kept in memory."""
LEVEL = 1  # of ISA-L's 0 to 3
RAW_DEFLATE = -15  # as it stands in a ZIP


class Growing:
    """One array of a clip that grows frame by frame; frames: how many there will be."""

    def __init__(self, first: np.ndarray, frames: int, folder: Path):
        self._kind = first.dtype, first.shape
        self._deflate = isal_zlib.compressobj(LEVEL, zlib.DEFLATED, RAW_DEFLATE)
        self.file = tempfile.SpooledTemporaryFile(IN_MEMORY, dir=folder)
        header = io.BytesIO()
        np.lib.format.write_array_header_1_0(header, {
            'descr': np.lib.format.dtype_to_descr(first.dtype), 'fortran_order': False,
            'shape': (frames, *first.shape)})
        self.size = self.crc = 0
        self._write(header.getvalue())

    def append(self, part: np.ndarray) -> None:
        """Add a frame; raise ValueError for another shape or type, OSError on a full disk."""
        if (part.dtype, part.shape) != self._kind:
            raise ValueError(f'a frame of {part.dtype} {part.shape} among {self._kind}')
        self._write(np.ascontiguousarray(part).reshape(-1).view(np.uint8).data)

    def end(self) -> None:
        """Say that all frames are there."""
        self.file.write(self._deflate.flush())

    def _write(self, data):
        self.size += len(data)
        self.crc = isal_zlib.crc32(data, self.crc)
        self.file.write(self._deflate.compress(data))


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
        """
        Write the file; return its size in bytes, its SHA-256, and what its arrays hold.

        `content` is the SHA-256 of the arrays' names, sizes and CRC-32: the same wherever they are
        made, while another processor may compress them to other bytes.
        """
        content = hashlib.sha256()
        with open(self._path, 'wb') as file, zipfile.ZipFile(file, 'w') as bundle:
            for name, array in self._arrays.items():
                array.end()
                _put(bundle, file, f'{name}.npy', array)
                content.update(f'{name} {array.size} {array.crc}\n'.encode())
        with open(self._path, 'rb') as file:
            digest = hashlib.file_digest(file, 'sha256').hexdigest()
        return {'bytes': self._path.stat().st_size, 'sha256': digest,
                'content': content.hexdigest()}

    def __enter__(self) -> 'NpzWriter':
        return self

    def __exit__(self, *_):
        """Close what is open."""
        self._open.close()


def _put(bundle, file, name, array):
    """Put an array that is compressed already into a ZIP, which is written to a file."""
    entry = zipfile.ZipInfo(name)
    array.file.seek(0)
    with bundle.open(entry, 'w', force_zip64=True) as member:
        shutil.copyfileobj(array.file, member)
    # zipfile takes it for stored: the entry says what it is, here and at the end of the file.
    entry.compress_type, entry.file_size, entry.CRC = zipfile.ZIP_DEFLATED, array.size, array.crc
    end = file.tell()
    file.seek(entry.header_offset)
    file.write(entry.FileHeader(zip64=True))
    file.seek(end)
