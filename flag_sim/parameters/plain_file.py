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

"""Files that may be anybody's: regular ones, of a bounded size."""
import os
import stat
from typing import BinaryIO


def opened(path: str | os.PathLike, largest: int | None = None) -> BinaryIO:
    """
    Return a file, opened to be read.

    Raises ValueError where it is none (a pipe without a writer would be waited for) or has more
    than `largest` bytes, and OSError.
    """
    file = open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), 'rb')
    found = os.fstat(file.fileno())
    if stat.S_ISREG(found.st_mode) and (largest is None or found.st_size <= largest):
        return file
    file.close()
    raise ValueError(f'{path} is larger than {largest} bytes' if stat.S_ISREG(found.st_mode)
                     else f'{path} is not a file')
