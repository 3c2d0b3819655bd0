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
import threading

from flag_sim.dataset import Clips, engine
from flag_sim.dataset.__main__ import main
from flag_sim.dataset.store import Shard, Store, StoreError
import pytest
from support.recipes import text


MORE = {'clips: 3': 'clips: 9'}


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
    asked = []

    def alone(job, numbers):
        asked.append(next(iter(numbers)))
        raise KeyboardInterrupt
    monkeypatch.setattr(engine, 'alone', alone)
    status, said = run('--clips', '1000000000')
    assert status == 130 and '3 of 1000000000 clips are there' in said and asked == [3]
    assert '999999997 are not there' in said and len(Clips(run.folder)) == 3
    assert run('--clips', '1000000000', '--verify')[0] == 1


def test_a_run_for_fewer_clips_hides_none(run):
    """The manifest lists what is there, and all of it is verified; of a shard its own."""
    for part in ('1/2', '2/2'):
        run('--shard', part, '--clips', '6')
    status, said = run('--clips', '2')
    assert status == 0 and '2 of 2 clips are there' in said and ': 6 clips of' in said
    assert '0 are not there yet' in said
    for path in run.folder.glob('manifest-*.parquet'):
        path.unlink()
    assert [clip.number for clip in Clips(run.folder)] == [0, 1, 2, 3, 4, 5]
    assert ': 3 clips of' in run('--clips', '2', '--shard', '2/2')[1]
    path = Store(run.folder).path(5, '.npz')
    path.write_bytes(bytes(path.stat().st_size))
    for arguments in ((), ('--clips', '1'), ('--shard', '2/2')):
        status, said = run('--verify', *arguments)
        assert status == 1 and 'clip 5: ' in said
    assert run('--verify', '--shard', '1/2')[0] == 0


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
                            'no clip of this recipe can be made'),
                           (text(MORE, more='  physics.solver: {choice: [symplectic, verlet]}\n'
                                 '  physics.air.added_mass: 0.5\n'),
                            'no clip whose physics.solver is verlet can be made: air.added_mass'),
                           (text(MORE, more='  physics.solver: verlet\n'
                                 '  physics.air.added_mass: {choice: [0.0, 0.5]}\n'),
                            'no clip whose physics.air.added_mass is 0.5 can be made')):
        status, said = run(content=content)
        assert status == 2 and words in said and not run.folder.exists()


def test_a_flag_that_is_never_seen_shows_as_clips_are_made(run):
    """As the page says: all are listed as failed, and the status tells that none is whole."""
    away = text({'clips: 3': 'clips: 2'}, channels=['labels']).replace(
        '  renderer.width', '  renderer.camera.target: [0.0, 0.0, 500.0]\n  renderer.width')
    status, said = run(content=away)
    assert status == 1 and '0 clips of 0 GB, 2 could not be made' in said
    assert 'clip 1: the camera does not see the flag in any frame' in said


def test_a_run_that_came_to_no_clip_leaves_no_dataset(run, monkeypatch, tmp_path):
    """So another recipe can be tried in the same place; a folder that was there stays, empty."""
    def fail(address):
        raise StoreError(f'no scheduler at {address}')
    monkeypatch.setattr(engine, 'cluster', fail)
    monkeypatch.setattr(engine, 'warm_up', lambda recipe: None)
    (tmp_path / 'mine.yaml').write_text(text())
    (tmp_path / 'there').mkdir()
    for name, is_left in (('set', False), ('there', True)):
        for more in (['--scheduler', 'garbage'], []):
            assert main([str(tmp_path / 'mine.yaml'), '--output', str(tmp_path / name), *more]
                        ) == 1
            assert (tmp_path / name).exists() == is_left
            assert not is_left or not os.listdir(tmp_path / name)
    run('--clips', '1')
    assert main([str(tmp_path / 'mine.yaml'), '--output', str(run.folder)]) == 1
    assert len(Clips(run.folder)) == 1


def test_it_says_once_that_kernels_are_compiled(run, monkeypatch):
    """Before the time of clips is taken; and nothing where they are there."""
    module = importlib.import_module('flag_sim.dataset.__main__')
    compiled = []

    def warm_up(recipe):
        compiled.append(recipe)
        next(one for one in threading.enumerate() if one.name == 'tells of compiling').join()
    monkeypatch.setattr(module, 'compilations', lambda: len(compiled))
    monkeypatch.setattr(module, 'LOOK', 0.001)
    monkeypatch.setattr(engine, 'warm_up', warm_up)
    assert run()[1].count('compiling what clips need') == 1
    monkeypatch.setattr(engine, 'warm_up', lambda recipe: None)
    assert 'compiling' not in run('--clips', '4')[1]


def test_a_low_speed_has_a_digit_that_says_something():
    speed = importlib.import_module('flag_sim.dataset.__main__')._speed
    assert [speed(48, 102.5), speed(3, 1.0), speed(4800, 71.4)] == [
        '0.47 frames/s', '3 frames/s', '67 frames/s']


def test_it_says_what_is_lacking_to_be_installed(tmp_path):
    hide = ('import sys; sys.modules["pyarrow"] = sys.modules["yaml"] = None\n'
            'from flag_sim.dataset.__main__ import main; main(["r.yaml", "--output", "set"])')
    done = subprocess.run([sys.executable, '-c', hide], cwd=tmp_path, capture_output=True,
                          text=True)
    assert done.returncode == 2 and "pip install 'flag_sim[dataset]'" in done.stderr
    assert 'Traceback' not in done.stderr
