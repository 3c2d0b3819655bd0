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

"""
The decorators that compile every numba kernel of the package, and what each option is worth.

A kernel is a function of floats, arrays and NamedTuples of these. The figures: how much longer a
frame of the cloth is without the option (61 x 41 nodes at a pole, symplectic, one thread; median
of 60 turns with and without it, on a machine that was busy).
"""
from collections.abc import Callable
import functools

from flag_sim.jit.cache import kernel_cache, KernelCache, PartCache
from flag_sim.jit.compilers import (
    InnerCompiler, KernelCompiler, LateCompiler, LateInnerCompiler, NoAliasCompiler, WideCompiler)
import numba


def kernel(function: Callable = None, **options) -> Callable:
    """
    Compile a function of floats and arrays; its array arguments must not overlap one another.

    - error_model 'numpy': a division by zero gives inf, not an exception, so that loops stay free
      of branches and can become vectors.
    - fastmath 'contract': a * b + c may be rounded once. Without it 10 % longer. Full fastmath
      would fold isfinite() to True.
    - nogil: other threads may run meanwhile.
    - no two arguments overlap: see NoAliasCompiler.
    - no_cfunc_wrapper: no function of C's calls it, so no wrapper for one is compiled.

    `options` replace any of these. cache: False for one that is not kept on the disk.
    """
    if function is None:
        return functools.partial(kernel, **options)
    is_kept = options.pop('cache', True)
    options = {'nogil': True, 'error_model': 'numpy', 'fastmath': {'contract'},
               'no_cfunc_wrapper': True, 'pipeline_class': NoAliasCompiler, **options}
    dispatcher = numba.njit(function, **options)
    if is_kept:
        dispatcher._cache = kernel_cache(KernelCache, function)
    _call_a_part(dispatcher, is_kept, options)
    return dispatcher


def _call_a_part(dispatcher, is_kept, options):
    """
    Have other kernels call not a kernel itself but a variant that can be nothing but their part.

    That has no machine code and no wrapper for Python, which unpacks every array of every record:
    most of what compiling a small kernel takes. Few kernels are called both ways.
    """
    @functools.cache
    def part():
        variant = numba.njit(dispatcher.py_func, no_cpython_wrapper=True, **options)
        if is_kept:
            variant._cache = kernel_cache(PartCache, dispatcher.py_func)
        variant.add_overload = lambda one: variant.overloads.update({one.signature.args: one})
        return variant
    # What numba asks of a kernel that another one calls.
    dispatcher.get_call_template = lambda *arguments: part().get_call_template(*arguments)
    dispatcher.get_overload = lambda signature: part().get_overload(signature)


inner_kernel = functools.partial(kernel, pipeline_class=InnerCompiler)
"""A kernel that becomes a part of its callers: a loop with a call in it is not made vectors."""

wide_kernel = functools.partial(kernel, pipeline_class=WideCompiler, _nrt=False)
"""
A kernel whose loops run over many numbers: compiled to vectors of 512 bits.

With LLVM's own choice, 256 bits on processors that have 512: 19 % longer. Lean, as below.
"""

shared_kernel = functools.partial(kernel, pipeline_class=KernelCompiler, _nrt=False)
"""A kernel whose arrays other threads may write to while it runs; lean, as below."""

lean_kernel = functools.partial(kernel, _nrt=False)
"""
A kernel that makes no array, and so counts no references to its arguments.

Each array of each record is counted, in each call. With the counting, a step of symplectic with
31 x 21 nodes takes 7 % longer, one of rk4 14 %; and in all kernels of the pole's collision 42 %.
The option is private to numba; a kernel that made an array with it would not compile.
"""

lean_inner_kernel = functools.partial(inner_kernel, _nrt=False)
"""A lean kernel that becomes a part of its callers."""

late_kernel = functools.partial(kernel, pipeline_class=LateCompiler, _nrt=False)
"""
A lean kernel that is optimised for its callers only as a part of them.

For kernels that call others, which call others: those of drawing, six levels, compile in 0.7 of
the time, and a picture takes 0.83 of the time with 241 x 161 nodes, 0.93 with 61 x 41 (1280x720,
one thread; medians of 40 turns, on a machine that was busy), with the same bytes. A motion would
not be the same to the byte.
"""

late_inner_kernel = functools.partial(kernel, pipeline_class=LateInnerCompiler, _nrt=False)
"""A late kernel that becomes a part of its callers."""
