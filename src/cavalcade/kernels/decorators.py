"""The two decorators of compiled code."""

import numba

from cavalcade.kernels.cache import KernelCache, options_of
from cavalcade.kernels.linking import SubroutineDispatcher


def kernel(function=None, *, fastmath=False):
    """A function that Python calls and numba compiles, once for each machine.

    Args:
        function: What is compiled. Divisions by zero give inf or nan in it, as in numpy.
        fastmath: LLVM's liberties with floating point numbers, as `numba.njit` takes them.
    """

    def compiled(function):
        dispatcher = numba.njit(fastmath=fastmath, error_model="numpy")(function)
        if not numba.config.DISABLE_JIT:
            dispatcher._cache = KernelCache(function, options_of(dispatcher))
        return dispatcher

    return compiled if function is None else compiled(function)


def subroutine(function=None, *, fastmath=False):
    """A function that kernels call: compiled as part of each of them (`kernels.linking`).

    Args: as for `kernel`. It has no default arguments.
    """

    def compiled(function):
        if numba.config.DISABLE_JIT:
            return function
        options = {"nopython": True, "fastmath": fastmath, "error_model": "numpy"}
        return SubroutineDispatcher(function, targetoptions={**options, "boundscheck": None})

    return compiled if function is None else compiled(function)
