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
A dataset in the layout of MeshGraphNets: `python -m flag_sim.dataset.meshgraphnets DIR OUTPUT`.

One file of TFRecord a split (train, valid, test) and a meta.json, with the fields of flag_dynamic:
cells, mesh_pos, node_type and world_pos. One more, `wind` (frames, 1, 3) [m/s], tells the network
what its cloth moves in; flag_dynamic does not say it.
"""
import argparse
from collections.abc import Sequence
import json
from pathlib import Path
import sys

from flag_sim.dataset.reader import Clip, Clips
from flag_sim.dataset.splits import check_name
from flag_sim.dataset.tfrecord import example, record
from flag_sim.drawing.mesh import grid_triangles
from flag_sim.parameters.arguments import given_path
import numpy as np

NORMAL, HANDLE = 0, 3
"""Types of nodes: one that moves by itself, and one that is held."""
NAMES = {'validation': 'valid'}
"""Splits that are called otherwise there."""
KINDS = {'int32': np.int32, 'float32': np.float32}
NEEDED = ('vertices', 'wind')


def fields_of(clip: Clip) -> dict[str, np.ndarray]:
    """
    Return the fields of a clip.

    cells: (1, m, 3) int32, the nodes of each triangle; mesh_pos: (1, n, 2) float32, where nodes
    are on the flat cloth [m], from the upper hoist corner along the hoist's edge and down;
    node_type: (1, n, 1) int32; world_pos: (frames, n, 3) float32 [m]; wind: (frames, 1, 3)
    float32 [m/s]. Raises KeyError where the clip has no vertices or no wind.
    """
    world = clip['vertices']
    frames, rows, columns = world.shape[:3]
    width = clip.parameters['physics.flag.width'] or clip.parameters['physics.pole.height'] / 6.0
    length = clip.parameters['physics.flag.length'] or 1.5 * width
    down, along = np.meshgrid(np.linspace(0.0, width, rows), np.linspace(0.0, length, columns),
                              indexing='ij')
    kinds = np.full((rows, columns), NORMAL, np.int32)
    kinds[:, 0] = HANDLE
    return {'cells': grid_triangles(rows, columns)[None],
            'mesh_pos': np.stack([along, down], axis=-1).reshape(1, -1, 2).astype(np.float32),
            'node_type': kinds.reshape(1, -1, 1),
            'world_pos': world.reshape(frames, -1, 3),
            'wind': clip['wind'].reshape(frames, 1, 3).astype(np.float32)}


def meta_of(fields: dict[str, np.ndarray], rate: float) -> dict:
    """Return the content of meta.json; rate: of the frames [Hz]."""
    frames = len(fields['world_pos'])
    return {'simulator': 'flag_sim', 'dt': 1.0 / rate, 'collision_radius': None,
            'trajectory_length': frames, 'field_names': list(fields),
            'features': {name: {
                'type': 'dynamic' if len(field) == frames > 1 else 'static',
                'shape': [len(field), -1, field.shape[2]], 'dtype': field.dtype.name}
                for name, field in fields.items()}}


def convert(dataset: Path, output: Path) -> dict[str, int]:
    """
    Write all clips of a dataset; return {split: how many}.

    Raises ValueError where it has no clip, clips that lack vertices or wind, or splits that are
    no names of different files, and OSError.
    """
    clips, files, counts = Clips(dataset), {}, {}
    if not len(clips):
        raise ValueError(f'{dataset} has no clip')
    lacking = [name for name in NEEDED if name not in clips[0]]
    if lacking:
        raise ValueError(f'the clips have no {" and no ".join(lacking)}: name them as channels')
    names = _names_of(clips)
    output.mkdir(parents=True, exist_ok=True)
    try:
        for clip in clips:
            fields = fields_of(clip)
            if not counts:
                (output / 'meta.json').write_text(
                    json.dumps(meta_of(fields, clip.row['rate'])))
            name = names[clip.split]
            if name not in files:
                files[name] = open(output / f'{name}.tfrecord', 'wb')
            files[name].write(record(example(
                {field: np.ascontiguousarray(values).tobytes()
                 for field, values in fields.items()})))
            counts[name] = counts.get(name, 0) + 1
    finally:
        for file in files.values():
            file.close()
    return counts


def _names_of(clips):
    """Return {split: name of its file}; a manifest may be anyone's, so its splits are checked."""
    names = {}
    for split in clips.table.column('split').unique().to_pylist():
        check_name(split)
        name = NAMES.get(split, split)
        if name in names.values():
            raise ValueError(f'two splits would be written to {name}.tfrecord')
        names[split] = name
    return names


def main(args: Sequence[str] | None = None) -> int:
    """Convert a dataset; return the exit status."""
    parser = argparse.ArgumentParser(prog='meshgraphnets', description=__doc__)
    parser.add_argument('dataset', type=given_path, help='the folder of a dataset')
    parser.add_argument('output', type=given_path, help='the folder of what is written')
    options = parser.parse_args(args)
    try:
        counts = convert(options.dataset, options.output)
    except (OSError, ValueError, ImportError) as error:
        print(f'meshgraphnets: {error}', file=sys.stderr)
        return 1
    print(', '.join(f'{count} clips in {name}.tfrecord' for name, count in counts.items()))
    return 0


if __name__ == '__main__':
    sys.exit(main())
