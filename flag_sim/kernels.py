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

"""How every numba kernel of the package is compiled: one place for the options and their reasons."""
import functools
import os
import tempfile

import numba
from numba.core.compiler import Compiler


class _NoAliasCompiler(Compiler):
    """
    Lets LLVM assume that no two array arguments overlap.

    Without it LLVM guards or gives up vectorising loops that read six arrays and write three.
    The flag is private to numba; a test looks for the vector instructions that it buys.
    """

    def __init__(self, typingctx, targetctx, library, args, return_type, flags, locals):
        flags.noalias = True
        super().__init__(typingctx, targetctx, library, args, return_type, flags, locals)


def _ensure_cache():
    """Point numba at a temporary cache where neither the package nor the home can be written."""
    if numba.config.CACHE_DIR:
        return
    here = os.path.dirname(os.path.abspath(__file__))
    home = os.path.expanduser('~')
    if not (os.access(here, os.W_OK) or os.access(home, os.W_OK)):
        user = os.getuid() if hasattr(os, 'getuid') else 'user'
        numba.config.CACHE_DIR = os.path.join(tempfile.gettempdir(), f'flag_sim-kernels-{user}')


_ensure_cache()

# error_model='numpy': a division by zero gives inf, not an exception, so that loops stay free of
# branches. 'contract' only permits a * b + c in one rounding; full fastmath would fold isfinite()
# to True. nogil lets two threads share the work. The cache makes the second start fast.
kernel = functools.partial(
    numba.njit, cache=True, nogil=True, error_model='numpy', fastmath={'contract'},
    pipeline_class=_NoAliasCompiler)
"""Compile a function of floats and arrays; its array arguments must not overlap one another."""
