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

"""Parameters as a params file, written whole or not at all."""
from collections.abc import Iterable, Mapping
import os
import tempfile

from flag_sim.parameters import checks
import yaml


def check_path(path: str) -> None:
    """Raise ValueError if a file could not be written at `path`."""
    path = checks.path('save_to', path)
    folder = path.resolve().parent
    if not folder.is_dir():
        raise ValueError(f'save_to: there is no folder {folder}')
    if path.is_dir():
        raise ValueError(f'save_to: {path} is a folder')
    try:  # not by os.access: root may write to folders in which no file can be made
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ValueError(f'save_to: {path} cannot be written: {error.strerror}') from None


def heads_of(nodes: Iterable[str]) -> dict[str, str]:
    """
    Return {full name: the key that stands for the node in a params file}.

    It counts in any namespace, as those of the shipped files, unless nodes of one name have to be
    told apart.
    """
    names = [node.rpartition('/')[2] for node in nodes]
    return {node: f'/**/{name}' if names.count(name) == 1 else node
            for node, name in zip(nodes, names)}


def save_parameters(path: str, node: str, values: Mapping, others: Mapping | None = None,
                    lacking: Iterable[str] = ()) -> None:
    """
    Write {name: value} of `node`, by its full name, as a params file.

    others: {node: {name: value}} that are written with it. lacking: what the file does not hold,
    in words; it says so at its top. Keys are as of `heads_of`.
    The file is written beside and then put in place, so a reader never sees half of it. Raises
    OSError where that fails; what was there before is then still there.
    """
    path = checks.path('save_to', path)
    sections = {node: values, **(others or {})}
    heads = heads_of(sections)
    content = ''.join(f'# {line}, so what was set on it is not in this file.\n'
                      for line in lacking)
    content += yaml.safe_dump(
        {heads[name]: {'ros__parameters': own} for name, own in sections.items() if own},
        sort_keys=True)
    beside = path.with_name(f'.{path.name}-{os.getpid()}')
    try:
        beside.write_text(content)
        os.replace(beside, path)
    except OSError:
        beside.unlink(missing_ok=True)
        raise
