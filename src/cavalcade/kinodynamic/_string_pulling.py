"""A way on the grid pulled tight: walks from rest to rest along straight lines."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.kinodynamic._stance import make_walk, walk_meets_something, walk_problem
from cavalcade.kinodynamic._trees import edge_heading, may_turn
from cavalcade.kinodynamic.parameters import END, OK, SIZE
from cavalcade.lattice.surface import surface


@njit(cache=True)
def pull(ground, body, discs, way, yaw):
    """Walks between points of a way, each as long as it can be found by doubling and halving.

    Args:
        way: `(K, 2)` x, y from the start to the goal.
        yaw: `(2,)` at the start and the goal.

    Returns:
        `(M, SIZE)`, empty if two neighbouring points cannot be joined so.
    """
    count = way.shape[0]
    edges = np.empty((count - 1, SIZE))
    edge, scratch = np.empty(SIZE), np.empty(6)
    begin, end = np.empty(6), np.empty(6)
    _stand(ground, body, way[0], begin)
    at, kept, arrival = 0, 0, yaw[0]
    while at < count - 1:
        good, bad, step = at, count, 1
        while True:
            to = min(at + step, count - 1)
            if bad < count:
                to = (good + bad) // 2
            if to <= good:
                break
            _stand(ground, body, way[to], end)
            if _walks(
                ground, body, discs, begin, end, arrival, yaw[1], to == count - 1, edge, scratch
            ):
                good = to
                edges[kept] = edge
                step *= 4
                if to == count - 1:
                    break
            else:
                bad = to
            if bad - good <= 1:
                break
        if good == at:
            return edges[:0].copy()
        at = good
        for k in range(6):
            begin[k] = edges[kept, END + k]
        cos, sin = edge_heading(edges[kept], True)
        arrival = math.atan2(sin, cos)
        kept += 1
    return edges[:kept].copy()


@njit(cache=True)
def _stand(ground, body, point, out):
    out[0], out[1] = point[0], point[1]
    out[2] = surface(ground, point[0], point[1])[0] + body.h_nom
    out[3], out[4], out[5] = 0.0, 0.0, 0.0


@njit(cache=True)
def _walks(ground, body, discs, begin, end, arrival, final, last, edge, scratch):
    if not make_walk(ground, body, begin, end, edge):
        return False
    cos, sin = edge_heading(edge, False)
    if not may_turn(ground, body, discs, begin, arrival, cos, sin):
        return False
    if last and not may_turn(
        ground, body, discs, end, math.atan2(sin, cos), math.cos(final), math.sin(final)
    ):
        return False
    if walk_meets_something(ground, body, discs, edge, scratch):
        return False
    return walk_problem(ground, body, discs, edge, False, scratch)[0] == OK
