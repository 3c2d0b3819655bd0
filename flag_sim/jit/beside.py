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

"""Compiling in another process: kernels that are kept on the disk need only be loaded then."""
import os
import subprocess
import sys

NICENESS = 10
"""How much the process gives way to others: what goes on meanwhile has a rate to keep."""


class CompilingProcess:
    """
    A process that runs a program in Python, which compiles kernels and so keeps them.

    numba compiles under one lock and holds Python's: in a thread it would stop all others.
    """

    def __init__(self, program: str):
        self._process = subprocess.Popen(
            [sys.executable, '-c', f'import os; os.nice({NICENESS}); {program}'],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, 'PYTHONPATH': os.pathsep.join(path for path in sys.path if path)})

    @property
    def is_over(self) -> bool:
        """Return whether the program has ended, however it did."""
        return self._process.poll() is not None

    def end(self) -> None:
        """End the program."""
        self._process.kill()
        self._process.wait()
