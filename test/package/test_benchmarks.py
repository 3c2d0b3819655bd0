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

"""Every benchmark runs to its end, in a form that takes seconds; its figures mean nothing here."""
import importlib
import importlib.util
import json
import os
from pathlib import Path
import subprocess
import sys

import pytest
from support.soak import SOAK
from support.study import SMALL

BENCHMARKS = Path(__file__).resolve().parents[1] / 'benchmark'
# What makes each as short as it can be; tuning is short by what the test makes small in it.
SHORT = {'animation': ['--quick'], 'cloth': ['--rounds', '1'],
         'compiling': ['--what', 'normals'], 'dataset': ['--quick'], 'drawing': ['--rounds', '1'],
         'frame_time': ['--frames', '20', '--runs', '1'], 'growth': ['--quick'],
         'looks': ['--rounds', '1'], 'pipeline': ['--quick'], 'roofline': ['--seconds', '0.02']}
LONG = {'cloth', 'dataset', 'frame_time', 'pipeline'}
"""Those that take tens of seconds in any form: they start all nodes, or compile many methods."""
PEERS = {'cloth': {'taichi': 'Taichi', 'newton': 'Newton, springs', 'mujoco': 'MuJoCo flex'},
         'drawing': {'moderngl': 'llvmpipe', 'panda3d': 'Panda3D', 'cv2': 'OpenCV'}}


def test_every_benchmark_is_tried_here():
    """Those that are no modules of the others."""
    programs = {path.stem for path in BENCHMARKS.glob('*.py') if 'def main(' in path.read_text()}
    assert programs == {*SHORT, 'tuning'}


@pytest.mark.parametrize('name', [
    pytest.param(name, marks=pytest.mark.skipif(name in LONG and not SOAK,
                                                reason='make soak runs it'))
    for name in sorted(SHORT)])
def test_a_benchmark_runs(tmp_path, name):
    """It ends, prints its table, writes its file, and names the programs that are not there."""
    out = tmp_path / 'new' / 'out.json'
    done = subprocess.run(
        [sys.executable, BENCHMARKS / f'{name}.py', *SHORT[name], '--out', out],
        capture_output=True, text=True, timeout=600.0,
        # Threads of the peers' libraries are the benchmarks' own choice.
        env={key: value for key, value in os.environ.items() if not key.endswith('_THREADS')})
    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads(out.read_text()) and f'written to {out}' in done.stdout
    for module, peer in PEERS.get(name, {}).items():
        if importlib.util.find_spec(module) is None:
            assert f'not measured: {peer}' in done.stdout


def test_the_benchmark_of_tuning_runs(tmp_path, monkeypatch, capsys):
    """For one shot and one window, on small grids."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    tuning = importlib.import_module('tuning')
    for module, name, value in (*SMALL, (tuning, 'WINDOWS', 1)):
        monkeypatch.setattr(module, name, value)
    monkeypatch.setattr(sys, 'argv', ['tuning', '--shots', 'calm', '--folder', str(tmp_path)])
    tuning.main()
    assert 'elsewhere' in capsys.readouterr().out
