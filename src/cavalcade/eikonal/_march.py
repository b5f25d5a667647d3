"""The compiled march. Arrays and numbers in, arrays out.

Grids are flattened and padded by one blocked cell on every side, so that neighbours need no
bounds checks: cell [row, col] sits at (row + 1) * stride + col + 1 with stride = cols + 2.
Indices are unsigned, which spares the compiler Python's negative indices: a fifth of the time.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, uint32, uintp

BUCKETS = 1024
POOL = 4
"""Queue nodes per cell; far more than a front ever holds."""
NONE = uint32(0xFFFFFFFF)
"""End of a linked list."""


@njit(cache=True)
def remaining(n, stride, focus):
    """Lower bound in s of the way from cell `n` to the place `focus` (row, col, least delay)."""
    row = n // stride
    away = math.hypot(float(row) - focus[0], float(n - row * stride) - focus[1])
    return max(away - 1.5, 0.0) * focus[2]


@njit(cache=True, fastmath={"nnan", "nsz", "contract", "reassoc"})
def march(delay, row_length, times, visited, seeds, heads, cells, links, far, width, targets,
          bound, focus):  # fmt: skip
    """Propagate arrival times from seeded cells.

    Label-correcting march over buckets of time: cells of the lowest bucket are relaxed, in any
    order, until none of them changes. No heap, and the result is the fixed point of the
    first-order upwind scheme, whatever the order of relaxation.

    Args:
        delay: Padded `(P,)` seconds per cell, inf where blocked.
        row_length: Padded row length.
        times: Padded `(P,)`, inf but for the seeds; filled in place.
        visited: `(P,)` uint32; the seeds stand in front; lists every cell with a time on return.
        seeds: Number of seeds.
        heads: `(BUCKETS,)` uint32, NONE; NONE again on return.
        cells, links, far: Work space, uint32, `(POOL P,)`, `(POOL P,)` and `(P,)`.
        width: Height of a bucket, s.
        targets: Padded indices of cells to settle, with the cells around them that are no more
            than one and a half of their own delays later; empty means all that can be reached.
        bound: Cells are left out from which the focus cannot be reached by this time, s; inf
            switches that off.
        focus: `(3,)` padded row and column of the focus, least seconds per cell.

    Returns:
        Number of cells in `visited`.
    """
    one = uintp(1)
    stride = uintp(row_length)
    steps = np.array([-1, 1, -row_length, row_length]).view(np.uintp)
    sides = np.array([row_length, row_length, 1, 1]).view(np.uintp)
    per_second = 1.0 / width
    base = np.inf
    count = uintp(seeds)
    far_count = uintp(0)
    free = uint32(0)
    spare = NONE
    limit = uint32(cells.size)
    for k in range(seeds):
        base = min(base, times[uintp(visited[k])])
        far[k] = visited[k]
        far_count += one
    last = base - 1.0
    while far_count > uintp(0):
        # Cells too late for the last round of buckets: start a round at the earliest of them.
        lowest = np.inf
        for k in range(far_count):
            t = times[uintp(far[k])]
            if t >= last:
                lowest = min(lowest, t)
        if lowest == np.inf:
            break
        base = lowest
        kept = uintp(0)
        for k in range(far_count):
            n = uintp(far[k])
            if times[n] < last:
                continue
            place = (times[n] - base) * per_second
            if place >= BUCKETS:
                far[kept] = far[k]
                kept += one
            else:
                node = spare
                if node != NONE:
                    spare = links[uintp(node)]
                else:
                    node = free
                    free += uint32(1)
                cells[uintp(node)] = n
                links[uintp(node)] = heads[uintp(place)]
                heads[uintp(place)] = node
        far_count = kept
        last = base + BUCKETS * width
        for bucket in range(BUCKETS):
            b = uintp(bucket)
            while heads[b] != NONE:
                node = heads[b]
                cell = uintp(cells[uintp(node)])
                heads[b] = links[uintp(node)]
                links[uintp(node)] = spare
                spare = node
                t = times[cell]
                if (t - base) * per_second < b:
                    continue  # it was lowered into an earlier bucket and has been served there
                for k in range(4):
                    step = steps[uintp(k)]
                    n = cell + step
                    old = times[n]
                    q = delay[n]
                    if old <= t or q == np.inf:
                        continue
                    across = sides[uintp(k)]
                    gap = t - min(times[n - across], times[n + across])
                    if gap >= q:
                        continue  # the other axis decides alone
                    gap = max(gap, -q)  # where it does not take part: new = t + q
                    new = t + 0.5 * (math.sqrt(2.0 * q * q - gap * gap) - gap)
                    # The tolerance ends the exchange of rounding errors between neighbours.
                    if new * (1.0 + 1e-12) >= old:
                        continue
                    if bound < np.inf and new + remaining(n, stride, focus) > bound:
                        continue
                    times[n] = new
                    if old == np.inf:
                        visited[count] = n
                        count += one
                    place = (new - base) * per_second
                    if place >= BUCKETS:
                        if old == np.inf:
                            far[far_count] = n
                            far_count += one
                        continue
                    nb = uintp(place)
                    if nb != b and old < np.inf and (old - base) * per_second < nb + one:
                        continue  # it waits in that bucket already
                    node = spare
                    if node != NONE:
                        spare = links[uintp(node)]
                    else:
                        node = free
                        free += uint32(1)
                        if free >= limit:
                            raise MemoryError("work space of the march exhausted")
                    cells[uintp(node)] = n
                    links[uintp(node)] = heads[nb]
                    heads[nb] = node
            if targets.size > 0:
                settled = True
                for k in range(targets.size):
                    target = uintp(targets[k])
                    if (times[target] + 1.5 * delay[target] - base) * per_second >= b + one:
                        settled = False
                        break
                if settled:
                    for later in range(bucket, BUCKETS):
                        heads[uintp(later)] = NONE
                    return count
    return count
