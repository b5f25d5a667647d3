"""Copies between arrays in kernels, number by number.

`out[a:b] = values` takes numba seconds to compile: its error message alone needs all of its text
functions.
"""

from cavalcade.kernels.decorators import subroutine


@subroutine
def copy_to(out, values):
    """Write `(N,)` values to the beginning of an array.

    `out` may begin where `values` does, and is at least as long.
    """
    for k in range(values.shape[0]):
        out[k] = values[k]


@subroutine
def copy_rows(out, rows):
    """Write rows `(M, K)` to the first rows of an array `(M or more, K or more)`."""
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            out[i, k] = rows[i, k]
