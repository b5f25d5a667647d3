"""Compiled functions that exist only as part of what calls them.

`numba.njit` optimises every function it compiles down to machine code, with a wrapper for calls
from Python, and then once more as part of each caller. For functions that only compiled code
calls, half of that work is thrown away. Here it is left out, by numba's own extension points: a
library of code without machine code, a compiler class with one more pass, and a dispatcher.
"""

import contextlib
import functools
import gc

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import LoweringPass, register_pass
from numba.core.registry import CPUDispatcher
from numba.core.target_extension import cpu_target, jit_registry
from numba.core.typed_passes import NativeLowering

from cavalcade.kernels.cache import KernelCache, options_of


class _LinkedLibrary(JITCodeLibrary):
    """Code for others to link: with what it calls, not optimised before it is part of a kernel."""

    def finalize(self):
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        self._finalized = True


@register_pass(mutates_CFG=False, analysis_only=False)
class _NameForCallers(LoweringPass):
    """Gives the lowered code a key by which callers find it, where machine code has an address."""

    _name = "cavalcade_name_for_callers"

    def __init__(self):
        LoweringPass.__init__(self)

    def run_pass(self, state):
        lowered = state["cr"]
        key = object()
        state.targetctx.insert_user_function(key, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=key)
        return True


class _Flags(Flags):
    """numba's flags, compared as numba does, without asking for each option.

    numba looks its parts of numpy up by the flags of what is compiled, hundreds of times per
    kernel; all flags have one hash there, that of the options' names.
    """

    __slots__ = ()
    _hash = hash(Flags())
    _defaults = {name: option.default for name, option in Flags.options.items()}  # noqa: RUF012

    def __hash__(self):
        return self._hash

    def __eq__(self, other):
        if type(other) is _Flags and self._values == other._values:
            return True
        return super().__eq__(other)

    def values(self):
        """All options, also those that were not set."""
        return {**self._defaults, **self._values}


class _KernelCompiler(CompilerBase):
    """The usual pipeline without what only C would call.

    Flags are set where the pipelines are defined, and not before: numba shares its compiled parts
    of numpy among functions of the same flags, of which it has taken its copy by then.
    """

    def __init__(self, typingctx, targetctx, library, args, return_type, flags, locals):
        flags = _Flags(flags)
        super().__init__(typingctx, targetctx, library, args, return_type, flags, locals)

    def define_pipelines(self):
        self.state.flags.no_cfunc_wrapper = True
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        return [passes]


class _ThreadedKernelCompiler(_KernelCompiler):
    """The same with a wrapper that lets other threads run. Subroutines are the same for both."""

    def define_pipelines(self):
        self.state.flags.release_gil = True
        return super().define_pipelines()


class _SubroutineCompiler(_KernelCompiler):
    """The same without machine code: the pipeline ends with lowered code."""

    def define_pipelines(self):
        state = self.state
        state.flags.no_compile = state.flags.no_cpython_wrapper = True
        state.library = _LinkedLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        [passes] = super().define_pipelines()
        passes.add_pass_after(_NameForCallers, NativeLowering)
        passes.finalize()
        return [passes]


class _Linking(CPUDispatcher):
    """Compiles numba's own implementations of numpy as subroutines, too, where it meets them."""

    def compile(self, sig):
        """The compiled function for a signature."""
        with global_compiler_lock, _rarely_collected():
            usual = jit_registry[cpu_target]
            dict.__setitem__(jit_registry, cpu_target, _as_subroutine)
            try:
                return super().compile(sig)
            finally:
                dict.__setitem__(jit_registry, cpu_target, usual)


@contextlib.contextmanager
def _rarely_collected():
    """Python looks for garbage less often: compilers make millions of objects, and few cycles."""
    before = gc.get_threshold()
    gc.set_threshold(max(before[0], 50_000) if before[0] else 0, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _as_subroutine(**options):
    """What stands for `numba.jit` where numba compiles a function for a caller."""
    return functools.partial(
        SubroutineDispatcher, targetoptions={**options, "nopython": True, "boundscheck": None}
    )


class KernelDispatcher(_Linking):
    """A compiled function that Python calls."""

    _compiler = _KernelCompiler
    _kept_as = ""

    def __init__(self, py_func, locals=None, targetoptions=None):
        super().__init__(py_func, locals, targetoptions, pipeline_class=self._compiler)
        self._cache = KernelCache(py_func, options_of(self) + self._kept_as)


class ThreadedKernelDispatcher(KernelDispatcher):
    """One during which other threads run."""

    _compiler = _ThreadedKernelCompiler
    _kept_as = " nogil"


class SubroutineDispatcher(_Linking):
    """A compiled function for kernels; a call from Python, as tests do, goes through a kernel."""

    def __init__(self, py_func, locals=None, targetoptions=None):
        super().__init__(py_func, locals, targetoptions, pipeline_class=_SubroutineCompiler)

    def add_overload(self, cres):
        """Keep it for callers; there is no machine code that Python could call."""
        self.overloads[tuple(cres.signature.args)] = cres

    def _compile_for_args(self, *args, **kws):
        return self._from_python

    @functools.cached_property
    def _from_python(self):
        subroutine = self

        def call(*args):
            return subroutine(*args)

        around = numba.njit(call)
        around._cache = KernelCache(self.py_func, options_of(self))
        return around
