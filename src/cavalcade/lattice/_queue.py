"""Kernels of the search's book-keeping: a heap of nodes, a table of closed bins, growth."""

from __future__ import annotations

import numpy as np

from cavalcade.kernels import subroutine
from cavalcade.kernels.copying import copy_rows, copy_to


@subroutine
def push(heap, keys, size, node, key):
    """Put a node into the heap of `size` nodes; the new size."""
    heap[size] = node
    keys[size] = key
    k = size
    while k > 0:
        up = (k - 1) >> 1
        if keys[up] <= keys[k]:
            break
        keys[up], keys[k] = keys[k], keys[up]
        heap[up], heap[k] = heap[k], heap[up]
        k = up
    return size + 1


@subroutine
def pop(heap, keys, size):
    """Take the node of the least key out of the heap; it and the new size."""
    node = heap[0]
    size -= 1
    heap[0], keys[0] = heap[size], keys[size]
    k = 0
    while True:
        child = 2 * k + 1
        if child >= size:
            break
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[k] <= keys[child]:
            break
        keys[child], keys[k] = keys[k], keys[child]
        heap[child], heap[k] = heap[k], heap[child]
        k = child
    return node, size


@subroutine
def slot_of(table, key):
    """Where the key stands in the table of closed bins, or could."""
    mask = table.shape[0] - 1
    mixed = (key * np.int64(-7046029254386353131)) ^ (key >> np.int64(29))
    k = (mixed ^ (mixed >> np.int64(32))) & mask
    while table[k] != -1 and table[k] != key:
        k = (k + 1) & mask
    return k


@subroutine
def doubled(values):
    """A copy of `(N,)` values with space for twice as many."""
    larger = np.empty(2 * values.shape[0], dtype=values.dtype)
    copy_to(larger, values)
    return larger


@subroutine
def doubled_rows(rows):
    """A copy of `(N, K)` rows with space for twice as many."""
    larger = np.empty((2 * rows.shape[0], rows.shape[1]), dtype=rows.dtype)
    copy_rows(larger, rows)
    return larger
