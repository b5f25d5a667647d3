"""Limits that are held, compiled: an orthonormal basis of their rows, kept as they come and go.

With H = Rᵀ R, the rows aₖ of held limits become vectors R⁻ᵀ aₖ. They are kept as Q T, the columns
of Q orthonormal and T upper triangular, which stays exact over any number of changes.

    basis: `(., n)`, row i is column i of Q
    triangle: `(., .)`, row k is column k of T: R⁻ᵀ aₖ in terms of the basis
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True, fastmath={"contract", "reassoc"})
def split(basis, held, vector, shares, more):
    """Take from `vector` what lies along the basis, which becomes `shares`; `more` is overwritten.

    Returns:
        The square of what is left.
    """
    end = np.uint64(vector.shape[0])
    for k in range(held):
        shares[k] = 0.0
    # Twice is enough (Parlett, "The symmetric eigenvalue problem", 1980, section 6.9); once would
    # multiply what the basis lacks in being orthonormal with every vector.
    for _ in range(2):
        for k in range(held):
            share = 0.0
            for c in range(end):
                share += basis[k, c] * vector[c]
            more[k] = share
            shares[k] += share
        odd = held % 2
        if odd == 1:
            for c in range(end):
                vector[c] -= more[0] * basis[0, c]
        for k in range(odd, held, 2):
            a, b = more[k], more[k + 1]
            for c in range(end):
                vector[c] -= a * basis[k, c] + b * basis[k + 1, c]
    left = 0.0
    for c in range(end):
        left += vector[c] * vector[c]
    return left


@njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def combine(triangle, held, shares, answer):
    """`answer = T⁻¹ shares`: the combination of held limits that has these shares."""
    for k in range(held):
        answer[k] = shares[k]
    for k in range(held - 1, -1, -1):
        value = answer[k] / triangle[k, k]
        answer[k] = value
        for c in range(np.uint64(k)):
            answer[c] -= value * triangle[k, c]


@njit(cache=True, error_model="numpy")
def hold(basis, triangle, held, vector, shares, left):
    """Add a limit whose vector has these shares and, beside them, `vector` of square `left`."""
    length = math.sqrt(left)
    for c in range(vector.shape[0]):
        basis[held, c] = vector[c] / length
    for k in range(held):
        triangle[held, k] = shares[k]
    triangle[held, held] = length


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def release(basis, triangle, held, place):
    """Take out a limit; those after it move up by one."""
    end = np.uint64(basis.shape[1])
    for k in range(place, held - 1):
        for c in range(k + 2):
            triangle[k, c] = triangle[k + 1, c]
    for i in range(place, held - 1):
        length = math.hypot(triangle[i, i], triangle[i, i + 1])
        cosine, sine = triangle[i, i] / length, triangle[i, i + 1] / length
        for k in range(i, held - 1):
            a, b = triangle[k, i], triangle[k, i + 1]
            triangle[k, i] = cosine * a + sine * b
            triangle[k, i + 1] = cosine * b - sine * a
        for c in range(end):
            a, b = basis[i, c], basis[i + 1, c]
            basis[i, c] = cosine * a + sine * b
            basis[i + 1, c] = cosine * b - sine * a
