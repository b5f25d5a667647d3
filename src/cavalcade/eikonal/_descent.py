"""Seeds of a march, interpolation in its result and the path back: compiled.

Points are given in cell units: u to the right and v up, with the centre of cell [row, col] at
u = col, v = row. Padded indices as in `_march`.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.eikonal._march import Stop, march
from cavalcade.kernels import kernel, subroutine

STEP = 0.5
"""Cells: step length of a walk down a field; at most 0.5."""


@subroutine
def line_time(u0, v0, u1, v1, grid):
    """Time in s along the straight segment, or inf if it touches a blocked cell.

    Exact for delays that are constant within each cell. A segment through the very corner of four
    cells touches all of them. Both ends lie inside the grid.
    """
    delay, stride = grid.delay, grid.stride
    du, dv = u1 - u0, v1 - v0
    length = math.hypot(du, dv)
    col, row = int(math.floor(u0 + 0.5)), int(math.floor(v0 + 0.5))
    n = (row + 1) * stride + col + 1
    right, up = (1 if du > 0.0 else -1), (1 if dv > 0.0 else -1)
    # Shares of the segment at which it leaves the column and the row that it is in.
    at_u = (col + 0.5 * right - u0) / du if du != 0.0 else np.inf
    at_v = (row + 0.5 * up - v0) / dv if dv != 0.0 else np.inf
    share = 0.0
    total = 0.0
    while True:
        here = delay[n]
        leaves = min(at_u, at_v, 1.0)
        if here == np.inf:
            return np.inf
        total += here * max(leaves - share, 0.0)
        if leaves >= 1.0:
            return length * total
        share = leaves
        corner = abs(at_u - at_v) * length < 1e-9
        if corner and (delay[n + right] == np.inf or delay[n + up * stride] == np.inf):
            return np.inf
        sideways = at_u <= at_v
        if sideways or corner:
            n += right
            at_u += abs(1.0 / du)
        if corner or not sideways:
            n += up * stride
            at_v += abs(1.0 / dv)


@kernel
def seed_point(u, v, radius, grid, times, visited, count):
    """Start a march at a point that need not be a cell's centre.

    Cells within `radius` cells that are in straight sight get the time along that straight line,
    which removes most of the first-order scheme's error around a point source.

    Returns:
        Number of cells in `visited`; unchanged if the point lies in a blocked cell.
    """
    rows, cols, stride = grid.rows, grid.cols, grid.stride
    row, col = int(math.floor(v + 0.5)), int(math.floor(u + 0.5))
    if row < 0 or row >= rows or col < 0 or col >= cols:
        return count
    if grid.delay[(row + 1) * stride + col + 1] == np.inf:
        return count
    reach = int(math.ceil(radius))
    for r in range(max(row - reach, 0), min(row + reach, rows - 1) + 1):
        for c in range(max(col - reach, 0), min(col + reach, cols - 1) + 1):
            if math.hypot(r - v, c - u) > max(radius, 1.0):
                continue
            n = (r + 1) * stride + c + 1
            time = line_time(u, v, float(c), float(r), grid)
            if time < times[n]:
                if times[n] == np.inf:
                    visited[count] = n
                    count += 1
                times[n] = time
    return count


@kernel
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


@subroutine
def straight_goal(u, v, reach, goals, grid):
    """Index of the goal soonest reached along a straight line of at most `reach`, -1 if none."""
    found = -1
    soonest = np.inf
    for k in range(goals.shape[0]):
        if math.hypot(goals[k, 0] - u, goals[k, 1] - v) <= reach:
            time = line_time(u, v, goals[k, 0], goals[k, 1], grid)
            if time < soonest:
                soonest, found = time, k
    return found


@kernel
def descend(u, v, goals, times, grid, points, stamps):
    """Walk down the arrival times from (u, v) to the goal below it.

    Gradient steps on the bilinear interpolant. Where it is not defined, would leave the free
    cells or does not descend, the walk goes from cell centre to the lowest neighbouring cell's
    centre until it is below all it has seen; so it always ends.

    Args:
        u, v: Start, in a reached cell.
        goals: `(G, 2)` where the march began.
        times: Padded arrival times, s.
        grid: What was marched over.
        points, stamps: `(K, 2)` and `(K,)`, filled with the path and its remaining times.

    Returns:
        Number of points, and whether the goal was reached.
    """
    delay, stride = grid.delay, grid.stride
    size = points.shape[0]
    best = time_at(u, v, times, stride)
    points[0, 0], points[0, 1], stamps[0] = u, v, best
    count = 1
    gridwise = False
    while count < size:
        # Near a goal the walk ends with the straight line to it.
        goal = straight_goal(u, v, 1.5, goals, grid)
        if goal >= 0:
            points[count, 0], points[count, 1] = goals[goal, 0], goals[goal, 1]
            stamps[count] = 0.0
            return count + 1, True
        row, col = int(math.floor(v + 0.5)), int(math.floor(u + 0.5))
        here = (row + 1) * stride + col + 1
        if not gridwise:
            # A step against the gradient of the bilinear interpolant; taken if it stays in
            # free cells, cuts no corner and descends.
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
                nu, nv = u - STEP * gu / norm, v - STEP * gv / norm
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
            # Otherwise to the lowest of the neighbouring cells' centres.
            lowest, target = times[here], here
            for k in range(9):
                dr, dc = k // 3 - 1, k % 3 - 1
                n = here + dr * stride + dc
                t = times[n]
                # A straight neighbour that was reached is free itself.
                if t < lowest and delay[here + dr * stride] + delay[here + dc] < np.inf:
                    lowest, target = t, n
            if target == here:
                if u == float(col) and v == float(row):
                    # Lowest of its neighbours: a seed in straight sight of a goal.
                    goal = straight_goal(u, v, np.inf, goals, grid)
                    if goal < 0:
                        return count, False
                    points[count, 0], points[count, 1] = goals[goal, 0], goals[goal, 1]
                    stamps[count] = 0.0
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


@kernel
def nearest_reached(u, v, values, rows, cols, reach):
    """Padded index of the finite cell of `values` nearest to (u, v), -1 if none within `reach`.

    Rings of cells around the point are searched from the inside out.
    """
    stride = cols + 2
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


@kernel
def local_path(start, goal, guess, grid, times, work, points, stamps):
    """March from the goal until the start is settled and walk back; leaves `times` at inf.

    The march leaves out cells that cannot lie on a path as good as the straight one, if the
    straight one is free, or as `guess`. If the path turns out longer than guessed, it is marched
    for again without the guess, so that the result does not depend on it.

    Args:
        start, goal: Points (u, v) in free cells.
        guess: Time that the path will hardly exceed, s.
        grid: What to march over.
        times: Padded, all inf.
        work: Of the march.
        points, stamps: `(K, 2)` and `(K,)`, filled with the path and its remaining times.

    Returns:
        Number of points, whether they reach the goal, and the time from the start, inf if there
        is no path. `points` is too short if there is one but the points do not reach the goal.
    """
    start_u, start_v = start
    goal_u, goal_v = goal
    row, col = int(math.floor(start_v + 0.5)), int(math.floor(start_u + 0.5))
    first = (row + 1) * grid.stride + col + 1
    none = np.int64(0)  # a literal would be compiled a second time
    straight = line_time(start_u, start_v, goal_u, goal_v, grid)
    slack = 4.0 * grid.delay[first]
    sure = 1.1 * straight + slack
    bound = min(sure, guess + slack)
    targets = np.array([first])
    while True:
        count = seed_point(goal_u, goal_v, 3.0, grid, times, work.visited, none)
        stop = Stop(targets, bound, start_v + 1.0, start_u + 1.0)
        count = march(grid, times, count, work, stop)
        if bound == sure or times[first] + slack <= bound:
            break
        for k in range(count):
            times[work.visited[k]] = np.inf
        bound = sure
    length, reached, eta = 0, False, np.inf
    if times[first] < np.inf:
        eta = time_at(start_u, start_v, times, grid.stride)
        goals = np.empty((1, 2))
        goals[0, 0], goals[0, 1] = goal_u, goal_v
        length, reached = descend(start_u, start_v, goals, times, grid, points, stamps)
    for k in range(count):
        times[work.visited[k]] = np.inf
    return length, reached, eta
