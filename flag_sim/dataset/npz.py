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

An .npz is a ZIP of .npy files, one an array. Its arrays grow side by side here, compressed, and
are put together at the end. All are compressed by ISA-L, which takes a tenth of the time of zlib
for as few bytes, and every zlib reads them.
"""
from collections.abc import Mapping
import hashlib
import io
from pathlib import Path
import zipfile
import zlib

from flag_sim.dataset.pieces import Pieces
from isal import isal_zlib
import numpy as np

LEVEL = 1  # of ISA-L's 0 to 3
AT_ONCE = 256 << 10
"""
Bytes that are compressed at once: they stay in the processor's cache from the checksum on, and
what becomes of them is small enough to stand in memory that the process has already.
"""
RAW_DEFLATE = -15  # as it stands in a ZIP
OWN_FILE = 0o600 << 16  # what an entry of a ZIP says of its rights


class Growing:
    """One array of a clip that grows frame by frame among Pieces; frames: in all."""

    def __init__(self, first: np.ndarray, frames: int, pieces: Pieces):
        self._kind = first.dtype, first.shape
        self._deflate = isal_zlib.compressobj(LEVEL, zlib.DEFLATED, RAW_DEFLATE)
        self._pieces = pieces
        self.places = []
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
        self.places.append(self._pieces.add(self._deflate.flush()))

    def _write(self, data):
        self.size += len(data)
        for begin in range(0, len(data), AT_ONCE):
            part = data[begin:begin + AT_ONCE]
            self.crc = isal_zlib.crc32(part, self.crc)
            self.places.append(self._pieces.add(self._deflate.compress(part)))


class NpzWriter:
    """
    Writes a clip at `path`, which should be a temporary name; frames: how many it will have.

    A context: what it has opened is closed when that is left.
    """

    def __init__(self, path: Path, frames: int):
        self._path, self._frames = path, frames
        self._arrays = {}
        self._pieces = Pieces(path.parent)

    def append(self, arrays: Mapping[str, np.ndarray], view: object = None) -> None:
        """Add a frame, {array: its part}; raises OSError where the disk is full."""
        del view  # from which a bag makes its messages
        for name, part in arrays.items():
            if name not in self._arrays:
                self._arrays[name] = Growing(part, self._frames, self._pieces)
            self._arrays[name].append(part)

    def finish(self) -> dict[str, object]:
        """
        Write the file; return its size in bytes, its SHA-256, and what its arrays hold.

        `content` is the SHA-256 of the arrays' names, sizes and CRC-32: the same wherever they are
        made, while ISA-L may compress them to other bytes, on another processor or the next time.
        """
        content = hashlib.sha256()
        with open(self._path, 'wb') as file:
            hashed = _Hashed(file)
            with zipfile.ZipFile(hashed, 'w') as bundle:
                for name, array in self._arrays.items():
                    array.end()
                    _put(bundle, f'{name}.npy', array, self._pieces)
                    content.update(f'{name} {array.size} {array.crc}\n'.encode())
        return {'bytes': hashed.size, 'sha256': hashed.digest.hexdigest(),
                'content': content.hexdigest()}

    def __enter__(self) -> 'NpzWriter':
        return self

    def __exit__(self, *_):
        """Give back what it has held."""
        self._pieces.__exit__()


class _Hashed:
    """A file that is written from its start to its end, hashed on the way."""

    def __init__(self, file):
        self._file = file
        self.digest, self.size = hashlib.sha256(), 0

    def write(self, data):
        self.digest.update(data)
        self.size += len(data)
        return self._file.write(data)

    def flush(self):
        self._file.flush()


def _put(bundle, name, array, pieces):
    """Put an array that is compressed already into a ZIP, which zipfile itself would not."""
    entry = zipfile.ZipInfo(name)
    entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, OWN_FILE
    entry.file_size, entry.CRC = array.size, array.crc
    entry.compress_size = sum(end - begin for begin, end in array.places)
    entry.header_offset = bundle.fp.tell()
    bundle.fp.write(entry.FileHeader(zip64=True))
    for piece in pieces.read(array.places):
        bundle.fp.write(piece)
    bundle.filelist.append(entry)
    bundle.start_dir = bundle.fp.tell()  # of the list of entries, written last
