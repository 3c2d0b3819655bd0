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

"""Which machine measured, and whether it had something else to do."""
import functools
import os
from pathlib import Path
import platform

from flag_sim.kernels import fingerprint
import numba
import numpy as np


@functools.lru_cache
def processor():
    """Return the processor's name."""
    try:
        lines = Path('/proc/cpuinfo').read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(':')[2].strip() for line in lines if line.startswith('model name')]
    return names[0] if names else platform.processor() or platform.machine()


def cores():
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0))


def identity():
    """Return what measurements depend on beside the settings: {word: text}."""
    return {'machine': f'{processor()}, {cores()} cores', 'code': fingerprint()[:16]}


def versions():
    """Return the versions of what the numbers were made with, in words."""
    return (f'Python {platform.python_version()}, numba {numba.__version__}, '
            f'numpy {np.__version__}, {platform.system()} {platform.release()}')


def load():
    """Return how many processes wanted a processor in the last minute, on average."""
    return os.getloadavg()[0]
