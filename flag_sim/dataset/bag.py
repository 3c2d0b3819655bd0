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
A clip as a bag of the same topics as live, so that RViz, Foxglove and rosbag2 read it.

What has no topic (motion forward, what is hidden, velocities, ...) is beside it, in arrays.npz.
Writing needs ROS, reading does not.
"""
from collections.abc import Mapping
import contextlib
import hashlib
import io
from pathlib import Path

from flag_sim.dataset.file_digest import file_digest
from flag_sim.dataset.recipe import Drawn, Recipe
import numpy as np

TOPICS = {
    'colour': {'colour': 'camera/image_raw'},
    'depth': {'depth': 'camera/depth/image_raw'},
    'normals': {'normals': 'camera/normals/image_raw'},
    'labels': {'labels': 'camera/labels/image_raw'},
    'texture_coordinates': {'texture_coordinates': 'camera/texture_coordinates/image_raw'},
    'backward_flow': {'backward_flow': 'camera/flow/image_raw'},
    'vertices': {'vertices': 'vertices'},
    'wind': {'wind': 'wind'},
    'pole_load': {'pole_load': 'pole_load'},
}
"""Of channels: {array: the topic that says the same}."""
OF_CAMERA = ('camera/camera_info', 'camera/pose')
BESIDE = 'arrays.npz'


class BagWriter:
    """Writes a clip as a folder at a path; a context, which closes what it has opened."""

    def __init__(self, path: Path, recipe: Recipe, drawn: Drawn):
        from flag_sim.ros.clip_bag import ClipBag
        topics = [topic for name in recipe.channels for topic in TOPICS.get(name, {}).values()]
        topics += OF_CAMERA if 'camera' in recipe.channels else ()
        self._said = {array for name in recipe.channels for array in TOPICS.get(name, ())}
        self._path, self._values = path, drawn.values['renderer']
        self._bag = ClipBag(path, topics, drawn.number)
        self._open = contextlib.ExitStack()
        self._open.callback(self._close)
        self._beside = {}

    def append(self, arrays: Mapping[str, np.ndarray], view: object) -> None:
        """Add a frame: its View as messages, and what of its arrays no message says."""
        keyed = {name.removeprefix('renderer.'): value for name, value
                 in view.moment.keyed.items() if name.startswith('renderer.')}
        self._bag.write(view.moment, view.frame, {**self._values, **keyed})
        for name, part in arrays.items():
            if name not in self._said:
                self._beside.setdefault(name, []).append(np.copy(part))

    def finish(self) -> dict[str, object]:
        """Close the bag; return the size of the folder in bytes and the SHA-256 of its files."""
        self._open.pop_all()
        self._bag.close()
        data = io.BytesIO()
        np.savez_compressed(data, **{name: np.stack(parts)
                                     for name, parts in self._beside.items()})
        (self._path / BESIDE).write_bytes(data.getvalue())
        return {'bytes': sum(file.stat().st_size for file in self._path.iterdir()),
                'sha256': digest_of(self._path)}

    def _close(self):
        with contextlib.suppress(OSError):
            self._bag.close()

    def __enter__(self) -> 'BagWriter':
        return self

    def __exit__(self, *_):
        """Close what is open."""
        self._open.close()


def digest_of(folder: Path) -> str:
    """Return the SHA-256 of the messages and arrays of a bag's folder; raises OSError."""
    digest = hashlib.sha256()
    for path in (*sorted(folder.glob('*.mcap')), folder / BESIDE):
        digest.update(file_digest(path).digest())
    return digest.hexdigest()


def names_in(folder: Path) -> list[str]:
    """Return the names of the arrays of a clip that is a bag."""
    from rosbags.highlevel import AnyReader
    with AnyReader([folder]) as reader, np.load(folder / BESIDE) as file:
        topics = {one.topic.lstrip('/') for one in reader.connections}
        return [*file.files, *(array for said in TOPICS.values()
                               for array, topic in said.items() if topic in topics)]


def read_array(folder: Path, name: str) -> np.ndarray:
    """Return an array of a clip that is a bag; raise KeyError if it has none of that name."""
    from rosbags.highlevel import AnyReader
    topics = {array: f'/{topic}' for said in TOPICS.values() for array, topic in said.items()}
    with np.load(folder / BESIDE) as file:
        if name in file.files:
            return file[name]
    with AnyReader([folder]) as reader:
        chosen = [one for one in reader.connections if one.topic == topics.get(name)]
        if not chosen:
            raise KeyError(name)
        return np.stack([_as_array(reader.deserialize(data, one.msgtype))
                         for one, _, data in reader.messages(chosen)])


def _as_array(message):
    """Return what an Image, a cloud (without its normals), a vector or a wrench says."""
    if hasattr(message, 'wrench'):
        return np.array([getattr(one, axis) for one in (message.wrench.force,
                                                        message.wrench.torque) for axis in 'xyz'])
    if hasattr(message, 'vector'):
        return np.array([message.vector.x, message.vector.y, message.vector.z])
    kind = np.float32 if hasattr(message, 'point_step') or message.encoding.startswith(
        '32F') else np.uint8
    pixels = np.frombuffer(message.data, kind).reshape(message.height, message.width, -1)
    if hasattr(message, 'point_step'):
        return pixels[..., :3]
    return pixels[..., 0] if pixels.shape[2] == 1 else pixels
