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

"""Reading a dataset: clips as numpy arrays, by number or by split."""
from collections.abc import Iterator, Mapping, Sequence
import difflib
from pathlib import Path

from flag_sim.dataset import bag, manifest
import numpy as np


class Parameters(dict):
    """{node.parameter: value} of a clip; a name that is not among them is said to be none."""

    def __missing__(self, name: object) -> None:
        """Raise KeyError with the names that are nearest."""
        if name == manifest.KEYS:
            raise KeyError(f"the keys of tracks are in clip.row['{name}'], as JSON")
        near = difflib.get_close_matches(str(name), self, n=3)
        raise KeyError(f'a clip has no parameter {name!r}; '
                       + (f'near it are {", ".join(near)}' if near else
                          'clip.parameters.keys() are all that there are'))


class Clip(Mapping):
    """
    A clip: {array: (frames, ...)}, each read when it is asked for.

    number; split; row: its row of the manifest, {column: value}; path: of its file.
    """

    def __init__(self, folder: Path, row: Mapping[str, object]):
        self.row = dict(row)
        self.number = self.row['number']
        self.split = self.row['split']
        self.path = Path(folder) / self.row['file']

    @property
    def parameters(self) -> Parameters:
        """Return {node.parameter: value} of all that it was made by."""
        return Parameters((name, value) for name, value in self.row.items() if name.startswith(
            ('wind.', 'physics.', 'renderer.')) and name != manifest.KEYS)

    def __getitem__(self, name: str) -> np.ndarray:
        """Return an array; raise KeyError, with those that there are, for another name."""
        try:
            if self.path.is_dir():
                return bag.read_array(self.path, name)
            with np.load(self.path) as file:
                return file[name]
        except KeyError:
            raise KeyError(f'clip {self.number} has no array {name!r}; it has {", ".join(self)}'
                           ) from None

    def __contains__(self, name: object) -> bool:
        """Return whether the clip has an array of that name, without reading it."""
        return name in list(iter(self))

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the arrays."""
        if self.path.is_dir():
            return iter(bag.names_in(self.path))
        with np.load(self.path) as file:
            return iter(list(file.files))

    def __len__(self) -> int:
        """Return the number of arrays."""
        return len(list(iter(self)))


class Clips(Sequence):
    """
    The whole clips of a dataset, in the order of their numbers.

    path: the dataset's folder; split: of which clips, None for all. table: the manifest, a
    pyarrow.Table of all clips, the failed ones too. It is small, and goes to other processes.

    >>> clips = Clips('flags', split='train')
    >>> clips[0]['depth']              # (frames, height, width) float32
    >>> clips[0].parameters['wind.speed']

    Raises FileNotFoundError where there is no manifest, and ValueError for a split that it has
    not and for a manifest that cannot be read.
    """

    def __init__(self, path: str | Path, split: str | None = None):
        self.folder = Path(path)
        self.table = manifest.read(self.folder)
        splits = self.table.column('split').to_pylist()
        if split is not None and split not in splits:
            raise ValueError(f'split must be one of {", ".join(sorted(set(splits)))}, not {split}')
        self._places = [place for place, (status, own) in enumerate(zip(
            self.table.column('status').to_pylist(), splits))
            if status == 'whole' and split in (None, own)]

    def __len__(self) -> int:
        """Return the number of whole clips."""
        return len(self._places)

    def __getitem__(self, index: int) -> Clip:
        """Return a Clip, or the list of those of a slice."""
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        place = self._places[index]
        return Clip(self.folder, self.table.slice(place, 1).to_pylist()[0])

    @property
    def failed(self) -> dict[int, str]:
        """Return {number: reason} of the clips that could not be made."""
        return {number: reason for number, status, reason in zip(*(
            self.table.column(name).to_pylist() for name in ('number', 'status', 'reason')))
            if status != 'whole'}
