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

"""The index of a bag's chunks while the bag is written."""
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
import struct
import tempfile

LENGTH = struct.Struct('<I')


class IndexOnDisk:
    """
    Stands for the list in which the MCAP writer keeps the index of every chunk until it closes.

    Each frame is a chunk, so in memory that list took 60 MB an hour at 60 Hz. The records are
    kept in a file of `folder` that has no name and is gone with the process. All methods raise
    OSError where the disk is full.
    """

    def __init__(self, folder: Path):
        self._file = tempfile.TemporaryFile(dir=folder)
        self._number = 0

    def append(self, record: BytesIO) -> None:
        """Add the record of a chunk."""
        data = record.getvalue()
        self._file.write(LENGTH.pack(len(data)) + data)
        self._number += 1

    def __len__(self) -> int:
        return self._number

    def __iter__(self) -> Iterator[BytesIO]:
        """Yield the records in their order, each with its position at the end, as it came."""
        self._file.seek(0)
        while length := self._file.read(LENGTH.size):
            record = BytesIO()
            record.write(self._file.read(*LENGTH.unpack(length)))
            yield record

    def close(self) -> None:
        """Give the file back."""
        self._file.close()
