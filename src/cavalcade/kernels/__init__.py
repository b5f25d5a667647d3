"""How kernels are compiled: numba, with what its `njit` costs a user's first minute left out.

Code that is compiled comes as one of two:

- `kernel`: called from Python. Machine code of its own, kept on disk for the next process.
- `subroutine`: called from kernels only. It is typed and lowered once and becomes part of the
  kernels that call it; no machine code, no wrapper for Python, nothing on disk of its own.

A kernel's compiled code is found again by what it was made of: its byte code, that of everything
compiled that it calls, and the constants and record types these name. A kernel whose subroutine
changed in another file is compiled anew, one that only moved or got another comment is not.
"""

from cavalcade.kernels.decorators import kernel, subroutine

__all__ = ["kernel", "subroutine"]
