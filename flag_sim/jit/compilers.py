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
What numba is told beyond its public options: the classes that compile a kernel.

They exist for what numba's options cannot say: that arrays do not overlap, how wide vectors are,
that what only other kernels call needs no machine code and may be optimised with these alone, how
compiling is made quicker (see inference), and that a kernel's machine code is its own. The last is
for the sake of 'contract', which lets LLVM round a * b + c once wherever it can, and that depends
on what the kernel was inlined into.

An explicit fused multiply-add, llvm.fma by numba's `intrinsic`, with 'contract' off, would not
depend on it, and was tried: every a * b + c of an expression rewritten so, left product first. It
is as fast (a frame of the cloth 1.00 times as long, quartiles 0.99 and 1.02; with neither, 1.10:
61 x 41 nodes, symplectic, 60 turns on a busy machine). symplectic, verlet, euler and seed moved to
the same byte as by 'contract', but not rk4, xpbd and implicit, and none of them at the pole. As
the bytes of a motion are to stay, so do these classes.
"""
from flag_sim.jit.inference import few_collections, remembered_calls
from llvmlite.binding import Linkage, parse_bitcode
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering, NopythonTypeInference


class _Library(JITCodeLibrary):
    """
    A kernel's machine code with its own copies of the kernels that it calls.

    numba makes these copies weak symbols (linkonce_odr), of which a process keeps the first that
    it loads, for all callers. But what a copy is optimised to depends on its caller, down to
    which sums of products are rounded once: a run that compiles and the next one would differ, or
    two runs that used other solvers before. So the copies become internal symbols. The methods
    are private to numba; a test looks at the machine code's symbols.
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


class PartLibrary(_Library):
    """
    A kernel as a part of those that call it: optimised for them to copy, but no machine code.

    Its callers' machine code holds all that is ever run of it.
    """

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def serialize_using_object_code(self):
        """Return what is kept on the disk: the part that callers copy."""
        return self.name, 'part', self._get_module_for_linking().as_bitcode()

    @classmethod
    def kept(cls, codegen, serialized) -> 'PartLibrary':
        """Return what was kept on the disk."""
        name, _, bitcode = serialized
        library = cls(codegen, name)
        library.enable_object_caching()
        library._shared_module = parse_bitcode(bitcode)
        library._finalized = True
        return library


class _LatePartLibrary(PartLibrary):
    """
    A part that LLVM optimises only within what calls it.

    Else all that a kernel calls, and what that calls, is optimised once for each level.
    """

    def _optimize_final_module(self):
        pass


@register_pass(mutates_CFG=True, analysis_only=False)
class _TypeInference(NopythonTypeInference):
    """Finds the types of a kernel; what a call returns is looked up once."""

    _name = 'kernel_type_inference'

    def run_pass(self, state):
        with remembered_calls(state.typingctx):
            return super().run_pass(state)


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):
    """Puts a kernel into a library of its own; one that Python cannot call becomes a part."""

    _name = 'kernel_lowering'
    part_library = PartLibrary

    def run_pass(self, state):
        is_part = state.flags.no_cpython_wrapper
        kind = self.part_library if is_part else _Library
        state.library = kind(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()  # as numba does with its own
        state.flags.no_compile = is_part
        super().run_pass(state)
        if is_part:
            state.cr = state.cr._replace(cfunc=object())  # callers find it by that, as by a cfunc
            state.targetctx.insert_user_function(state.cr.cfunc, state.cr.fndesc, [state.library])
        return True


class KernelCompiler(Compiler):
    """Compiles a kernel into a library of its own."""

    lowering = _Lowering

    def define_pipelines(self):
        own = {NativeLowering: self.lowering, NopythonTypeInference: _TypeInference}
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [(own.get(step, step), description)
                               for step, description in pipeline.passes]
        return pipelines

    def compile_extra(self, func):
        with few_collections():
            return super().compile_extra(func)


class NoAliasCompiler(KernelCompiler):
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
    """Lowers a kernel by _InnerLower."""

    _name = 'inner_lowering'
    lowering_class = _InnerLower


class InnerCompiler(NoAliasCompiler):
    """Compiles a kernel that becomes a part of its callers."""

    lowering = _InnerLowering


@register_pass(mutates_CFG=True, analysis_only=False)
class _LateLowering(_Lowering):
    """Lowers a kernel whose part is optimised only within its callers."""

    _name = 'late_lowering'
    part_library = _LatePartLibrary


class LateCompiler(NoAliasCompiler):
    """Compiles a kernel that is optimised only within those that call it."""

    lowering = _LateLowering


@register_pass(mutates_CFG=True, analysis_only=False)
class _LateInnerLowering(_LateLowering):
    """Lowers a kernel by _InnerLower whose part is optimised only within its callers."""

    _name = 'late_inner_lowering'
    lowering_class = _InnerLower


class LateInnerCompiler(NoAliasCompiler):
    """Compiles a kernel that becomes a part of its callers and is optimised only there."""

    lowering = _LateInnerLowering


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
    """Lowers a kernel by _WideLower."""

    _name = 'wide_lowering'
    lowering_class = _WideLower


class WideCompiler(NoAliasCompiler):
    """Compiles a kernel to vectors of 512 bits."""

    lowering = _WideLowering
