"""Cholesky factors of matrices over feet, compiled: rows and columns come in threes.

Columns are counted unsigned in the inner loops: only then does the compiler know that no index
means "from the end", and turns the loop into vector instructions.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def factorise(matrix, factor, scale):
    """Upper triangular R with Rᵀ R = matrix, three rows at a time.

    Args:
        matrix: `(n, n)` symmetric positive definite, n a multiple of 3; its upper triangle is read.
        factor: `(n, n)` whose upper triangle becomes R.
        scale: `(n,)`, becomes one over the diagonal of R.
    """
    n = matrix.shape[0]
    end = np.uint64(n)
    for r in range(n):
        for c in range(np.uint64(r), end):
            factor[r, c] = matrix[r, c]
    for p in range(0, n, 3):
        pivot = 1.0 / math.sqrt(factor[p, p])
        scale[p] = pivot
        for c in range(np.uint64(p), end):
            factor[p, c] *= pivot
        a = factor[p, p + 1]
        pivot = 1.0 / math.sqrt(factor[p + 1, p + 1] - a * a)
        scale[p + 1] = pivot
        for c in range(np.uint64(p + 1), end):
            factor[p + 1, c] = pivot * (factor[p + 1, c] - a * factor[p, c])
        a, b = factor[p, p + 2], factor[p + 1, p + 2]
        pivot = 1.0 / math.sqrt(factor[p + 2, p + 2] - a * a - b * b)
        scale[p + 2] = pivot
        for c in range(np.uint64(p + 2), end):
            factor[p + 2, c] = pivot * (factor[p + 2, c] - a * factor[p, c] - b * factor[p + 1, c])
        for r in range(p + 3, n, 3):
            a0, b0, c0 = factor[p, r], factor[p + 1, r], factor[p + 2, r]
            a1, b1, c1 = factor[p, r + 1], factor[p + 1, r + 1], factor[p + 2, r + 1]
            a2, b2, c2 = factor[p, r + 2], factor[p + 1, r + 2], factor[p + 2, r + 2]
            for c in range(np.uint64(r), end):
                x, y, z = factor[p, c], factor[p + 1, c], factor[p + 2, c]
                factor[r, c] -= a0 * x + b0 * y + c0 * z
                factor[r + 1, c] -= a1 * x + b1 * y + c1 * z
                factor[r + 2, c] -= a2 * x + b2 * y + c2 * z


@njit(cache=True, fastmath={"contract", "reassoc"})
def forward(factor, scale, vector, first):
    """Turn `vector` into R⁻ᵀ vector; it is zero before `first`, a multiple of 3."""
    n = factor.shape[0]
    end = np.uint64(n)
    for p in range(first, n, 3):
        x = scale[p] * vector[p]
        y = scale[p + 1] * (vector[p + 1] - factor[p, p + 1] * x)
        z = scale[p + 2] * (vector[p + 2] - factor[p, p + 2] * x - factor[p + 1, p + 2] * y)
        vector[p], vector[p + 1], vector[p + 2] = x, y, z
        for c in range(np.uint64(p + 3), end):
            vector[c] -= x * factor[p, c] + y * factor[p + 1, c] + z * factor[p + 2, c]


@njit(cache=True, fastmath={"contract", "reassoc"})
def backward(factor, scale, vector):
    """Turn `vector` into R⁻¹ vector."""
    n = factor.shape[0]
    end = np.uint64(n)
    for p in range(n - 3, -1, -3):
        x, y, z = 0.0, 0.0, 0.0
        for c in range(np.uint64(p + 3), end):
            x += factor[p, c] * vector[c]
            y += factor[p + 1, c] * vector[c]
            z += factor[p + 2, c] * vector[c]
        z = scale[p + 2] * (vector[p + 2] - z)
        y = scale[p + 1] * (vector[p + 1] - y - factor[p + 1, p + 2] * z)
        x = scale[p] * (vector[p] - x - factor[p, p + 1] * y - factor[p, p + 2] * z)
        vector[p], vector[p + 1], vector[p + 2] = x, y, z
