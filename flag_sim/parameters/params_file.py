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
Parameters as a params file: written whole or not at all, and only over a file of its own kind.

Where it is written can be said over the network. So nothing is replaced that is not a params file
of the node, no link is followed, and while the node runs only one folder counts: `check_within`.
"""
from collections.abc import Collection, Iterable, Mapping
import contextlib
import os
from pathlib import Path
import secrets
import stat
import tempfile

from flag_sim.parameters import checks
from flag_sim.parameters.file_targets import base_name, keys_in
import yaml

LONGEST = 4096
"""Characters of a path, as in Linux."""
SUFFIXES = '.yaml', '.yml'
"""What ends the name of a params file that is named while the node runs."""


def _resolved(path: str | Path) -> tuple[Path, Path]:
    """Return a path, and the folder that it is in, without links; ValueError where it is none."""
    if len(str(path)) > LONGEST:
        raise ValueError(f'save_to: a path has at most {LONGEST} characters')
    if '\0' in str(path):
        raise ValueError('save_to: a path has no null characters')
    path = checks.path('save_to', path)
    try:
        folder = path.parent.resolve()
        if not folder.is_dir():
            raise ValueError(f'save_to: there is no folder {folder}')
    except (OSError, RuntimeError) as error:  # a loop of links is a RuntimeError
        reason = getattr(error, 'strerror', None) or error
        raise ValueError(f'save_to: {path} cannot be written: {reason}') from None
    return folder / path.name, folder


def start_folder(path: str | Path) -> Path:
    """Return the folder that counts while a node runs that was started with `path`, or with ''."""
    try:
        return _resolved(path)[1] if path else Path.cwd()
    except FileNotFoundError:
        raise ValueError('save_to: the working directory is gone') from None


def check_within(path: str | Path, folder: Path) -> None:
    """
    Raise ValueError unless `path` is a .yaml file in `folder` itself, and no hidden one.

    That is what may be named while a node runs: whoever reaches the node can name it.
    """
    path = checks.path('save_to', path)
    try:
        path, found = _resolved(path)
        is_right = found == folder
    except ValueError:  # of other folders nothing is told, not even whether they exist
        is_right = False
    if not is_right or path.suffix not in SUFFIXES or path.name.startswith('.'):
        raise ValueError(f'save_to: while the node runs it must be a .yaml file in {folder}; '
                         'for another folder start the node with it')


def check_path(path: str | Path, known: Collection[str] = ()) -> None:
    """
    Raise ValueError if a params file could not be written at `path`.

    known: names of nodes of which a file that is there may hold parameters, its own node first;
    none: of any.
    """
    path, folder = _resolved(path)
    try:
        _found_at(path, known, None)
        with tempfile.TemporaryFile(dir=folder):  # root may write where no file can be made
            pass
    except OSError as error:
        raise ValueError(f'save_to: {path} cannot be written: {error.strerror}') from None


def _found_at(path, known, last):
    """
    Return the lstat of what a params file at `path` would replace, or None.

    Raises ValueError where it must not be replaced.
    """
    try:
        found = path.lstat()
    except FileNotFoundError:
        return None
    for is_kind, words in ((stat.S_ISDIR, 'a folder'), (stat.S_ISLNK, 'a link')):
        if is_kind(found.st_mode):
            raise ValueError(f'save_to: {path} is {words}')
    if not last or _identity(found) != last:
        try:
            names = [base_name(key) for key in keys_in(path)]
        except ValueError:
            names = []
        if not names or (known and (known[0] not in names or not {*names} <= {*known})):
            raise ValueError(f'save_to: {path} is there and is not a params file of '
                             f'{" and ".join(known[:1]) or "a node"} alone; it is not replaced')
    return found


def _identity(found):
    return found.st_dev, found.st_ino, found.st_mtime_ns, found.st_size


def heads_of(nodes: Iterable[str]) -> dict[str, str]:
    """
    Return {full name: the key that stands for the node in a params file}.

    It counts in any namespace, as those of the shipped files, unless nodes of one name have to be
    told apart.
    """
    names = [base_name(node) for node in nodes]
    return {node: f'/**/{name}' if names.count(name) == 1 else node
            for node, name in zip(nodes, names)}


def save_parameters(path: str | Path, node: str, values: Mapping, others: Mapping | None = None,
                    lacking: Iterable[str] = (), known: Iterable[str] = (),
                    last: tuple | None = None) -> tuple:
    """
    Write {name: value} of `node`, by its full name, as a params file; return which file it is.

    others: {node: {name: value}} that are written with it. lacking: what the file does not hold,
    in words; it says so at its top. Keys are as of `heads_of`. known: names of further nodes of
    which a file that is there may hold parameters. last: what was returned for the same file: it
    is known then, and not read.
    The file is written beside and then put in place, so a reader never sees half of it. Raises
    OSError or ValueError where that fails; what was there before is then still there, and what
    is replaced keeps its mode.
    """
    path, folder = _resolved(path)
    sections = {node: values, **(others or {})}
    replaced = _found_at(path, [*map(base_name, sections), *known], last)
    heads = heads_of(sections)
    content = ''.join(f'# {line}, so what was set on it is not in this file.\n'
                      for line in lacking)
    content += yaml.safe_dump(
        {heads[name]: {'ros__parameters': own} for name, own in sections.items() if own},
        sort_keys=True)
    beside = folder / f'.flag_sim-{secrets.token_hex(8)}'
    # A new file, whoever can guess its name; for others closed until it has the mode it shall have
    file = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW,
                   0o600 if replaced else 0o666)
    try:
        with open(file, 'w') as out:
            out.write(content)
            out.flush()
            if replaced:
                with contextlib.suppress(PermissionError):
                    os.fchown(file, replaced.st_uid, replaced.st_gid)
                os.fchmod(file, stat.S_IMODE(replaced.st_mode))
            written = _identity(os.fstat(file))
        os.replace(beside, path)
    except OSError:
        beside.unlink(missing_ok=True)
        raise
    return written
