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

"""Datasets are verified: what has changed, what is missing, and what was never written."""
from flag_sim.dataset.store import Store


def test_verify_finds_what_is_not_as_it_was_written(run):
    run()
    assert run('--verify')[0] == 0
    changed, lost = run.folder / 'clips/000000/000000001.npz', Store(run.folder).path(2, '.npz')
    data = bytearray(changed.read_bytes())
    data[-300] ^= 1
    changed.write_bytes(data)
    lost.unlink()
    status, said = run('--verify')
    assert status == 1 and 'clip 1: clips/000000/000000001.npz is not as it was' in said
    assert '1 clips are whole, 0 could not be made, 1 are not as' in said and '1 are not' in said
    assert 'remove it, and the same command makes it again' in said
    assert 'not there are clips 2: ' in said
    changed.unlink()
    assert run()[0] == 0 and run('--verify')[0] == 0
    status, said = run('--verify', '--clips', '20')
    assert status == 1
    assert 'not there are clips 3, 4, 5, 6, 7, 8, 9, 10, 11, 12 and 7 more: ' in said


def test_verify_names_what_is_no_clip_and_no_manifest(run):
    """What a killed run has left of a clip that is made again is nothing of the kind."""
    run()
    added = [run.folder / 'clips' / name for name in (
        '000000/extra.npz', '000000/000000099.npz', '000000/000000001.txt', 'notes', '000009/x')]
    added[-1].parent.mkdir()
    for path in (*added, run.folder / 'clips/000000/.new-half'):
        path.write_bytes(b'')
    status, said = run('--verify')
    assert status == 1 and '.new-half' not in said and '3 clips are whole' in said
    line, = (line for line in said.splitlines() if line.startswith('of no clip are '))
    assert line.count(',') == 4
    assert all(str(path.relative_to(run.folder)) in line for path in added)
    for path in added:
        path.unlink()
    (run.folder / 'manifest-000001-of-000002.parquet').write_bytes(b'PAR1')
    status, said = run('--verify')
    assert status == 1 and 'manifest-000001-of-000002.parquet cannot be read' in said
    (run.folder / 'manifest-000001-of-000002.parquet').unlink()
    assert run('--verify')[0] == 0


def test_a_clip_of_another_size_is_told_and_made_again(run):
    """It is there, and no digest is needed to see that it has changed."""
    run()
    cut = run.folder / 'clips/000000/000000000.npz'
    cut.write_bytes(cut.read_bytes()[:-100])
    status, said = run('--verify')
    assert status == 1 and 'not there are' not in said
    assert ('clip 0: clips/000000/000000000.npz has another size than was written: the command '
            'that made it makes it again') in said
    assert '2 clips are whole, 0 could not be made, 1 are not as' in said
    assert ', 0 are not there' in said
    assert run()[0] == 0 and run('--verify')[0] == 0
