"""Kernels of the search's book-keeping: a heap of nodes, a table of closed bins, growth."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
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


@njit(cache=True)
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


@njit(cache=True)
def slot_of(table, key):
    """Where the key stands in the table of closed bins, or could."""
    mask = table.shape[0] - 1
    mixed = (key * np.int64(-7046029254386353131)) ^ (key >> np.int64(29))
    k = (mixed ^ (mixed >> np.int64(32))) & mask
    while table[k] != -1 and table[k] != key:
        k = (k + 1) & mask
    return k


@njit(cache=True)
def doubled(array):
    """A copy with space for twice as many rows, of one dimension or two."""
    larger = np.empty((2 * array.shape[0], *array.shape[1:]), dtype=array.dtype)
    larger[: array.shape[0]] = array
    return larger
