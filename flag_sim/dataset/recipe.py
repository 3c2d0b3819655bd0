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

"""A recipe: what the clips of a dataset have in common, and what is drawn for each."""
from collections.abc import Mapping
import dataclasses
import functools
import hashlib
import json
from pathlib import Path

from flag_sim.dataset.channels import CHANNELS, expanded
from flag_sim.dataset.drawn_tracks import DrawnTrack, read_track
from flag_sim.dataset.draws import MOST_SEED, Stream
from flag_sim.dataset.laws import Law, read_law
from flag_sim.dataset.marked_yaml import parse, read_text
from flag_sim.dataset.splits import read_splits, Splits
from flag_sim.dataset.targets import declarations, FILMED, refusal, spread
from flag_sim.declarations.nodes import defaults, named
from flag_sim.parameters import checks

ENTRIES = ('seed', 'clips', 'frames', 'rate', 'format', 'channels', 'parameters', 'tracks',
           'splits')
FORMATS = ('npz', 'bag')
MOST_CLIPS = 10**9
MOST_FRAMES = 1_000_000


class Drawn:
    """
    What one clip is made by.

    number: of the clip; split: its name; chosen: {node.parameter: value} of what the recipe says,
    keys too, as parameters of the wind; values: {node: {parameter: value}} of all parameters.
    """

    def __init__(self, number: int, split: str, chosen: Mapping, keys: Mapping):
        self.number = number
        self.split = split
        self.chosen = {**chosen, **{f'wind.{name}': value for name, value in keys.items()}}
        own = spread(chosen)
        tracks = [name.removeprefix('keys.').removesuffix('.times') for name in keys
                  if name.endswith('.times')]
        own['wind'].update(keys, tracks=tracks)
        self.values = {node: {**defaults(node), **own[node]} for node in FILMED}

    def params_file(self, frames: int, rate: float) -> dict:
        """Return the params file with which the nodes film this clip, as YAML's plain values."""
        own = spread({name: value for name, value in self.chosen.items()
                      if not name.startswith('wind.keys.')})
        wind = self.values['wind']
        own['wind'].update(
            {name: value for name, value in wind.items() if name.startswith('keys.')},
            rate=rate, frames=frames, pace='lockstep')
        if wind['tracks']:
            own['wind']['tracks'] = wind['tracks']
        return {f'/**/{node}': {'ros__parameters': values}
                for node, values in own.items() if values}


@dataclasses.dataclass(frozen=True, eq=False)
class Recipe:
    """
    A recipe that was read and found to be right.

    text: as it was written; seed; clips: how many; frames: of each; rate [Hz]; file_format: one
    of FORMATS; channels: names of CHANNELS; laws: {node.parameter: Law}; tracks; splits.
    """

    text: str
    seed: int
    clips: int
    frames: int
    rate: float
    file_format: str
    channels: tuple[str, ...]
    laws: dict[str, Law]
    tracks: tuple[DrawnTrack, ...]
    splits: Splits

    @functools.cached_property
    def digest(self) -> str:
        """
        Return the SHA-256 of all that the clips depend on, in hexadecimal digits.

        Two recipes that differ in comments, in their order or in the number of clips are the same.
        """
        content = {'seed': self.seed, 'frames': self.frames, 'rate': self.rate,
                   'format': self.file_format, 'channels': sorted(self.channels),
                   'laws': {name: dataclasses.astuple(law) for name, law in self.laws.items()},
                   'tracks': {track.name: dataclasses.astuple(track) for track in self.tracks},
                   'splits': dataclasses.astuple(self.splits)}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def draw(self, number: int) -> Drawn:
        """Return what a clip is made by: the same whoever asks, and in whatever order."""
        stream_of = functools.partial(Stream, self.seed, number)
        chosen = {name: law.draw(stream_of(name)) for name, law in self.laws.items()}
        keys = {}
        for track in self.tracks:
            keys.update(track.draw(stream_of))
        return Drawn(number, self.splits.of(stream_of('split'), chosen), chosen, keys)


def read_recipe(path: str | Path) -> Recipe:
    """Return the recipe of a file; raise MarkedError, which names file and line, for a bad one."""
    return recipe_of(read_text(path), str(path))


def recipe_of(text: str, source: str = 'recipe') -> Recipe:
    """Return the recipe of a text; source: its name in messages. Raises MarkedError."""
    marked = parse(text, source)
    entries = marked.entries()
    for name, one in entries.items():
        if name not in ENTRIES:
            raise one.error(f'a recipe has no entry {name!r}; it has {", ".join(ENTRIES)}')
    for name in ('seed', 'clips', 'frames', 'channels'):
        if name not in entries:
            raise marked.error(f'the recipe needs the entry {name}')
    laws = _read_laws(entries.get('parameters'))
    tracks = _read_tracks(entries.get('tracks'), laws)
    rate = entries['rate'].checked(_rate) if 'rate' in entries else defaults('wind')['rate']
    return Recipe(
        text, entries['seed'].checked(checks.whole, 0, MOST_SEED),
        entries['clips'].checked(checks.whole, 1, MOST_CLIPS),
        entries['frames'].checked(checks.whole, 1, MOST_FRAMES), rate,
        entries['format'].checked(checks.choice, FORMATS) if 'format' in entries else FORMATS[0],
        _read_channels(entries['channels']), laws, tracks,
        read_splits(entries['splits'], laws) if 'splits' in entries else Splits())


def _rate(where, value):
    return named('wind')['rate'].accept(value, where)


def _read_channels(marked):
    names = [one.checked(checks.choice, tuple(CHANNELS)) for one in marked.items()]
    for number, one in enumerate(marked.items()):
        if one.value in names[:number]:
            raise one.error(f'channel {one.value} stands there twice')
    if not names:
        raise marked.error('channels must name at least one')
    return expanded(names)


def _read_laws(marked):
    """Return {node.parameter: Law} of what a recipe says of parameters."""
    known, laws = declarations(), {}
    for name, one in ({} if marked is None else marked.entries()).items():
        if name not in known:
            raise one.error(refusal(name))
        laws[name] = read_law(one, known[name], name)
        if known[name].fixed and laws[name].name != 'fixed':
            raise one.error(f'{name} is one value for all clips')
    return laws


def _read_tracks(marked, laws):
    tracks = []
    for name, one in ({} if marked is None else marked.entries()).items():
        tracks.append(read_track(name, one))
        node, _, own = name.partition('.')
        for said in (name, f'scene.{own}'):
            if said in laws and (said == name or node != 'wind'):
                raise one.error(f'{said} is both in parameters and in tracks')
    return tuple(tracks)
