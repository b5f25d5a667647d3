"""Subroutines do what plain compiled functions do, within kernels and when Python calls them."""

from __future__ import annotations

import gc
import math
import sys
import tracemalloc

import numpy as np
import pytest
from numba.core.compiler import Flags
from numba.core.errors import TypingError

from cavalcade.kernels import kernel, subroutine
from cavalcade.kernels.copying import copy_rows, copy_to
from cavalcade.kernels.linking import _Flags


@subroutine
def collatz(n):
    """Steps to 1; loops, branches and integers."""
    steps = 0
    while n != 1:
        n = n // 2 if n % 2 == 0 else 3 * n + 1
        steps += 1
    return steps


@subroutine
def split(x):
    """Calls another one, makes an array and gives several values."""
    parts = np.empty(2)
    parts[0], parts[1] = math.floor(x), x - math.floor(x)
    return parts, collatz(int(x))


@subroutine
def refused(n):
    if n < 0:
        raise ValueError("below zero")
    return n


@kernel
def longest(most):
    best = 0
    for n in range(1, most):
        best = max(best, collatz(n))
    return best


@kernel
def pieces(x):
    parts, steps = split(x)
    return parts[0] + 10.0 * parts[1] + steps


@kernel
def checked(n):
    return refused(n)


def test_within_kernels() -> None:
    assert longest(1000) == max(collatz.py_func(n) for n in range(1, 1000)) == 178
    assert pieces(27.5) == 27.0 + 5.0 + 111


def test_from_python() -> None:
    assert collatz(27) == 111
    parts, steps = split(6.25)
    assert parts.tolist() == [6.0, 0.25]
    assert steps == 8


def test_errors_pass_through() -> None:
    assert checked(3) == 3
    with pytest.raises(ValueError, match="below zero"):
        checked(-3)


def test_they_have_no_machine_code_of_their_own() -> None:
    assert longest.stats.cache_path
    assert not collatz.stats.cache_path


@subroutine
def total(values):
    added = 0.0
    for k in range(values.shape[0]):
        added += values[k]
    return added


@kernel
def borrowed(values):
    """Makes no array: what it is called with is the caller's."""
    return total(values) + total(values[1:])


@kernel
def doubled(values):
    """Makes one, and hands on what it is given."""
    half = values[: values.shape[0] // 2]
    return values, half, np.concatenate((half, half))


@pytest.mark.parametrize("function", [borrowed, doubled])
def test_references_to_arrays_are_counted_rightly(function) -> None:
    values = np.arange(10.0)
    assert borrowed(values) == 90.0
    before = sys.getrefcount(values)
    tracemalloc.start()
    for _ in range(2000):
        function(values)
    grown, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert sys.getrefcount(values) == before
    assert grown < 100_000
    same, half, twice = doubled(values)
    del values
    assert same.tolist() == list(range(10))
    assert half.tolist() * 2 == twice.tolist()


def test_divisions_by_zero_are_those_of_numpy() -> None:
    @kernel
    def ratio(a, b):
        return a / b

    assert ratio(1.0, 0.0) == math.inf
    assert math.isnan(ratio(0.0, 0.0))


def test_copies() -> None:
    rows, out = np.arange(6.0).reshape(3, 2), np.zeros((4, 3))
    copy_rows(out, rows)
    assert (out[:3, :2] == rows).all()
    assert out[3].tolist() == out[:, 2].tolist()[:3] == [0.0, 0.0, 0.0]
    line = np.arange(5.0)
    copy_to(line, line[2:])
    assert line.tolist() == [2.0, 3.0, 4.0, 3.0, 4.0]


def test_flags_are_compared_as_numba_compares_them() -> None:
    usual = [Flags() for _ in range(3)]
    usual[1].nrt = usual[2].nrt = True
    usual[2].boundscheck = False  # as it is by default
    own = [_Flags(flags) for flags in usual]
    for a, mine in zip(usual, own, strict=True):
        for b, other in zip(usual, own, strict=True):
            assert (mine == other) == (mine == b) == (b == mine) == (a == b)
        assert hash(mine) == hash(a)
        assert mine.values() == a.values()
        assert mine.copy() == a
    assert own[0] != own[1] == own[2]


def test_garbage_is_looked_for_as_before_once_a_kernel_is_there() -> None:
    before = gc.get_threshold()
    try:
        for threshold in ((700, 10, 10), (0, 10, 10)):
            gc.set_threshold(*threshold)
            with pytest.raises(TypingError):
                checked("no number")
            assert gc.get_threshold() == threshold
    finally:
        gc.set_threshold(*before)
