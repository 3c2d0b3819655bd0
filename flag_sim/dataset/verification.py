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

"""Verifying a dataset: whether its folder holds what was written there, and nothing else."""
from collections.abc import Iterable, Iterator
import itertools
from pathlib import Path
import sys

from flag_sim.dataset import bag, manifest
from flag_sim.dataset.file_digest import file_digest
from flag_sim.dataset.store import Store, StoreError

SHOWN = 10
"""How many of the clips or files that are missing, or that belong to none, are named."""


def verify(store: Store, numbers: range) -> int:
    """
    Compare clips with their digests, and print what is not right; return the exit status.

    numbers: those that should be there; clips beyond are compared as well. Files that belong to
    no clip are looked for where the store is not that of a shard. Raises StoreError for a folder
    that is no dataset.
    """
    if not (store.folder / 'dataset.json').is_file():
        raise StoreError(f'{store.folder} is no dataset')
    there, files = {}, set()
    for row in manifest.all_rows(store, numbers):
        wrong = wrong_with(store, row)
        there[row['number']] = 'bad' if wrong else row['status']
        files.update((store.path(row['number'], '.json'), store.folder / row['file']))
        if wrong:
            _tell(f'clip {row["number"]}: {wrong}')
    for row in _of_another_size(store, numbers, there):
        there[row['number']] = 'bad'
        files.update((store.path(row['number'], '.json'), store.folder / row['file']))
        _tell(f'clip {row["number"]}: {row["file"]} has another size than was written: '
              'the command that made it makes it again')
    missing = len(numbers) - sum(number in numbers for number in there)
    if missing:
        names = _first((number for number in numbers if number not in there), missing)
        _tell(f'not there are clips {names}: the same command makes them')
    added = 0 if store.tag else _tell_of_added(store, numbers, files)
    broken = list(_broken_manifests(store))
    for why in broken:
        _tell(why)
    whole, failed, bad = (list(there.values()).count(word) for word in ('whole', 'failed', 'bad'))
    print(f'{whole} clips are whole, {failed} could not be made, {bad} are not as they were '
          f'written, {missing} are not there')
    return int(bool(bad or missing or added or broken))


def _of_another_size(store, numbers, there):
    """Yield the rows of whole clips that are not `there`, as runs see it, but have a file."""
    for number in itertools.chain(store.listed(numbers), store.beyond(numbers)):
        row = None if number in there else store.written_row(number)
        if row and row['status'] == 'whole' and (store.folder / row['file']).exists():
            yield row


def wrong_with(store: Store, row: dict) -> str:
    """Return why the files of a clip are not what its row says, or ''."""
    if row['status'] != 'whole':
        return ''
    try:
        found = digest_of(store.folder / row['file'])
    except OSError as error:
        return f'{row["file"]} cannot be read: {error.strerror}'
    return '' if found == row['sha256'] else (
        f'{row["file"]} is not as it was written: remove it, and the same command makes it again')


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a clip: of its file, or of those of its bag."""
    return bag.digest_of(path) if path.is_dir() else file_digest(path).hexdigest()


def _tell_of_added(store, numbers, files):
    """Tell of the files that belong to no clip; return how many there are."""
    names = [str(path.relative_to(store.folder)) for path in _below(store.folder / 'clips')
             if path not in files and not _is_unfinished(path, numbers)]
    if names:
        _tell(f'of no clip {"are" if len(names) > 1 else "is"} {_first(names, len(names))}')
    return len(names)


def _below(clips: Path) -> Iterator[Path]:
    """Yield what is in the folders of clips, and what is beside them."""
    for folder in sorted(clips.glob('*')):
        if folder.is_dir() and folder.name.isdecimal():
            yield from sorted(folder.glob('*'))
        else:
            yield folder


def _is_unfinished(path, numbers):
    """Return whether a killed run left this of a clip that the next one makes again."""
    return path.name.startswith('.new-') or (path.stem.isdecimal() and int(path.stem) in numbers
                                             and path.suffix in ('', '.npz', '.json'))


def _broken_manifests(store):
    """Yield why manifests cannot be read: of a shard its own, else all."""
    for path in [store.manifest] if store.tag else manifest.paths_in(store.folder):
        if path.exists():
            try:
                manifest.read_one(path)
            except ValueError as error:
                yield str(error)


def _first(names: Iterable, count: int) -> str:
    """Return the first of `count` names in words, and how many more there are."""
    shown = ', '.join(map(str, itertools.islice(names, SHOWN)))
    return shown + (f' and {count - SHOWN} more' if count > SHOWN else '')


def _tell(line):
    print(line, file=sys.stderr)
