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

"""Pictures on the flag: files that are read once, and kept while they are the same."""
import os
from pathlib import Path

from flag_sim.drawing.image_file import Picture, read_picture
from flag_sim.parameters.config import config_path

KEPT = 8
"""Pictures that are kept: so many may take turns in a shot without being read again."""

_kept: dict[str, tuple] = {}  # what the file was like, and its Picture, by name


def picture_of(name: str) -> Picture | None:
    """
    Return the picture of the parameter `flag.image`, or None for an empty name.

    name: a path, or the name of one of the package's own in config/. A file is read again where
    it has changed; one that can no longer be read stays what it was, for frames go on. Raises
    ValueError, with path and reason, for one that never could.
    """
    if not name:
        return None
    state, known = _state_of(name), _kept.get(name)
    if known is not None and state in (None, known[0]):
        _kept[name] = _kept.pop(name)  # the last to go
        return known[1]
    try:
        picture = read_picture(_path_of(name))
    except ValueError as error:
        if known is None:
            raise ValueError(f'flag.image: {error}') from None
        return known[1]
    _kept.pop(name, None)
    while len(_kept) >= KEPT:
        del _kept[next(iter(_kept))]
    _kept[name] = state, picture
    return picture


def _path_of(name):
    """Return the path of a file: beside the working folder, or else in config/."""
    if not os.path.exists(name) and Path(name).name == name:
        try:
            return config_path(name)
        except FileNotFoundError:
            pass
    return Path(name)


def _state_of(name):
    """Return what changes with the file, or None where there is none."""
    try:
        found = os.stat(_path_of(name))
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino, found.st_mtime_ns, found.st_size
