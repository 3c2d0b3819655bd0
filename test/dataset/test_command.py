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

"""The command: whole clips or none, runs that go on, and what is refused."""
import importlib
import json
import os
import resource
import subprocess
import sys

from flag_sim.dataset import Clips
from flag_sim.dataset.__main__ import main
from flag_sim.dataset.store import Shard, Store
import pytest
from support.recipes import text


@pytest.fixture
def run(tmp_path, capsys):
    """Return a function that runs the command in this process: (status, what it said)."""
    def command(*arguments, content=text(), output=tmp_path / 'set'):
        path = tmp_path / 'mine.yaml'
        path.write_text(content)
        status = main([str(path), '--output', str(output), '--shard', '1/1', *arguments])
        return status, ''.join(capsys.readouterr())
    command.folder = tmp_path / 'set'
    return command


def digests(folder):
    """Return {number: digest} of a dataset's whole clips."""
    return {clip.number: clip.row['content'] for clip in Clips(folder)}


def test_a_run_goes_on_where_one_was_interrupted(run, monkeypatch):
    """What is whole stays as it is; what was being made is made again, to the same bytes."""
    made = []
    clip = importlib.import_module('flag_sim.dataset.clip')
    film = clip._film

    def interrupted(recipe, drawn, path, tally):
        made.append(drawn.number)
        if len(made) == 2:
            path.write_bytes(b'half')
            raise KeyboardInterrupt
        return film(recipe, drawn, path, tally)
    monkeypatch.setattr(clip, '_film', interrupted)
    status, said = run()
    assert status == 130 and 'goes on from here' in said and '1 clips of' in said
    first = digests(run.folder)
    assert list(first) == [0] and not list(run.folder.rglob('*half*'))
    assert not (run.folder / 'making').exists()
    assert run()[0] == 0 and made == [0, 1, 1, 2]
    assert first.items() < digests(run.folder).items()
    status, said = run()
    assert status == 0 and '3 of 3 clips are there' in said and len(made) == 4
    again = digests(run.folder)
    run(output=run.folder.parent / 'again')
    assert digests(run.folder.parent / 'again') == again


def test_shards_make_all_clips_once(run):
    """Each with a manifest of its own, which are read together; more clips are added later."""
    for part in ('1/2', '2/2'):
        assert run('--shard', part)[0] == 0
    assert [clip.number for clip in Clips(run.folder)] == [0, 1, 2]
    assert len(list(run.folder.glob('manifest-*.parquet'))) == 2
    assert '3 of 5' in run('--clips', '5')[1]
    assert [clip.number for clip in Clips(run.folder)] == [0, 1, 2, 3, 4]


def test_a_set_may_be_planned_far_larger_than_it_is(run, monkeypatch):
    """Of a thousand million clips those are looked at that are there; so is what is lacking."""
    run()
    engine = importlib.import_module('flag_sim.dataset.engine')
    asked = []

    def alone(job, numbers):
        asked.append(next(iter(numbers)))
        raise KeyboardInterrupt
    monkeypatch.setattr(engine, 'alone', alone)
    status, said = run('--clips', '1000000000')
    assert status == 130 and '3 of 1000000000 clips are there' in said and asked == [3]
    assert '999999997 are not there' in said and len(Clips(run.folder)) == 3
    assert run('--clips', '1000000000', '--verify')[0] == 1


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
    changed.unlink()
    assert run()[0] == 0 and run('--verify')[0] == 0


def test_failed_clips_are_listed_and_not_tried_again(run):
    """Some of a recipe, and all of one."""
    content = text(channels=['labels']).replace(
        '  renderer.width', '  renderer.camera.near: {choice: [0.05, 900.0]}\n  renderer.width')
    status, said = run('--clips', '12', content=content)
    clips = Clips(run.folder)
    assert status == 0 and 'clip ' in said and clips.failed
    assert set(clips.failed.values()) == {'the camera does not see the flag in any frame'}
    assert len(clips) + len(clips.failed) == 12
    assert '12 of 12 clips are there' in run('--clips', '12', content=content)[1]
    other = run.folder.parent / 'none'
    status, said = run(content=content.replace('0.05, 900.0', '800.0, 900.0'), output=other)
    assert status == 1 and '3 could not be made' in said


def test_a_fault_in_one_clip_stops_no_other(run, monkeypatch):
    """It is listed with what it was, and tried again by the next run."""
    clip = importlib.import_module('flag_sim.dataset.clip')
    film = clip._film

    def faulty(recipe, drawn, path, tally):
        if drawn.number == 1:
            raise ZeroDivisionError('a fault')
        return film(recipe, drawn, path, tally)
    monkeypatch.setattr(clip, '_film', faulty)
    status, said = run()
    assert status == 0 and 'clip 1: ZeroDivisionError: a fault' in said
    monkeypatch.setattr(clip, '_film', film)
    assert '2 of 3 clips are there' in run()[1] and len(Clips(run.folder)) == 3


def test_a_full_disk_leaves_nothing_half(run):
    """As a limit of a file's size has it; what is whole before stays."""
    run('--clips', '1')
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1500, hard))
    try:
        status, said = run()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert status == 1 and 'cannot be written: File too large' in said
    assert 'Traceback' not in said
    names = {path.name for path in run.folder.rglob('*') if path.is_file()}
    assert names >= {'000000000.npz', '000000000.json'}
    assert not [name for name in names if name.startswith(('000000001', '000000002', '.new'))]
    assert run()[0] == 0 and len(Clips(run.folder)) == 3


def test_another_recipe_or_version_is_refused(run):
    """Comments, order and the number of clips make no other recipe."""
    run()
    status, said = run(content=text({'seed: 7': 'seed: 8'}))
    assert status == 1 and 'another recipe' in said
    lines = text().splitlines(keepends=True)
    same = ['# mine\n', *lines[1::-1], *lines[2:]]
    assert run(content=''.join(same).replace('clips: 3', 'clips: 2'))[0] == 0
    claim = json.loads((run.folder / 'dataset.json').read_text())
    for other, words in (({**claim, 'flag_sim': '0.0.1'}, 'version of flag_sim'),
                         ({**claim, 'format': 0}, 'format'), ([], 'format')):
        (run.folder / 'dataset.json').write_text(json.dumps(other))
        status, said = run()
        assert status == 1 and words in said


def test_two_runs_do_not_write_at_once(run):
    """Of all clips one, or of each shard one."""
    recipe = importlib.import_module('flag_sim.dataset.recipe').recipe_of(text())
    version = importlib.import_module('flag_sim.dataset.clip').versions()['flag_sim']
    with Store(run.folder).opened(recipe, version):
        for shard in ('1/1', '1/2'):
            status, said = run('--shard', shard)
            assert status == 1 and 'another run is writing' in said
    with Store(run.folder, Shard(1, 2).tag).opened(recipe, version):
        assert 'another run' in run('--shard', '1/2')[1]
        assert 'another run' in run('--shard', '1/1')[1]
        assert run('--shard', '2/2')[0] == 0


def test_folders_that_cannot_be_a_dataset_are_refused(run, tmp_path):
    (tmp_path / 'file').write_text('')
    (tmp_path / 'full').mkdir()
    (tmp_path / 'full' / 'thesis.tex').write_text('')
    for output, words in (('file', 'is not a folder'), ('full', 'is not empty'),
                          ('file/below', 'cannot be written'),
                          ('/proc/set', 'cannot be written')):
        status, said = run(output=tmp_path / output)
        assert status == 1 and words in said and 'Traceback' not in said, output
    assert run('--verify', output=tmp_path / 'nowhere')[0] == 1
    assert os.listdir(tmp_path / 'full') == ['thesis.tex']


@pytest.mark.parametrize('arguments', [
    ['--shard', '5/4'], ['--shard', '0/4'], ['--shard', '1'], ['--shard', 'a/b'],
    ['--shard', '1/2/3'], ['--clips', '0'], ['--clips', '-3'], ['--clips', '1e3'],
    ['--clips', '9' * 30], ['--scheduler', 'tcp://localhost:1'], ['--frames', '3']])
def test_bad_arguments_are_refused(run, arguments, capsys):
    with pytest.raises(SystemExit) as end:
        run(*arguments)
    assert end.value.code == 2 and 'usage: dataset' in capsys.readouterr().err


def test_a_bad_recipe_makes_nothing(run):
    for content, words in ((text({'clips: 3': 'clips: none'}), 'mine.yaml:2: clips must be'),
                           (text(more='  scene.pole.diameter: 5.0\n  scene.pole.height: 4.0\n'),
                            'no clip of this recipe can be made')):
        status, said = run(content=content)
        assert status == 2 and words in said and not run.folder.exists()


def test_it_says_what_is_lacking_to_be_installed(tmp_path):
    hide = ('import sys; sys.modules["pyarrow"] = sys.modules["yaml"] = None\n'
            'from flag_sim.dataset.__main__ import main; main(["r.yaml", "--output", "set"])')
    done = subprocess.run([sys.executable, '-c', hide], cwd=tmp_path, capture_output=True,
                          text=True)
    assert done.returncode == 2 and "pip install 'flag_sim[dataset]'" in done.stderr
    assert 'Traceback' not in done.stderr
