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

"""Kernels that many tests use, compiled before several workers would each compile them."""
from pathlib import Path
import subprocess
import sys

MOVE = """
from flag_sim.cloth import Cloth
from flag_sim.cloth.solvers import SOLVERS
for solver in SOLVERS:
    cloth = Cloth(5, 7, solver=solver, precision='{precision}', pole=(0.0, 0.0, 0.05))
    cloth.advance(0.01, (5.0, 2.0, 0.5))
"""

DRAW = """
from flag_sim.drawing import Camera, Picture, Style
import numpy as np
flag = np.random.default_rng(1).normal(size=(5, 7, 3))
for style in Style(samples=4), Style(outline=True):
    Picture().draw(flag, camera=Camera(64, 48), style=style, channels=['depth'])
"""

DATASET = f"""
import sys
sys.path.insert(0, {str(Path(__file__).resolve().parents[1])!r})
from flag_sim.dataset.channels import CHANNELS
from flag_sim.dataset.engine import warm_up
from support.recipes import recipe
warm_up(recipe(channels=CHANNELS))
"""


def compile_kernels():
    """
    Compile every solver in both precisions, drawing and datasets, in two processes side by side.

    Datasets need some of the kernels of both others and come after them, so that nothing is
    compiled twice. What is kept already is only loaded. A kernel that does not compile fails the
    tests that use it, not this.
    """
    programs = [MOVE.format(precision='float64') + DATASET,
                DRAW + MOVE.format(precision='float32')]
    processes = [subprocess.Popen([sys.executable, '-c', program],
                                  stderr=subprocess.DEVNULL)
                 for program in programs]
    for process in processes:
        process.wait()
