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

"""A shot for a test: the real nodes play it in lockstep, and its frames are arrays."""
from collections.abc import Iterator, Mapping, Sequence
import dataclasses
import itertools
from pathlib import Path
import time

from flag_sim.declarations.nodes import named
from flag_sim.parameters import checks
from flag_sim.parameters.config import config_path
from flag_sim.parameters.plain_file import opened
from flag_sim.tools.graph import Graph
import numpy as np
from rosbags.highlevel import AnyReader
import yaml

SECONDS = 300.0
"""How long a film may take [s]: kernels that are compiled first take up to a minute in CI."""
MOST_FRAMES = 1_000_000
POLL_PERIOD = 0.1
"""How often to check whether a node has failed [s]."""
IMAGE_TYPES = {'rgb8': (np.uint8, 3), '8UC1': (np.uint8, 1), '32FC1': (np.float32, 1),
               '32FC2': (np.float32, 2), '32FC3': (np.float32, 3)}
NODES = ('wind', 'physics', 'renderer')
FIXED = {'frames': 'it is the first argument', 'pace': 'a film is made in lockstep',
         'wait_for': 'it waits for renderer and recorder', 'paused': 'nobody would end the pause'}
"""The wind's parameters that a film sets itself, before those of a shot, and why."""


@dataclasses.dataclass(frozen=True)
class Filmed:
    """
    What a test has filmed.

    bag: the folder of the bag; topics: what every frame has.
    """

    bag: Path
    topics: tuple[str, ...]

    def __iter__(self) -> Iterator[dict]:
        """
        Yield {topic: what it says} of each frame, in order, with its `stamp` [s].

        An Image is an array (height, width) or (height, width, channels), `vertices` one of
        (rows, columns, 6) with the normals behind the positions, all else the message.
        """
        with AnyReader([self.bag]) as reader:
            chosen = [one for one in reader.connections if one.topic.lstrip('/') in self.topics]
            for at, messages in itertools.groupby(reader.messages(chosen), lambda one: one[1]):
                frame = {'stamp': at * 1e-9}
                for connection, _, data in messages:
                    frame[connection.topic.lstrip('/')] = _as_array(
                        reader.deserialize(data, connection.msgtype))
                yield frame


def _as_array(message):
    """Return an Image or PointCloud2 as an array, and any other message as it is."""
    encoding = getattr(message, 'encoding', None)
    if encoding is not None:
        kind, channels = IMAGE_TYPES[encoding]
        pixels = np.frombuffer(message.data, kind).reshape(message.height, message.width, channels)
        return pixels[..., 0] if channels == 1 else pixels
    if hasattr(message, 'point_step'):
        return np.frombuffer(message.data, np.float32).reshape(message.height, message.width, -1)
    return message


def play(folder: Path, frames: int, topics: Sequence[str] = ('camera/image_raw',),
         shot: str | Path | None = None, **nodes: Mapping[str, object]) -> Filmed:
    """
    Play so many frames of a shot in lockstep, record topics into a bag, and return what it holds.

    folder: to be made, for the bag and the nodes' logs; shot: a params file, or the name of one of
    config/; nodes: for wind, physics and renderer {parameter: value}, which counts before the
    shot's. Raises TypeError for other nodes, ValueError for other parameters, for those that are
    FIXED and for what is no file, FileNotFoundError for a name that config/ has not, and
    AssertionError, with the logs, if the shot did not reach its end.
    """
    unknown = nodes.keys() - set(NODES)
    if unknown:
        raise TypeError(f'{sorted(unknown)[0]!r} is none of {", ".join(NODES)}')
    checks.whole('frames', frames, 1, MOST_FRAMES)
    checks.require(not isinstance(topics, str) and len(topics) > 0, 'topics', 'a list of names',
                   topics)
    for node, values in nodes.items():
        for name in values.keys() - named(node).keys():
            raise ValueError(f'{node} has no parameter {name!r}')
    for name in FIXED.keys() & nodes.get('wind', {}).keys():
        raise ValueError(f'wind: {name} cannot be given: {FIXED[name]}')
    files = [] if shot is None else [_shot_file(shot)]
    folder.mkdir(parents=True)
    given = folder / 'given.yaml'
    given.write_text(yaml.safe_dump({
        f'/**/{name}': {'ros__parameters': dict(values)} for name, values in nodes.items()}))
    arguments = [word for file in (*files, given) for word in ('--params-file', str(file))]
    with Graph(folder / 'log') as graph:
        for name in ('physics', 'renderer'):
            graph.start(name, *arguments)
        graph.start('recorder', '-p', f'path:={folder / "bag"}', '-p', f'frames:={frames}',
                    '-p', f'topics:=[{", ".join(topics)}]')
        graph.start('wind', *arguments, '-p', 'pace:=lockstep', '-p', f'frames:={frames}',
                    '-p', 'wait_for:=[renderer, recorder]', '-p', 'paused:=false')
        awaited, end = ['wind', 'recorder'], time.monotonic() + SECONDS
        while awaited and not graph.failed() and time.monotonic() < end:
            awaited = [name for name in awaited if graph.wait(name, POLL_PERIOD) is None]
        logs = '\n'.join(f'--- {name} said:\n{graph.log(name)}' for name in graph.processes)
        assert not awaited and not graph.failed(), f'the shot did not reach its end\n{logs}'
    return Filmed(folder / 'bag', tuple(topics))


def _shot_file(shot):
    """Return the params file of a shot: a path, or the name of one of config/."""
    if not isinstance(shot, Path) and not str(shot).endswith('.yaml'):
        return config_path(f'{shot}.yaml')
    try:
        with opened(shot):
            return Path(shot).absolute()
    except OSError as error:
        raise ValueError(f'shot {shot} cannot be read: {error.strerror}') from None
