"""Seeds of a march, interpolation in its result and the way back: compiled.

Points are given in cell units: u to the right and v up, with the centre of cell [row, col] at
u = col, v = row. Padded indices as in `_march`.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.eikonal._march import march


@njit(cache=True)
def line_time(u0, v0, u1, v1, delay, stride):
    """Time in s along the straight segment, or inf if a blocked cell lies on it."""
    length = math.hypot(u1 - u0, v1 - v0)
    count = max(int(math.ceil(2.0 * length)), 1)
    total = 0.0
    for k in range(count + 1):
        share = k / count
        u, v = u0 + share * (u1 - u0), v0 + share * (v1 - v0)
        here = delay[int(math.floor(v + 1.5)) * stride + int(math.floor(u + 1.5))]
        if here == np.inf:
            return np.inf
        total += here * (0.5 if k == 0 or k == count else 1.0)
    return length * total / count


@njit(cache=True)
def seed_point(u, v, radius, delay, rows, cols, stride, times, visited, count):
    """Start a march at a point that need not be a cell's centre.

    Cells within `radius` cells that are in straight sight get the time along that straight line,
    which removes most of the first-order scheme's error around a point source.

    Returns:
        Number of cells in `visited`; unchanged if the point lies in a blocked cell.
    """
    row, col = int(math.floor(v + 0.5)), int(math.floor(u + 0.5))
    if row < 0 or row >= rows or col < 0 or col >= cols:
        return count
    if delay[(row + 1) * stride + col + 1] == np.inf:
        return count
    reach = int(math.ceil(radius))
    for r in range(max(row - reach, 0), min(row + reach, rows - 1) + 1):
        for c in range(max(col - reach, 0), min(col + reach, cols - 1) + 1):
            if math.hypot(r - v, c - u) > max(radius, 1.0):
                continue
            n = (r + 1) * stride + c + 1
            time = line_time(u, v, float(c), float(r), delay, stride)
            if time < times[n]:
                if times[n] == np.inf:
                    visited[count] = n
                    count += 1
                times[n] = time
    return count


@njit(cache=True)
def time_at(u, v, times, stride):
    """Arrival time at a point inside the grid: bilinear between reached cells, inf without any.

    Where some of the four cells around are not reached, the weights are spread over the others.
    """
    fu, fv = math.floor(u), math.floor(v)
    au, av = u - fu, v - fv
    n = int(fv + 1.0) * stride + int(fu + 1.0)
    total = 0.0
    weight = 0.0
    for k in range(4):
        dr, dc = k // 2, k % 2
        t = times[n + dr * stride + dc]
        if t < np.inf:
            w = (av if dr == 1 else 1.0 - av) * (au if dc == 1 else 1.0 - au) + 1e-12
            total += w * t
            weight += w
    return total / weight if weight > 1e-9 else np.inf


@njit(cache=True)
def descend(u, v, goal_u, goal_v, times, delay, stride, step, points, stamps):
    """Walk down the arrival times from (u, v) to the goal.

    Gradient steps on the bilinear interpolant. Where it is not defined, would leave the free
    cells or does not descend, the walk goes from cell centre to the lowest neighbouring cell's
    centre until it is below all it has seen; so it always ends.

    Args:
        u, v: Start, in a reached cell.
        goal_u, goal_v: Where the march began.
        step: Step length in cells, at most 0.5.
        points, stamps: `(K, 2)` and `(K,)`, filled with the way and its times.

    Returns:
        Number of points, and whether the goal was reached.
    """
    size = points.shape[0]
    count = 0
    best = time_at(u, v, times, stride)
    points[0, 0], points[0, 1], stamps[0] = u, v, best
    count = 1
    gridwise = False
    while count < size:
        away = math.hypot(goal_u - u, goal_v - v)
        if away <= 1.5 and line_time(u, v, goal_u, goal_v, delay, stride) < np.inf:
            points[count, 0], points[count, 1], stamps[count] = goal_u, goal_v, 0.0
            return count + 1, True
        row, col = int(math.floor(v + 0.5)), int(math.floor(u + 0.5))
        here = (row + 1) * stride + col + 1
        if not gridwise:
            fu, fv = math.floor(u), math.floor(v)
            au, av = u - fu, v - fv
            n = int(fv + 1.0) * stride + int(fu + 1.0)
            t00, t01 = times[n], times[n + 1]
            t10, t11 = times[n + stride], times[n + stride + 1]
            gu = (t01 - t00) * (1.0 - av) + (t11 - t10) * av
            gv = (t10 - t00) * (1.0 - au) + (t11 - t01) * au
            norm = math.hypot(gu, gv)
            gridwise = True
            if 0.0 < norm < np.inf:
                nu, nv = u - step * gu / norm, v - step * gv / norm
                nrow, ncol = int(math.floor(nv + 0.5)), int(math.floor(nu + 0.5))
                there = (nrow + 1) * stride + ncol + 1
                free = times[there] < np.inf
                if free and nrow != row and ncol != col:
                    free = (
                        delay[(row + 1) * stride + ncol + 1] < np.inf
                        and delay[(nrow + 1) * stride + col + 1] < np.inf
                    )
                if free:
                    value = time_at(nu, nv, times, stride)
                    if value < best:
                        best = value
                        u, v = nu, nv
                        gridwise = False
        if gridwise:
            lowest, target = times[here], here
            for k in range(9):
                dr, dc = k // 3 - 1, k % 3 - 1
                n = here + dr * stride + dc
                t = times[n]
                if t < lowest:
                    if dr != 0 and dc != 0:
                        if delay[here + dr * stride] == np.inf or delay[here + dc] == np.inf:
                            continue
                    lowest, target = t, n
            if target == here:
                if u == float(col) and v == float(row):
                    # Lowest of its neighbours: a seed in straight sight of the goal.
                    points[count, 0], points[count, 1], stamps[count] = goal_u, goal_v, 0.0
                    return count + 1, True
                u, v = float(col), float(row)
            else:
                v = float(target // stride - 1)
                u = float(target % stride - 1)
            if lowest < best:
                best = lowest
                gridwise = False
        points[count, 0], points[count, 1], stamps[count] = u, v, min(best, stamps[count - 1])
        count += 1
    return count, False


@njit(cache=True)
def nearest_reached(u, v, values, rows, cols, stride, reach):
    """Padded index of the finite cell of `values` nearest to (u, v), -1 if none within `reach`."""
    row, col = int(math.floor(v + 0.5)), int(math.floor(u + 0.5))
    found = -1
    closest = np.inf
    ring = 0
    while ring <= reach and ring - 1 <= closest:
        for r in range(max(row - ring, 0), min(row + ring, rows - 1) + 1):
            edge = r == row - ring or r == row + ring
            step = 1 if edge or ring == 0 else 2 * ring
            for c in range(col - ring, col + ring + 1, step):
                if c < 0 or c >= cols:
                    continue
                n = (r + 1) * stride + c + 1
                if values[n] < np.inf:
                    away = math.hypot(c - u, r - v)
                    if away < closest:
                        closest, found = away, n
        ring += 1
    return found


@njit(cache=True)
def local_path(start_u, start_v, goal_u, goal_v, delay, rows, cols, stride, times, visited, heads,
               cells, links, far, width, least, step, points, stamps):  # fmt: skip
    """March from the goal until the start is settled, then walk back. Leaves `times` at inf.

    The march leaves out cells that cannot lie on a way as good as the straight one, if the
    straight one is free.

    Returns:
        Number of points, whether the start reaches the goal, and the time from the start.
    """
    row, col = int(math.floor(start_v + 0.5)), int(math.floor(start_u + 0.5))
    start = (row + 1) * stride + col + 1
    count = seed_point(goal_u, goal_v, 3.0, delay, rows, cols, stride, times, visited, 0)
    if count == 0 or delay[start] == np.inf:
        for k in range(count):
            times[visited[k]] = np.inf
        return 0, False, np.inf
    straight = line_time(start_u, start_v, goal_u, goal_v, delay, stride)
    bound = 1.1 * straight + 4.0 * delay[start]
    focus = np.array([start_v + 1.0, start_u + 1.0, least])
    targets = np.array([start])
    count = march(delay, stride, times, visited, count, heads, cells, links, far, width, targets,
                  bound, focus)  # fmt: skip
    length, reached, eta = 0, False, np.inf
    if times[start] < np.inf:
        eta = time_at(start_u, start_v, times, stride)
        length, reached = descend(
            start_u, start_v, goal_u, goal_v, times, delay, stride, step, points, stamps
        )
    for k in range(count):
        times[visited[k]] = np.inf
    return length, reached, eta
