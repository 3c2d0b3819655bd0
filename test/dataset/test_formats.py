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

"""Clips as bags, and as what MeshGraphNets reads."""
import json
import struct

from flag_sim.dataset import Clips, meshgraphnets, tfrecord
from flag_sim.dataset.__main__ import main
from flag_sim.dataset.channels import CHANNELS
from flag_sim.dataset.manifest import rows_of, write
from flag_sim.dataset.store import Store
from flag_sim.ros.bag import RecordedTopics
from flag_sim.ros.frame_message import FrameReader
import numpy as np
import pytest
from support.recipes import text

SPLITS = 'splits: {train: 0.5, validation: 0.5}\n'


def made(folder, content, *arguments):
    """Make a dataset and return its clips."""
    path = folder.with_suffix('.yaml')
    path.write_text(content)
    assert main([str(path), '--output', str(folder), '--shard', '1/1', *arguments]) == 0
    return Clips(folder)


def test_a_bag_holds_the_same_as_arrays(tmp_path, capsys):
    """Every channel, by its topic or beside it; the digest is the same again."""
    content = text(channels=CHANNELS, more='  renderer.samples: 4\n'
                   'tracks: {wind.azimuth: {times: [0, 1], values: [0.0, 1.0]}}\n')
    arrays = made(tmp_path / 'arrays', content, '--clips', '2')
    bags, again = (made(tmp_path / name, content + 'format: bag\n', '--clips', '2')
                   for name in ('bags', 'again'))
    for k in range(2):
        assert set(bags[k]) == set(arrays[k])
        for name, array in arrays[k].items():
            assert np.array_equal(bags[k][name], array, equal_nan=array.dtype.kind == 'f'), name
        assert bags[k].row['sha256'] == again[k].row['sha256']
    with pytest.raises(KeyError):
        bags[0]['sound']
    arguments = [str(tmp_path / 'bags.yaml'), '--output', str(tmp_path / 'bags'), '--verify',
                 '--clips', '2']
    assert main(arguments) == 0
    file, = bags[1].path.glob('*.mcap')
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    assert main(arguments) == 1 and 'clip 1: ' in capsys.readouterr().err


def test_a_bag_can_be_played(tmp_path):
    """Its topics are those of the nodes, whole, with the parameters of every frame."""
    clips = made(tmp_path / 'bags', text(channels=['colour', 'vertices', 'camera'],
                                         more='format: bag\n'), '--clips', '1')
    topics = RecordedTopics(str(clips[0].path))
    assert set(topics.names.values()) == {'parameters', 'camera/image_raw', 'vertices',
                                          'camera/camera_info', 'camera/pose'}
    assert not topics.is_unfinished
    frames = [FrameReader().read(data) for _, _, data in topics.messages(['parameters'])]
    assert [frame.index for frame, _, _ in frames] == [0, 1, 2, 3]
    assert np.allclose(frames[2][1], [clips[0].parameters['wind.speed'] * np.cos(0.35),
                                      clips[0].parameters['wind.speed'] * np.sin(0.35), 0.0])
    topics.close()


def read_records(data):
    """Yield {name: bytes} of the Examples of a file, by the format's own description."""
    def fields(data):
        at = 0
        while at < len(data):
            assert data[at] & 7 == 2
            number, at, length, shift = data[at] >> 3, at + 1, 0, 0
            while True:
                length |= (data[at] & 127) << shift
                shift, at = shift + 7, at + 1
                if not data[at - 1] & 128:
                    break
            yield number, data[at:at + length]
            at += length
    while data:
        (length,), (check,) = struct.unpack('<Q', data[:8]), struct.unpack('<I', data[8:12])
        assert check == tfrecord.masked_checksum(data[:8])
        body, data = data[12:12 + length], data[16 + length:]
        (_, features), = fields(body)
        found = {}
        for _, entry in fields(features):
            (_, name), (_, feature) = fields(entry)
            (_, values), = fields(feature)
            (_, value), = fields(values)
            found[name.decode()] = value
        yield found


def test_a_checksum_is_that_of_the_standard():
    """CRC-32C of '123456789', and of 32 zeros (RFC 3720, B.4)."""
    for data, crc in ((b'123456789', 0xE3069283), (bytes(32), 0x8A9136AA)):
        assert int(tfrecord._crc32c(np.frombuffer(data, np.uint8), tfrecord.TABLE)) == crc


def test_meshgraphnets_reads_clips(tmp_path, capsys):
    """Each field as meta.json says, the hoist as handles, and the wind told."""
    clips = made(tmp_path / 'set', text({'clips: 3': 'clips: 8'}, more=SPLITS))
    output = tmp_path / 'mgn'
    assert meshgraphnets.main([str(tmp_path / 'set'), str(output)]) == 0
    meta = json.loads((output / 'meta.json').read_text())
    assert meta['trajectory_length'] == 4 and abs(meta['dt'] - 1 / 30) < 1e-12
    by_split = {'train': 'train', 'validation': 'valid'}
    for split, name in by_split.items():
        own = [clip for clip in clips if clip.split == split]
        records = list(read_records((output / f'{name}.tfrecord').read_bytes()))
        assert len(records) == len(own) > 0
        for clip, found in zip(own, records):
            assert set(found) == set(meta['field_names'])
            field = {name: np.frombuffer(value, meta['features'][name]['dtype']).reshape(
                meta['features'][name]['shape']) for name, value in found.items()}
            assert np.array_equal(field['world_pos'], clip['vertices'].reshape(4, 35, 3))
            assert np.allclose(field['wind'][:, 0], clip['wind'])
            held = field['node_type'][0, :, 0] == meshgraphnets.HANDLE
            assert held.sum() == 5 and np.ptp(field['world_pos'][:, held], axis=0).max() == 0.0
            a, b, c = field['mesh_pos'][0][field['cells'][0]].transpose(1, 0, 2)
            areas = 0.5 * np.abs(np.cross(np.c_[b - a, np.zeros(48)], np.c_[c - a, np.zeros(48)]))
            assert abs(areas.sum() - 2.25 * 1.5) < 1e-5


@pytest.mark.parametrize('names, words', [
    (['../evil', 'train'], 'names files too'), (['/tmp/evil', 'train'], 'names files too'),
    (['valid', 'validation'], 'two splits would be written to valid.tfrecord')])
def test_splits_of_a_foreign_manifest_are_written_nowhere_else(tmp_path, capsys, names, words):
    """A manifest may be anyone's; nothing is written before its splits are known."""
    made(tmp_path / 'set', text(), '--clips', '2')
    store = Store(tmp_path / 'set')
    write(store.manifest, ({**row, 'split': name}
                           for row, name in zip(rows_of(store, range(2)), names)))
    before = sorted(tmp_path.rglob('*'))
    assert meshgraphnets.main([str(tmp_path / 'set'), str(tmp_path / 'a' / 'b')]) == 1
    assert words in capsys.readouterr().err and sorted(tmp_path.rglob('*')) == before


def test_what_cannot_be_converted_is_said(tmp_path, capsys):
    made(tmp_path / 'set', text(channels=['labels']), '--clips', '1')
    assert meshgraphnets.main([str(tmp_path / 'set'), str(tmp_path / 'mgn')]) == 1
    assert 'no vertices and no wind' in capsys.readouterr().err
    assert meshgraphnets.main([str(tmp_path / 'none'), str(tmp_path / 'mgn')]) == 1
    assert 'has no manifest' in capsys.readouterr().err
