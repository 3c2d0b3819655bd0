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
import dataclasses
import os
from pathlib import Path

from flag_sim.drawing.image_file import Picture, read_picture
from flag_sim.parameters.config import config_path

KEPT = 8
"""Pictures that are kept: so many may take turns in a shot without being read again."""


@dataclasses.dataclass
class Kept:
    """
    A picture that was read.

    tried: what the file was like when it was read last, or None; unread: why that failed, where
    the picture is that of an earlier one, else ''.
    """

    picture: Picture
    tried: tuple | None
    unread: str = ''


_kept: dict[str, Kept] = {}


def picture_of(name: str, is_asked: bool = False) -> Picture | None:
    """
    Return the picture of the parameter `flag.image`, or None for an empty name.

    name: a path, or the name of one of the package's own in config/; is_asked: whether a user sets
    it now. A file is read again where it has changed. One that can no longer be read stays what it
    was, for frames go on, and told_of says so; but not where it is asked for. Raises ValueError,
    with path and reason, for that, and for one that never could be read.
    """
    if not name:
        return None
    state, known = _state_of(name), _kept.pop(name, None)
    try:
        if known is None or state != known.tried or (is_asked and known.unread):
            known = _read_again(name, state, known, is_asked)
        return known.picture
    finally:
        if known is not None:
            while len(_kept) >= KEPT:
                del _kept[next(iter(_kept))]
            _kept[name] = known  # the last to go


def _read_again(name, state, known, is_asked):
    """Return the Kept of a file; known: the one before, which then says why it is kept."""
    try:
        return Kept(read_picture(_path_of(name)), state)
    except ValueError as error:
        if known is not None:
            known.tried, known.unread = state, str(error)
        if known is None or is_asked:
            raise ValueError(f'flag.image: {error}') from None
        return known


def told_of(name: str, is_new: bool = True) -> list[str]:
    """
    Return what people should know of the picture of a parameter, in words.

    That it is scaled down, where it is_new; and why it is not what is now in its file.
    """
    picture, told = picture_of(name), []
    if is_new and picture and picture.size != picture.texture.size:
        (width, height), (columns, rows) = picture.size, picture.texture.size
        told.append(f'flag.image: {name} has {width} x {height} pixels, it is scaled down to '
                    f'{columns} x {rows}')
    if picture and _kept[name].unread:
        told.append(f'flag.image: {_kept[name].unread}; the picture that was read from it before '
                    'stays')
    return told


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
