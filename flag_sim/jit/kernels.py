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

"""How every numba kernel of the package is compiled and kept: the options and their reasons."""
import functools
import hashlib
import os
from pathlib import Path
import tempfile

from llvmlite.binding import Linkage, parse_bitcode
import numba
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

PACKAGE = Path(__file__).resolve().parents[1]
WITHOUT_KERNELS = ('animation', 'declarations', 'nodes', 'parameters', 'protocol', 'ros', 'study',
                   'tools')
"""The folders that hold no kernel: to change them compiles nothing anew."""


class _Library(JITCodeLibrary):
    """
    A kernel's machine code and a copy of all that it calls, which nobody else runs.

    numba leaves the copies open to the whole process, which then runs, for all callers, the one
    that it happened to load first. But what a kernel is optimised to depends on its caller, down
    to which sums of products are rounded once: a run that compiles and the next one would differ,
    or two runs that used other solvers before. The methods are private to numba; a test looks at
    the machine code's symbols.
    """

    def _optimize_final_module(self):
        for function in self._final_module.functions:
            if function.linkage == Linkage.linkonce_odr and not function.is_declaration:
                function.linkage = Linkage.internal
        super()._optimize_final_module()

    def _get_module_for_linking(self):
        """Return what callers copy: as it would be read from the disk, so that it is the same."""
        if self._shared_module is None:
            module = super()._get_module_for_linking()
            self._shared_module = parse_bitcode(module.as_bitcode())
        return self._shared_module


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):
    _name = 'kernel_lowering'

    def run_pass(self, state):
        state.library = _Library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()  # as numba does with its own
        return super().run_pass(state)


class KernelCompiler(Compiler):
    """Compiles a kernel into a library of its own."""

    lowering = _Lowering

    def define_pipelines(self):
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [(self.lowering if step is NativeLowering else step, description)
                               for step, description in pipeline.passes]
        return pipelines


class _NoAliasCompiler(KernelCompiler):
    """
    Lets LLVM assume that no two array arguments overlap.

    Without it LLVM guards or gives up vectorising loops that read six arrays and write three.
    The flag is private to numba; a test looks for the vector instructions that it buys.
    """

    def __init__(self, typingctx, targetctx, library, args, return_type, flags, *others):
        flags.noalias = True
        super().__init__(typingctx, targetctx, library, args, return_type, flags, *others)


class _InnerLower(Lower):
    """
    Asks LLVM to make the kernel a part of its callers.

    numba's own option, forceinline, would go on to whatever happens to be compiled meanwhile.
    """

    def post_lower(self):
        super().post_lower()
        self.function.attributes.add('alwaysinline')


@register_pass(mutates_CFG=True, analysis_only=False)
class _InnerLowering(_Lowering):
    _name = 'inner_lowering'
    lowering_class = _InnerLower


class _InnerCompiler(_NoAliasCompiler):
    lowering = _InnerLowering


class _WideLower(Lower):
    """
    Asks LLVM for vectors of 512 bits.

    Even where the processor has them, LLVM takes 256 by default, for the sake of programs that use
    few vectors and would only slow the clock down. A caller that is no such kernel would lose
    that, and what is known of the arguments: so it must call the loop, not take it in.
    """

    def post_lower(self):
        super().post_lower()
        self.function.attributes.add('noinline')
        # Past llvmlite's own add, which knows no attributes of a target.
        set.add(self.function.attributes, '"prefer-vector-width"="512"')


@register_pass(mutates_CFG=True, analysis_only=False)
class _WideLowering(_Lowering):
    _name = 'wide_lowering'
    lowering_class = _WideLower


class _WideCompiler(_NoAliasCompiler):
    lowering = _WideLowering


@functools.lru_cache
def fingerprint():
    """Return a hash of every module that can hold a kernel."""
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob('*.py')):
        if path.relative_to(PACKAGE).parts[0] not in WITHOUT_KERNELS:
            digest.update(path.read_bytes())
    return digest.hexdigest()


class _Locator:
    """
    Says where a kernel's machine code is kept and when it is out of date.

    numba's own locators compare only the file that holds the kernel, and would go on running the
    old code of another kernel that it calls. And they give up where neither the package nor the
    home can be written. The interface is numba's.
    """

    def __init__(self, function, folder):
        self._function = function
        self._folder = folder

    def get_cache_path(self):
        return str(self._folder)

    def ensure_cache_path(self):
        self._folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=self._folder).close()  # raises OSError if it may not be written

    def get_source_stamp(self):
        return fingerprint()

    def get_disambiguator(self):
        return str(self._function.__code__.co_firstlineno)

    @classmethod
    def from_function(cls, function, path):
        """Return a locator with the first folder that can be written, or None."""
        path = Path(path).resolve()
        name = '-'.join(['flag_sim', *path.relative_to(PACKAGE).parent.parts])
        folders = [path.parent / '__pycache__', Path('~/.cache').expanduser() / name,
                   Path(tempfile.gettempdir()) / f'{name}-{os.getuid()}']
        if numba.config.CACHE_DIR:
            folders.insert(0, Path(numba.config.CACHE_DIR) / name)
        for folder in folders:
            locator = cls(function, folder)
            try:
                locator.ensure_cache_path()
            except OSError:
                continue
            return locator
        return None


class _CacheImpl(FunctionCache._impl_class):
    _locator_classes = [_Locator]


_missed = []  # kernels that no cache held: each was compiled by this process


def compilations():
    """Return how many kernels this process has begun to compile; the others it only loaded."""
    return len(_missed)


class _Cache(FunctionCache):
    _impl_class = _CacheImpl

    def __init__(self, function):
        super().__init__(function)
        # numba does not read what another version kept. What other sources kept must not be read
        # either: it may name classes that are gone.
        self._cache_file._version += fingerprint()

    def load_overload(self, sig, target_context):
        found = super().load_overload(sig, target_context)
        if found is None:
            _missed.append(self._py_func.__qualname__)
        return found


def kernel(function=None, **options):
    """
    Compile a function of floats and arrays; its array arguments must not overlap one another.

    error_model 'numpy': a division by zero gives inf, not an exception, so that loops stay free of
    branches. 'contract' only permits a * b + c in one rounding; full fastmath would fold
    isfinite() to True. nogil lets two threads share the work. `options` replace any of these.
    """
    if function is None:
        return functools.partial(kernel, **options)
    is_kept = options.pop('cache', True)
    options = {'nogil': True, 'error_model': 'numpy', 'fastmath': {'contract'},
               'pipeline_class': _NoAliasCompiler, **options}
    dispatcher = numba.njit(function, **options)
    if is_kept:
        dispatcher._cache = _Cache(function)
    return dispatcher


inner_kernel = functools.partial(kernel, pipeline_class=_InnerCompiler)
"""A kernel that becomes a part of each that calls it: of a loop that is only then vectors."""

wide_kernel = functools.partial(kernel, pipeline_class=_WideCompiler)
"""A kernel whose loops run over many numbers: compiled to the widest vectors."""

shared_kernel = functools.partial(kernel, pipeline_class=KernelCompiler)
"""A kernel whose arrays other threads may write to while it runs."""

lean_kernel = functools.partial(kernel, _nrt=False)
"""
A kernel of many small calls that makes no array, and so counts no references to those it is given.

Counting was most of the time of the pole's collision. The option is private to numba; a kernel
that made an array with it would not compile.
"""

lean_inner_kernel = functools.partial(inner_kernel, _nrt=False)
"""A lean kernel that becomes a part of each that calls it."""
