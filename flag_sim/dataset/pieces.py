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
Streams that grow side by side, piece by piece, to be read one after another.

Pieces stand in one block of memory, which the next clip's are written over: memory that is new to
a process is slow, as the system hands it out page by page. When it is full they go to a file.
"""
from collections.abc import Iterable, Iterator
import os
from pathlib import Path
import tempfile

import numpy as np

IN_MEMORY = 128 << 20
"""Bytes of a block; only as much of it is real memory as the largest clip has used."""
_idle = []  # blocks that nobody writes to now


class Pieces:
    """
    Where the pieces of streams are until they are read; folder: of the file for what is too much.

    A context: leaving it gives back the memory and the file.
    """

    def __init__(self, folder: Path):
        self._folder = folder
        try:
            self._block = _idle.pop()
        except IndexError:
            self._block = memoryview(np.empty(IN_MEMORY, np.uint8))
        self._used = 0
        self._file, self._in_file = None, 0

    def add(self, data: bytes) -> tuple[int, int]:
        """Keep a piece; return where it begins and ends. Raises OSError on a full disk."""
        if self._used + len(data) > len(self._block):
            self._empty_to_file()
        begin = self._in_file + self._used
        if len(data) > len(self._block):
            self._to_file(data)
        else:
            self._block[self._used:self._used + len(data)] = data
            self._used += len(data)
        return begin, begin + len(data)

    def read(self, places: Iterable[tuple[int, int]]) -> Iterator[bytes | memoryview]:
        """Yield the pieces at places that `add` has returned."""
        for begin, end in places:
            if begin >= self._in_file:
                yield self._block[begin - self._in_file:end - self._in_file]
            else:
                yield os.pread(self._file.fileno(), end - begin, begin)

    def _empty_to_file(self):
        self._to_file(self._block[:self._used])
        self._used = 0

    def _to_file(self, data):
        if self._file is None:
            self._file = tempfile.TemporaryFile(dir=self._folder, buffering=0)
        while len(data):
            data = data[self._file.write(data):]
        self._in_file = self._file.tell()

    def __enter__(self) -> 'Pieces':
        return self

    def __exit__(self, *_):
        """Give back the memory and the file."""
        _idle.append(self._block)
        self._block = None
        if self._file is not None:
            self._file.close()
