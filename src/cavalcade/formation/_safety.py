"""The last filter's kernels: the least change that respects clearances, and its certificate."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.formation._bodies import contact_centres, distance_at, rectangle_gap
from cavalcade.robots.motion import advance, ellipse_scale

ARM = 0.25
"""m; weighs turning against moving: u = (vx, vy, ARM * yaw rate)."""
NEAR_GAP = 0.3
"""m: nearer than this, the lever arms of a pair are taken at the centre of its contact."""
SLOP = 0.03
"""m of distance that still counts as part of that contact."""
SWEEPS = 100
LEVELS = 5
"""Candidates per robot: filtered command, half of it, without its turn, its turn alone, stop."""


@njit(cache=True)
def approach_speed(gap, braking, period):
    """Largest closing speed from which `braking` stops within `gap`, one period late; m/s."""
    if gap <= 0.0:
        return max(2.0 * gap, -0.15)  # too near already: open up gently
    lag = braking * period
    return math.sqrt(2.0 * braking * gap + lag * lag) - lag


@njit(cache=True)
def obstacle_rows(k, pose, discs, disc_radius, keep, margin, braking, period, distance,
                  cell, rows, bounds, owners, count):  # fmt: skip
    """Constraints of robot `k` against the map: its discs and its centre's clearance."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(discs.shape[0] + 1):
        centre = i == discs.shape[0]
        needed = keep if centre else disc_radius + margin
        if needed <= 0.0:
            continue
        rx, ry = 0.0, 0.0
        if not centre:
            rx, ry = c * discs[i, 0] - s * discs[i, 1], s * discs[i, 0] + c * discs[i, 1]
        d, gx, gy = distance_at(distance, cell, pose[0] + rx, pose[1] + ry)
        if d - needed > 0.5:
            continue
        norm = math.hypot(gx, gy)
        if norm < 0.4:
            continue  # a ridge: no single direction leads away
        gx, gy = gx / norm, gy / norm
        rows[count, 0], rows[count, 1] = gx, gy
        rows[count, 2] = (-gx * ry + gy * rx) / ARM
        rows[count, 3], rows[count, 4], rows[count, 5] = 0.0, 0.0, 0.0
        bounds[count] = -approach_speed(d - needed, braking, period)
        owners[count, 0], owners[count, 1] = k, -1
        count += 1
    return count


@njit(cache=True)
def project(wanted, weights, rows, bounds, owners, count):
    """Hildreth's method: the nearest `u` (weighted) with `rows u >= bounds`.

    Constraints are served the tightest first: an order that a mirrored problem shares.

    Args:
        wanted: `(N, 3)` wanted u.
        weights: `(N,)` how dear a change of each robot's u is.
        rows: `(R, 6)` coefficients for the first and the second owner.
        bounds: `(R,)`.
        owners: `(R, 2)` robots, -1 for none.
        count: Number of rows in use.
    """
    u = wanted.copy()
    dual = np.zeros(count)
    order = np.empty(count, np.int64)
    for r in range(count):
        k = r
        while k > 0 and bounds[order[k - 1]] < bounds[r]:
            order[k] = order[k - 1]
            k -= 1
        order[k] = r
    for _ in range(SWEEPS):
        change = 0.0
        for k in range(count):
            r = order[k]
            i, j = owners[r, 0], owners[r, 1]
            value = -bounds[r]
            square = 1e-9
            for a in range(3):
                value += rows[r, a] * u[i, a]
                square += rows[r, a] * rows[r, a] / weights[i]
                if j >= 0:
                    value += rows[r, 3 + a] * u[j, a]
                    square += rows[r, 3 + a] * rows[r, 3 + a] / weights[j]
            step = max(dual[r] - value / square, 0.0) - dual[r]
            if step == 0.0:
                continue
            dual[r] += step
            change = max(change, abs(step))
            for a in range(3):
                u[i, a] += step * rows[r, a] / weights[i]
                if j >= 0:
                    u[j, a] += step * rows[r, 3 + a] / weights[j]
        if change < 1e-6:
            break
    return u


@njit(cache=True)
def least_change(poses, wanted, weights, sizes, movers, mover_speeds, discs, disc_radius, keep,
                 margins, braking, period, distance, cell):  # fmt: skip
    """Wanted velocities, changed as little as clearances and braking distances ask for.

    Args:
        poses: `(N, 3)`.
        wanted: `(N, 3)` velocities in the map frame: m/s, m/s, rad/s.
        weights: `(N,)`; very large for a robot that cannot be commanded.
        sizes: `(N, 2)` half lengths and half widths, m.
        movers: `(M, 5)` moving obstacles: pose, half length, half width.
        mover_speeds: `(M, 2)` m/s.
        discs: `(D, 2)` centres of the discs that cover a robot's footprint, body frame, m.
        disc_radius: Their radius, m.
        keep: `(N,)` clearance of the robot's centre, m; 0 for none.
        margins: To obstacles, between footprints, between centres (m).
        braking: Deceleration to count on, m/s².
        period: Seconds per cycle.
        distance: `(rows, cols)` distance map, m.
        cell: Cell size, m.

    Returns:
        `(N, 3)` velocities in the map frame.
    """
    n, m = poses.shape[0], movers.shape[0]
    most = n * (discs.shape[0] + 1) + n * (n - 1) + n * m
    rows, bounds = np.zeros((most, 6)), np.zeros(most)
    owners = np.full((most, 2), -1)
    count = np.int64(0)
    for k in range(n):
        if weights[k] < 1e6:
            count = obstacle_rows(k, poses[k], discs, disc_radius, keep[k], margins[0],
                                  braking, period, distance, cell, rows, bounds, owners,
                                  count)  # fmt: skip
    for i in range(n):
        for j in range(i + 1, n):
            dx, dy = poses[i, 0] - poses[j, 0], poses[i, 1] - poses[j, 1]
            away = math.hypot(dx, dy)
            reach = math.hypot(sizes[i, 0], sizes[i, 1]) + math.hypot(sizes[j, 0], sizes[j, 1])
            if away > reach + 1.3 or away < 1e-9:
                continue
            gap, nx, ny, px, py, qx, qy = rectangle_gap(
                poses[i], sizes[i, 0], sizes[i, 1], poses[j], sizes[j, 0], sizes[j, 1]
            )
            if gap < NEAR_GAP:
                px, py, qx, qy = contact_centres(
                    poses[i], sizes[i, 0], sizes[i, 1], poses[j], sizes[j, 0], sizes[j, 1], SLOP
                )
            rows[count, 0], rows[count, 1] = nx, ny
            rows[count, 2] = (-nx * (py - poses[i, 1]) + ny * (px - poses[i, 0])) / ARM
            rows[count, 3], rows[count, 4] = -nx, -ny
            rows[count, 5] = (nx * (qy - poses[j, 1]) - ny * (qx - poses[j, 0])) / ARM
            bounds[count] = -approach_speed(gap - margins[1], 1.5 * braking, period)
            owners[count, 0], owners[count, 1] = i, j
            count += 1
            if weights[i] >= 1e6 or weights[j] >= 1e6:
                continue  # one that does not drive is an obstacle: only footprints matter
            rows[count, 0], rows[count, 1], rows[count, 2] = dx / away, dy / away, 0.0
            rows[count, 3], rows[count, 4], rows[count, 5] = -dx / away, -dy / away, 0.0
            bounds[count] = -approach_speed(away - margins[2], 1.5 * braking, period)
            owners[count, 0], owners[count, 1] = i, j
            count += 1
    for i in range(n):
        for j in range(m):
            gap, nx, ny, px, py, _, _ = rectangle_gap(
                poses[i], sizes[i, 0], sizes[i, 1], movers[j], movers[j, 3], movers[j, 4]
            )
            if gap > 2.0 or weights[i] >= 1e6:
                continue
            rows[count, 0], rows[count, 1] = nx, ny
            rows[count, 2] = (-nx * (py - poses[i, 1]) + ny * (px - poses[i, 0])) / ARM
            rows[count, 3], rows[count, 4], rows[count, 5] = 0.0, 0.0, 0.0
            approach = nx * mover_speeds[j, 0] + ny * mover_speeds[j, 1]
            bounds[count] = approach - approach_speed(gap - margins[1], braking, period)
            owners[count, 0], owners[count, 1] = i, -1
            count += 1
    u = wanted.copy()
    for i in range(n):
        u[i, 2] *= ARM
    u = project(u, weights, rows, bounds, owners, count)
    for i in range(n):
        u[i, 2] /= ARM
    return u


@njit(cache=True)
def roll_out(pose, velocity, command, limits, period, substeps, held, out):
    """Poses `(T, 3)` while the command is held for some steps and then a stop is commanded."""
    state = (pose[0], pose[1], pose[2], velocity[0], velocity[1], velocity[2])
    going, stop = (command[0], command[1], command[2]), (0.0, 0.0, 0.0)
    dt = period / substeps
    for t in range(out.shape[0]):
        state = advance(state, going if t < held else stop, dt, limits)
        out[t, 0], out[t, 1], out[t, 2] = state[0], state[1], state[2]


@njit(cache=True)
def map_slack(path, discs, disc_radius, keep, hard, distance, cell):
    """Least slack over poses `(T, 3)`: clearance of discs and centre beyond what is needed; m.

    Where the centre alone shows that the whole body is clear, its discs are not looked at: such
    a pose counts with the clearance of the circle around them.
    """
    around = 0.0
    for i in range(discs.shape[0]):
        around = max(around, math.hypot(discs[i, 0], discs[i, 1]))
    around += disc_radius + hard
    least = np.inf
    body = np.inf
    for t in range(path.shape[0]):
        x, y, yaw = path[t, 0], path[t, 1], path[t, 2]
        middle, _, _ = distance_at(distance, cell, x, y)
        if keep > 0.0:
            least = min(least, middle - keep)
        if middle >= around:
            body = min(body, middle - around)
            continue
        c, s = math.cos(yaw), math.sin(yaw)
        for i in range(discs.shape[0]):
            d, _, _ = distance_at(
                distance, cell, x + c * discs[i, 0] - s * discs[i, 1],
                y + s * discs[i, 0] + c * discs[i, 1],
            )  # fmt: skip
            body = min(body, d - disc_radius - hard)
    return min(least, body) if body >= 0.0 else body - 1e3


@njit(cache=True)
def pair_slack(path_a, size_a, path_b, size_b, hard, centres):
    """Least slack of footprint gap and centre distance over poses of the same times; m."""
    least = np.inf
    body = np.inf
    for t in range(path_a.shape[0]):
        away = math.hypot(path_a[t, 0] - path_b[t, 0], path_a[t, 1] - path_b[t, 1])
        least = min(least, away - centres)
        if away < size_a[0] + size_a[1] + size_b[0] + size_b[1] + hard:
            gap = rectangle_gap(path_a[t], size_a[0], size_a[1], path_b[t], size_b[0], size_b[1])[0]
            body = min(body, gap - hard)
    return min(least, body) if body >= 0.0 else body - 1e3


@njit(cache=True)
def certify(poses, velocities, commands, rank, frozen, flees, limits, period, substeps, steps,
            sizes, movers, mover_speeds, discs, disc_radius, keep, hard, distance,
            cell):  # fmt: skip
    """Commands after which every robot can still stop without touching anything.

    Each robot's candidates, from the wanted command down to a stop, are rolled out for one
    period plus a full stop. A robot steps down until its way is clear, and of two that would
    come too close the later in rank steps down first. Stopping now was certified one cycle ago,
    so the procedure ends safely: no choice is worse than all stopping.

    Args:
        poses, velocities: `(N, 3)` in the map frame.
        commands: `(N, 3)` in the body frame.
        rank: `(N,)` order of precedence, 0 first.
        frozen: `(N,)` robots that are not commanded.
        flees: `(N,)` robots that get out of the way of what moves: stopping there is what hits
            them, so of that they keep clear by going on.
        limits: Of the robots' motion, see `robots.motion`.
        period, substeps, steps: Cycle, its division and the number of rolled-out steps.
        hard: Least gaps: footprint to obstacles, footprint to footprint, centre to centre (m);
            the last between robots that are both commanded.

    Returns:
        `(N, 3)` commands in the body frame and `(N,)` the levels taken.
    """
    n = poses.shape[0]
    paths = np.empty((n, LEVELS, steps, 3))
    options = np.zeros((n, LEVELS, 3))
    slack = np.empty((n, LEVELS))
    level = np.zeros(n, np.int64)
    for i in range(n):
        if frozen[i]:
            level[i] = LEVELS - 1
        for k in range(3):  # written out: assigning whole rows costs seconds of compilation
            options[i, 0, k] = commands[i, k]
            options[i, 1, k] = 0.5 * commands[i, k]
            if k < 2:
                options[i, 2, k] = commands[i, k]
            else:
                options[i, 3, k] = commands[i, k]
        for k in range(LEVELS):
            roll_out(poses[i], velocities[i], options[i, k], limits, period, substeps, substeps,
                     paths[i, k])  # fmt: skip
            ahead = paths[i, k]
            if flees[i] and movers.shape[0] > 0:
                ahead = np.empty((steps, 3))
                roll_out(poses[i], velocities[i], options[i, k], limits, period, substeps, steps,
                         ahead)  # fmt: skip
            slack[i, k] = map_slack(paths[i, k], discs, disc_radius, keep[i], hard[0], distance,
                                    cell)  # fmt: skip
            for j in range(movers.shape[0]):
                other = np.empty((steps, 3))
                for t in range(steps):
                    time = (t + 1) * period / substeps
                    other[t, 0] = movers[j, 0] + time * mover_speeds[j, 0]
                    other[t, 1] = movers[j, 1] + time * mover_speeds[j, 1]
                    other[t, 2] = movers[j, 2]
                slack[i, k] = min(
                    slack[i, k],
                    pair_slack(ahead, sizes[i], other, movers[j, 3:5], hard[1], 0.0),
                )
        while level[i] < LEVELS - 1 and slack[i, level[i]] < min(0.0, slack[i, LEVELS - 1]):
            level[i] += 1
    last = LEVELS - 1
    near = np.zeros((n, n), np.bool_)
    stopped = np.zeros((n, n))
    centres = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1, n):
            away = math.hypot(poses[i, 0] - poses[j, 0], poses[i, 1] - poses[j, 1])
            reach = math.hypot(sizes[i, 0], sizes[i, 1]) + math.hypot(sizes[j, 0], sizes[j, 1])
            near[i, j] = away < reach + 1.3
            near[j, i] = near[i, j]
            if not (frozen[i] or frozen[j]):  # else only footprints matter
                centres[i, j] = hard[2]
                centres[j, i] = hard[2]
            if near[i, j]:
                stopped[i, j] = min(0.0, pair_slack(
                    paths[i, last], sizes[i], paths[j, last], sizes[j], hard[1], centres[i, j]
                ))  # fmt: skip
                stopped[j, i] = stopped[i, j]
    changed = True
    while changed:
        changed = False
        for i in range(n):
            for j in range(i + 1, n):
                if not near[i, j] or (level[i] == last and level[j] == last):
                    continue
                now = pair_slack(paths[i, level[i]], sizes[i], paths[j, level[j]], sizes[j],
                                 hard[1], centres[i, j])  # fmt: skip
                if now >= stopped[i, j]:
                    continue
                k = j if rank[j] > rank[i] else i
                if level[k] == last:
                    k = i + j - k
                level[k] += 1
                while level[k] < last and slack[k, level[k]] < min(0.0, slack[k, last]):
                    level[k] += 1
                changed = True
    # A robot may have stepped down for one that stopped in the end: step up again, first in
    # rank first, as far as the others' ways allow now.
    for r in range(n):
        i = 0
        for k in range(n):
            if rank[k] == r:
                i = k
        if frozen[i]:
            continue
        for k in range(level[i]):
            if slack[i, k] < min(0.0, slack[i, last]):
                continue
            clear = True
            for j in range(n):
                if j != i and near[i, j]:
                    now = pair_slack(paths[i, k], sizes[i], paths[j, level[j]], sizes[j], hard[1],
                                     centres[i, j])  # fmt: skip
                    if now < stopped[i, j]:
                        clear = False
                        break
            if clear:
                level[i] = k
                break
    out = np.empty((n, 3))
    for i in range(n):
        for a in range(3):
            out[i, a] = options[i, level[i], a]
    return out, level


@njit(cache=True)
def to_body(velocities, yaw, max_x, max_y, max_w):
    """Map-frame velocities `(N, 3)` as body-frame commands inside the velocity ellipse."""
    out = np.empty_like(velocities)
    for k in range(velocities.shape[0]):
        c, s = math.cos(yaw[k]), math.sin(yaw[k])
        vx = c * velocities[k, 0] + s * velocities[k, 1]
        vy = -s * velocities[k, 0] + c * velocities[k, 1]
        scale = ellipse_scale(vx, vy, max_x, max_y)
        out[k, 0], out[k, 1] = vx * scale, vy * scale
        out[k, 2] = min(max(velocities[k, 2], -max_w), max_w)
    return out
