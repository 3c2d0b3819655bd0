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

"""Where machine code is kept: in folders that are ours alone, and apart for other types."""
import contextlib
import os
import pickle
import stat
import subprocess
import sys

from flag_sim.jit.cache import make_private
import pytest
from support.kernel_copy import use


def test_code_is_kept_where_neither_package_nor_home_can_be_written(copy, tmp_path):
    """Then a folder of this user's among the temporary ones is used."""
    places = blocked(copy, tmp_path)
    first, hits = use(copy, **places)
    assert hits == 0
    assert list((tmp_path / 'temporary').rglob('*.nbi'))
    assert use(copy, **places) == (first, 1)


def blocked(copy, tmp_path):
    """Return the environment in which only the folder for temporary files can be written."""
    (copy / 'flag_sim' / '__pycache__').write_text('in the way of a folder')
    (tmp_path / 'temporary').mkdir()
    return {'HOME': '/proc/nowhere', 'TMPDIR': str(tmp_path / 'temporary')}


def planted(name, real):
    """Let what a stranger has planted be read, were it read: it leaves a file behind."""
    class Planted:

        def __reduce__(self):
            return os.system, (f'touch {real}',)
    return pickle.dumps(name) + pickle.dumps(Planted())


def test_code_in_a_folder_that_is_not_ours_alone_is_never_read(copy, tmp_path):
    """It is a pickle, which may run any command: without a safe folder nothing is kept."""
    places = blocked(copy, tmp_path)
    result, _ = use(copy, **places)
    folders = list((tmp_path / 'temporary').iterdir())
    assert folders and all(stat.S_IMODE(folder.stat().st_mode) == 0o700 for folder in folders)
    for folder in folders:
        for index in folder.glob('*.nbi'):
            version = pickle.loads(index.read_bytes())
            index.write_bytes(planted(version, tmp_path / 'ran'))
        folder.chmod(0o777)
    before = sorted(tmp_path.rglob('*.nb?'))
    assert use(copy, **places) == (result, 0)
    assert not (tmp_path / 'ran').exists()
    assert sorted(tmp_path.rglob('*.nb?')) == before


@pytest.mark.parametrize('kind', ['open', 'readable', 'link', 'file', 'parent', 'ours'])
def test_which_folders_are_ours_alone(tmp_path, kind):
    """Neither others' rights nor a link, nor a folder above in which others can change names."""
    folder = tmp_path / 'within' / 'folder'
    make_private(folder)
    assert all(stat.S_IMODE(made.stat().st_mode) == 0o700 for made in (folder, folder.parent))
    if kind in ('link', 'file'):
        folder.rename(tmp_path / 'other')
        if kind == 'link':
            folder.symlink_to(tmp_path / 'other')
        else:
            folder.touch(mode=0o700)
    elif kind == 'parent':  # as it is without the sticky bit
        folder.parent.chmod(0o777)
    elif kind != 'ours':
        folder.chmod(0o777 if kind == 'open' else 0o750)
    with (contextlib.nullcontext() if kind == 'ours' else
          pytest.raises(PermissionError, match='of this user alone|in the place of')):
        make_private(folder)


def test_a_folder_in_the_home_is_ours_alone(copy, tmp_path):
    """It is made so, whatever the umask; and used again."""
    places = {**blocked(copy, tmp_path), 'HOME': str(tmp_path / 'home')}
    (tmp_path / 'home').mkdir()
    first, hits = use(copy, **places)
    assert hits == 0
    assert {stat.S_IMODE(folder.stat().st_mode)
            for folder in (tmp_path / 'home' / '.cache').iterdir()} == {0o700}
    assert use(copy, **places) == (first, 1)
    assert not list((tmp_path / 'temporary').iterdir())


TWO_AT_ONCE = """
from flag_sim.jit.cache import KernelCache
from flag_sim import thirds
first, second = (KernelCache(thirds.third.py_func)._cache_file for _ in range(2))
# Both look into the index before either has written to it, and the first is slow to write.
first._load_index = second._load_index = lambda: {}
first._save_data = lambda name, code: late.append((name, code))
late = []
first.save('float64', 'code for float64')
second.save('float32', 'code for float32')
del first._load_index, second._load_index, first._save_data
first._save_data(*late[0])
print(second.load('float32'), first.load('float64'))
"""


def test_processes_that_compile_at_once_never_load_the_code_of_other_types(copy):
    """What one overwrites in the index, the other compiles again."""
    done = subprocess.run([sys.executable, '-c', TWO_AT_ONCE], cwd=copy, check=True, text=True,
                          capture_output=True, env={**os.environ, 'PYTHONPATH': str(copy)})
    assert done.stdout.strip() == 'code for float32 None'
