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
The folder of a dataset: which clips are in it, whole or not at all, and who writes to it.

    DIR/recipe.yaml, dataset.json        what the clips are made by
    DIR/clips/000000/000000731.npz       a clip, or a folder with its bag
    DIR/clips/000000/000000731.json      its row of the manifest, written after it
    DIR/manifest.parquet                 all rows

A clip is whole when its row is there. What is being made has a name in a folder of its own until
it is done, so a run that was killed, or a full disk, leaves nothing half.
"""
from collections.abc import Iterator, Sequence
import contextlib
import fcntl
import json
import os
from pathlib import Path
import secrets
import shutil
from typing import NamedTuple

from flag_sim.dataset.recipe import Recipe

FORMAT = 1
"""Of the folder: raised when what is in it changes its meaning."""
CLIPS_A_FOLDER = 1000
MOST_ASKED = 10_000
"""Clips that are looked for one by one."""
ENDINGS = {'npz': '.npz', 'bag': ''}


class StoreError(Exception):
    """The folder cannot be used, for a reason that its user can see to."""


class Shard(NamedTuple):
    """The part of all clips that one run makes: number, from 1 on, of `count` shards."""

    number: int = 1
    count: int = 1

    @property
    def tag(self) -> str:
        """Return the name that sets its files apart; '' for all clips."""
        return '' if self.count == 1 else f'-{self.number:06d}-of-{self.count:06d}'

    def numbers(self, clips: int) -> range:
        """Return the numbers of its clips."""
        return range(self.number - 1, clips, self.count)


class Store:
    """The folder of a dataset, as its writers see it; tag: of the run's Shard."""

    def __init__(self, folder: str | Path, tag: str = ''):
        self.folder = Path(folder)
        self.tag = tag

    def path(self, number: int, ending: str) -> Path:
        """Return where a file of a clip is."""
        return (self.folder / 'clips' / f'{number // CLIPS_A_FOLDER:06d}'
                / f'{number:09d}{ending}')

    @property
    def making(self) -> Path:
        """Return the folder of what this run is making."""
        return self.folder / f'making{self.tag}'

    @property
    def manifest(self) -> Path:
        """Return where this run's manifest is."""
        return self.folder / f'manifest{self.tag}.parquet'

    @contextlib.contextmanager
    def opened(self, recipe: Recipe, version: str) -> Iterator[None]:
        """
        Hold the folder for this run, made if it is not there.

        Raises StoreError for a folder of something else or of another recipe, and while another
        run of the same shard writes to it.
        """
        try:
            is_made = self._make()
            with self._locked():
                is_new = not (self.folder / 'dataset.json').exists()
                self._claim(recipe, version)
                shutil.rmtree(self.making, ignore_errors=True)  # what a killed run has left
                self.making.mkdir()
                try:
                    yield
                finally:
                    shutil.rmtree(self.making, ignore_errors=True)
                    if is_new and not self.tag:
                        self._forget_if_empty(is_made)
        except OSError as error:
            raise StoreError(f'{self.folder} cannot be written: {error.strerror or error}'
                             ) from error

    def _make(self):
        """Make the folder; return whether it was not there. Raises StoreError for another's."""
        is_made = not self.folder.exists()
        if not is_made and not self.folder.is_dir():
            raise StoreError(f'{self.folder} is there and is not a folder')
        self.folder.mkdir(parents=True, exist_ok=True)
        if not (self.folder / 'dataset.json').exists() and [
                name for name in os.listdir(self.folder) if name not in ('.lock', 'clips')
                and not name.startswith(('.lock-', '.new-', 'making'))]:
            raise StoreError(f'{self.folder} is not empty, and is no dataset')
        return is_made

    def _forget_if_empty(self, is_made):
        """Remove the dataset that a run began and which has no clip, and the folder it made."""
        if not any(self.folder.glob('clips/*/*')):
            for path in (self.folder / 'clips', self.making):
                shutil.rmtree(path, ignore_errors=True)
            for name in (self.manifest.name, 'dataset.json', 'recipe.yaml', '.lock'):
                (self.folder / name).unlink(missing_ok=True)
            if is_made:
                with contextlib.suppress(OSError):  # there is something of another's
                    self.folder.rmdir()

    @contextlib.contextmanager
    def _locked(self):
        """Hold the folder alone, or with other shards each its own part."""
        with contextlib.ExitStack() as stack:
            for name, kind in ([('.lock', fcntl.LOCK_SH), (f'.lock{self.tag}', fcntl.LOCK_EX)]
                               if self.tag else [('.lock', fcntl.LOCK_EX)]):
                file = stack.enter_context(open(self.folder / name, 'w'))
                try:
                    fcntl.flock(file, kind | fcntl.LOCK_NB)
                except BlockingIOError:
                    raise StoreError(f'another run is writing to {self.folder}') from None
            yield

    def _claim(self, recipe, version):
        """Say in the folder what its clips are made by; raise StoreError if that is another."""
        own = {'format': FORMAT, 'recipe': recipe.digest, 'flag_sim': version}
        path = self.folder / 'dataset.json'
        if not path.exists():
            write_whole(self.folder / 'recipe.yaml', recipe.text.encode())
            write_whole(path, json.dumps(own).encode())
            (self.folder / 'clips').mkdir(exist_ok=True)
        try:
            found = json.loads(path.read_text())
        except ValueError:
            found = None
        for name, what in (('format', 'format'), ('recipe', 'recipe'),
                           ('flag_sim', 'version of flag_sim')):
            if not isinstance(found, dict) or found.get(name) != own[name]:
                raise StoreError(f'{self.folder} holds clips of another {what}; its clips would '
                                 'be mixed with these: name another folder')

    def row(self, number: int) -> dict | None:
        """Return the row of a clip that is there, whole or listed as failed, else None."""
        row = self.written_row(number)
        if row is None or row.get('status') != 'whole':
            return row
        file = self.folder / row['file']
        is_there = file.is_dir() if not file.suffix else (
            file.is_file() and file.stat().st_size == row['bytes'])
        return row if is_there else None

    def written_row(self, number: int) -> dict | None:
        """Return the row of a clip, whatever has become of its file, or None."""
        try:
            row = json.loads(self.path(number, '.json').read_bytes())
        except (OSError, ValueError):
            return None
        return row if isinstance(row, dict) and row.get('number') == number else None

    def listed(self, numbers: range) -> Sequence[int]:
        """
        Return those of some numbers whose clips may be there, in their order.

        Of many it looks which files there are: a set may be planned far larger than it is yet.
        """
        if len(numbers) <= MOST_ASKED:
            return numbers
        found = (int(path.stem) for path in self.folder.glob('clips/*/*.json')
                 if path.stem.isdecimal())
        return sorted(number for number in found if number in numbers)

    def beyond(self, numbers: range) -> Sequence[int]:
        """Return the clips beyond some numbers, at the same steps, that may be there."""
        last = numbers.stop // CLIPS_A_FOLDER
        found = (int(path.stem) for folder in self.folder.glob('clips/*')
                 if folder.name.isdecimal() and int(folder.name) >= last
                 for path in folder.glob('*.json') if path.stem.isdecimal())
        return sorted(number for number in found if number >= numbers.stop
                      and (number - numbers.start) % numbers.step == 0)

    def temporary(self, number: int) -> Path:
        """Return a name for what is being made, in a folder of its own."""
        folder = self.making / secrets.token_hex(8)
        folder.mkdir(parents=True)
        return folder / f'{number:09d}'

    def put(self, number: int, made: Path | None, ending: str, row: dict) -> None:
        """Give what was made its name, and write its row."""
        target = self.path(number, ending)
        target.parent.mkdir(parents=True, exist_ok=True)
        if made is not None:
            if target.is_dir():  # a bag without a row, of a run that was killed
                shutil.rmtree(target)
            os.replace(made, target)
        write_whole(self.path(number, '.json'), json.dumps(row).encode())


def write_whole(path: Path, data: bytes) -> None:
    """Write a file beside its place, and put it there when it is whole; raises OSError."""
    beside = path.parent / f'.new-{secrets.token_hex(8)}'
    try:
        beside.write_bytes(data)
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)
