"""The compiled march. Arrays and numbers in, arrays out.

Grids are flattened and padded by one blocked cell on every side, so that neighbours need no
bounds checks: cell [row, col] sits at (row + 1) * stride + col + 1 with stride = cols + 2.

Three things make it fast. Indices are unsigned, which spares the compiler Python's negative
indices. The cells of a bucket are served in batches by loops whose bodies hardly branch: what is
to be kept is written in any case, and only then does a counter move on or not; a processor guesses
branches on arrival times wrong half of the time, and a wrong guess costs more than all the
arithmetic of a cell. And memory some cells ahead of the front is asked for early, which halves
the time on maps that are larger than the processor's cache.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import uint32, uintp

from cavalcade.eikonal._prefetch import prefetch
from cavalcade.kernels import kernel, subroutine

BUCKETS = 1024
BATCH = 512
"""Cells that are served together."""
NONE = uint32(0xFFFFFFFF)
"""End of a linked list."""
_COLUMNS_AHEAD, _ROWS_AHEAD = 6, 4  # how far from the front memory is asked for


class PaddedGrid(NamedTuple):
    """A speed map as a march reads it.

    Attributes:
        delay: Padded `(P,)` seconds per cell, inf where blocked.
        rows, cols: Of the map, without the padding.
        stride: Padded row length.
        least: Least seconds per cell anywhere; inf if all is blocked.
        width: Height of a bucket, s.
    """

    delay: np.ndarray
    rows: int
    cols: int
    stride: int
    least: float
    width: float


class WorkSpace(NamedTuple):
    """What a march needs besides its grids; may be used again.

    Attributes:
        heads: `(BUCKETS,)` first node of each bucket's list.
        cells, links: `(Q,)` cell of each queue node, and the next node of its list.
        spares: `(Q,)` nodes that are in no list.
        later: `(P,)` cells for later rounds of buckets.
        visited: `(P,)` cells that have a time.
    """

    heads: np.ndarray
    cells: np.ndarray
    links: np.ndarray
    spares: np.ndarray
    later: np.ndarray
    visited: np.ndarray


class Stop(NamedTuple):
    """When a march may end, and what it may leave out.

    Attributes:
        targets: Padded indices of cells to settle, with the cells around them that are no more
            than one and a half of their own delays later; empty means all that can be reached.
        bound: Cells are left out from which the focus cannot be reached by this time, s; inf
            switches that off.
        row, col: Padded row and column of the focus.
    """

    targets: np.ndarray
    bound: float
    row: float
    col: float


def work_space(size: int, nodes: int = 0) -> WorkSpace:
    """Work space for a march over `size` padded cells.

    Args:
        size: Number of padded cells.
        nodes: Number of queue nodes. At least one for each cell, which a front hardly ever comes
            near to.
    """
    heads = np.full(BUCKETS, NONE, np.uint32)
    cells, links, spares = (np.empty(max(nodes, size), np.uint32) for _ in range(3))
    return WorkSpace(
        heads, cells, links, spares, np.empty(size, np.uint32), np.empty(size, np.uint32)
    )


@kernel(nogil=True)
def pad_delays(speed, cell, delay):
    """Fill padded delays `(P,)`, s per cell, from speeds `(rows, cols)`, m/s.

    Returns:
        Whether no speed is negative.
    """
    rows, cols = speed.shape
    stride = cols + 2
    negative = 0
    delay[:stride] = np.inf
    for r in range(rows):
        line = delay[(r + 1) * stride : (r + 2) * stride]
        line[0] = np.inf
        for c in range(cols):
            value = speed[r, c]
            negative |= value < 0.0
            line[c + 1] = cell / (value + 0.0)  # not minus zero
        line[cols + 1] = np.inf
    delay[(rows + 1) * stride :] = np.inf
    return negative == 0


@subroutine(fastmath={"nnan", "nsz", "contract"})
def least_rest(cells, count, grid, stop, rest):
    """Lower bounds `rest` in s of the times from cells on to the focus of `stop`."""
    per_row = 1.0 / grid.stride
    for k in range(count):
        n = float(cells[k])
        row = math.floor((n + 0.5) * per_row)
        down, across = row - stop.row, n - row * grid.stride - stop.col
        away = math.sqrt(down * down + across * across)
        rest[k] = max(away - 1.5, 0.0) * grid.least


@kernel(fastmath={"nnan", "nsz", "contract"}, nogil=True)
def march(grid, times, seeds, work, stop):
    """Propagate arrival times from seeded cells.

    Label-correcting march over buckets of time: the neighbours of the lowest bucket's cells are
    given new times, in any order, until no cell of the bucket changes. No heap, and the result is
    the fixed point of the first-order upwind scheme, whatever the order.

    Args:
        grid: A `PaddedGrid` of P cells.
        times: Padded `(P,)` s, inf but for the seeds; filled in place.
        seeds: Number of seeds, which stand in front in `work.visited`; on return it lists every
            cell with a time.
        work: From `work_space(P)`.
        stop: When to end.

    Returns:
        Number of cells in `work.visited`.

    Raises:
        MemoryError: There are too few queue nodes; times and work space are spoilt.
    """
    delay, visited, targets, bound = grid.delay, work.visited, stop.targets, stop.bound
    heads, cells, links, spares, far = work.heads, work.cells, work.links, work.spares, work.later
    none, one, stride = uintp(0), uintp(1), uintp(grid.stride)
    columns_ahead, rows_ahead = uintp(_COLUMNS_AHEAD), uintp(_ROWS_AHEAD * grid.stride)
    changed = np.empty(4 * BATCH, np.uint32)  # cells that may get a new time
    ahead = np.empty(4 * BATCH, np.uint32)  # where the front goes from there
    queued = np.empty(4 * BATCH, np.uint32)  # cells to queue, and the buckets they go to
    into = np.empty(4 * BATCH, np.uint32)
    rest = np.zeros(4 * BATCH)  # s from there to the focus, at least
    per_second = 1.0 / grid.width
    guided = bound < np.inf
    base = -np.inf
    count = uintp(seeds)
    far_count = uintp(seeds)
    pool = uintp(cells.size)
    made = uint32(0)  # nodes taken from the pool so far
    spare = none  # nodes in `spares`
    for k in range(seeds):
        far[k] = visited[k]
    while True:
        # Cells too late for the last round of buckets: start a round at the earliest of them.
        kept = none
        lowest = np.inf
        for k in range(far_count):
            n = far[k]
            t = times[uintp(n)]
            if (t - base) * per_second >= BUCKETS:
                far[kept] = n
                kept += one
                lowest = min(lowest, t)
        if kept == none:
            return count
        base = lowest
        far_count = none
        # Hang the cells of this round into their buckets' lists.
        for k in range(kept):
            n = far[k]
            place = (times[uintp(n)] - base) * per_second
            if place >= BUCKETS:
                far[far_count] = n
                far_count += one
            else:
                if spare == none:
                    spares[none] = made
                    made += uint32(1)
                    spare = one
                spare -= one
                node = spares[spare]
                cells[uintp(node)] = n
                links[uintp(node)] = heads[uintp(place)]
                heads[uintp(place)] = node
        for bucket in range(BUCKETS):
            b = uintp(bucket)
            # A bucket is served until it stays empty: its cells may lower one another.
            while heads[b] != NONE:
                # Take a batch of cells off the list and collect their free, later neighbours.
                node = heads[b]
                todo = none
                room = BATCH
                while node != NONE and room > 0:
                    room -= 1
                    cell = uintp(cells[uintp(node)])
                    spares[spare] = node
                    spare += one
                    node = links[uintp(node)]
                    t = times[cell]
                    if (t - base) * per_second < b:
                        continue  # it was lowered into an earlier bucket and served there
                    n = cell - stride
                    changed[todo] = n
                    ahead[todo] = n - rows_ahead
                    todo += uintp((times[n] > t) & (delay[n] < np.inf))
                    n = cell - one
                    changed[todo] = n
                    ahead[todo] = n - columns_ahead
                    todo += uintp((times[n] > t) & (delay[n] < np.inf))
                    n = cell + one
                    changed[todo] = n
                    ahead[todo] = n + columns_ahead
                    todo += uintp((times[n] > t) & (delay[n] < np.inf))
                    n = cell + stride
                    changed[todo] = n
                    ahead[todo] = n + rows_ahead
                    todo += uintp((times[n] > t) & (delay[n] < np.inf))
                heads[b] = node
                # Each of them may be queued: see that there are as many nodes to hand.
                while spare < todo:
                    if uintp(made) >= pool:
                        raise MemoryError("work space of the march exhausted")
                    spares[spare] = made
                    made += uint32(1)
                    spare += one
                if guided:
                    least_rest(changed, todo, grid, stop, rest)
                # Solve the upwind scheme for them; note which are to be queued, and where.
                fresh = none
                for k in range(todo):
                    n = uintp(changed[uintp(k)])
                    prefetch(times, uintp(ahead[uintp(k)]))
                    prefetch(delay, uintp(ahead[uintp(k)]))
                    q = delay[n]
                    old = times[n]
                    across = min(times[n - one], times[n + one])
                    along = min(times[n - stride], times[n + stride])
                    low, high = min(across, along), max(across, along)
                    # Where the later axis does not take part, gap = q and new = low + q.
                    gap = min(high - low, q)
                    new = low + 0.5 * (gap + math.sqrt(2.0 * q * q - gap * gap))
                    # No rounding error may put it into a bucket that has been served.
                    new = max(new, min(high, low + q))
                    # The tolerance ends the exchange of rounding errors between neighbours.
                    lower = (new * (1.0 + 1e-12) < old) & (new + rest[uintp(k)] <= bound)
                    times[n] = new if lower else old
                    first = lower & (old == np.inf)
                    visited[count] = n
                    count += uintp(first)
                    place = (new - base) * per_second
                    if place >= BUCKETS:
                        far[far_count] = n
                        far_count += uintp(first)
                        continue
                    nb = uintp(place)
                    # Otherwise it waits in that bucket already.
                    push = lower & ((nb == b) | ((old - base) * per_second >= nb + one))
                    queued[fresh] = n
                    into[fresh] = nb
                    fresh += uintp(push)
                for k in range(fresh):  # queue them
                    spare -= one
                    node = spares[spare]
                    nb = uintp(into[uintp(k)])
                    cells[uintp(node)] = queued[uintp(k)]
                    links[uintp(node)] = heads[nb]
                    heads[nb] = node
            # Targets are settled once no later bucket can change the cells around them.
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
