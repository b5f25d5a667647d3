"""The two decorators of compiled code."""

import numba

from cavalcade.kernels.linking import (
    KernelDispatcher,
    SubroutineDispatcher,
    ThreadedKernelDispatcher,
)


def kernel(function=None, *, fastmath=False, nogil=False):
    """A function that Python calls and numba compiles, once for each machine.

    Args:
        function: What is compiled. Divisions by zero give inf or nan in it, as in numpy.
        fastmath: LLVM's liberties with floating point numbers, as `numba.njit` takes them.
        nogil: Whether other threads may run meanwhile. For kernels that take longer than a
            millisecond: to get the interpreter back may take as long as a control cycle, which
            hundreds of short calls must not risk.
    """
    return _compiled(ThreadedKernelDispatcher if nogil else KernelDispatcher, function, fastmath)


def subroutine(function=None, *, fastmath=False):
    """A function that kernels call: compiled as part of each of them (`kernels.linking`).

    Args: as for `kernel`. It has no default arguments.
    """
    return _compiled(SubroutineDispatcher, function, fastmath)


def _compiled(dispatcher, function, fastmath):
    options = {
        "nopython": True, "boundscheck": None, "error_model": "numpy", "fastmath": fastmath
    }  # fmt: skip

    def decorated(function):
        if numba.config.DISABLE_JIT:
            return function
        return dispatcher(function, targetoptions=options)

    return decorated if function is None else decorated(function)
