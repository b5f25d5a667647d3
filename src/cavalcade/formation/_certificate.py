"""The safety filter's second stage: commands after which every robot can still stop. Compiled."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.formation._clearance import (
    DistanceMap,
    ObstacleBoxes,
    distance_at,
    rectangle,
    rectangle_gap,
)
from cavalcade.formation._least_change import NEAR, least_change, to_body
from cavalcade.kernels import kernel, subroutine
from cavalcade.robots.motion import advance

LEVELS = 5
"""Candidates per robot: filtered command, half of it, without its turn, its turn alone, stop."""
STOP = LEVELS - 1


@subroutine
def roll_out(pose, velocity, command, horizon, held, out):
    """Poses `(T, 3)` while the command is held for some steps and then a stop is commanded."""
    state = (pose[0], pose[1], pose[2], velocity[0], velocity[1], velocity[2])
    going, stop = (command[0], command[1], command[2]), (0.0, 0.0, 0.0)
    dt = horizon.period / horizon.substeps
    for t in range(out.shape[0]):
        state = advance(state, going if t < held else stop, dt, horizon.limits)
        out[t, 0], out[t, 1], out[t, 2] = state[0], state[1], state[2]


@subroutine
def map_slack(path, footprint, keep, gap, map):
    """Least slack over poses `(T, 3)`: clearance of discs and centre beyond what is needed, m.

    Where the centre alone shows that the whole body is clear, its discs are not looked at: such
    a pose counts with the clearance of the circle around them. Poses without the `gap` to
    obstacles count as worse than all others.
    """
    discs = footprint.discs
    around = 0.0
    for i in range(discs.shape[0]):
        around = max(around, math.hypot(discs[i, 0], discs[i, 1]))
    around += footprint.radius + gap
    least = np.inf
    body = np.inf
    for t in range(path.shape[0]):
        x, y, yaw = path[t, 0], path[t, 1], path[t, 2]
        middle, _, _ = distance_at(map, x, y)
        if keep > 0.0:
            least = min(least, middle - keep)
        if middle >= around:
            body = min(body, middle - around)
            continue
        c, s = math.cos(yaw), math.sin(yaw)
        for i in range(discs.shape[0]):
            dx, dy = discs[i, 0], discs[i, 1]
            d, _, _ = distance_at(map, x + c * dx - s * dy, y + s * dx + c * dy)
            body = min(body, d - footprint.radius - gap)
    return min(least, body) if body >= 0.0 else body - 1e3


@subroutine
def pair_slack(path_a, half_a, path_b, half_b, gap, centres):
    """Least slack over poses of the same times: footprints beyond `gap`, centres beyond theirs, m.

    Footprints nearer than the gap count as worse than all centres.
    """
    least = np.inf
    body = np.inf
    for t in range(path_a.shape[0]):
        away = math.hypot(path_a[t, 0] - path_b[t, 0], path_a[t, 1] - path_b[t, 1])
        least = min(least, away - centres)
        if away < half_a[0] + half_a[1] + half_b[0] + half_b[1] + gap:
            between = rectangle_gap(rectangle(path_a[t], half_a), rectangle(path_b[t], half_b))
            body = min(body, between.distance - gap)
    return min(least, body) if body >= 0.0 else body - 1e3


@subroutine
def box_paths(boxes, horizon):
    """Poses `(M, T, 3)` of dynamic obstacles that go on as they do now."""
    paths = np.empty((boxes.poses.shape[0], horizon.steps, 3))
    for j in range(paths.shape[0]):
        for t in range(horizon.steps):
            time = (t + 1) * horizon.period / horizon.substeps
            paths[j, t, 0] = boxes.poses[j, 0] + time * boxes.velocities[j, 0]
            paths[j, t, 1] = boxes.poses[j, 1] + time * boxes.velocities[j, 1]
            paths[j, t, 2] = boxes.poses[j, 2]
    return paths


@subroutine
def step_down(level, slack):
    """The first level from `level` on with slack of 0, or no less than a stop has, `(LEVELS,)`."""
    while level < STOP and slack[level] < min(0.0, slack[STOP]):
        level += 1
    return level


@kernel
def safe_commands(team, weights, surroundings, parameters):
    """Both stages: commands after which every robot can still stop without touching anything.

    Each robot's candidates, from what `least_change` makes of the wanted command down to a stop,
    are rolled out for one period plus a full stop. A robot steps down until its path is clear,
    and of two that would come too close the later in rank steps down first. Stopping now was
    certified one cycle ago, so the procedure ends safely: no choice is worse than all stopping.

    Args:
        team: A `TeamState`.
        weights: `(N,)` as in `least_change`.
        surroundings: Map and dynamic obstacles.
        parameters: The `FilterParameters`.

    Returns:
        `(N, 3)` commands in the body frame and `(N,)` the levels taken.
    """
    footprint, gaps, horizon = parameters.footprint, parameters.insisted, parameters.horizon
    n, half, rank, frozen = team.poses.shape[0], footprint.half, team.rank, team.frozen
    grid = DistanceMap(surroundings.distances, surroundings.cell)
    boxes = ObstacleBoxes(surroundings.poses, surroundings.half, surroundings.velocities)
    u = least_change(team, weights, surroundings, parameters)
    commands = to_body(u, team.poses[:, 2], horizon.limits)
    paths = np.empty((n, LEVELS, horizon.steps, 3))
    options = np.zeros((n, LEVELS, 3))
    slack = np.empty((n, LEVELS))
    level = np.zeros(n, np.int64)
    others = box_paths(boxes, horizon)
    # Roll out every robot's candidates and see how clear of all but the team they are.
    for i in range(n):
        if frozen[i]:
            level[i] = STOP
            commands[i, 0], commands[i, 1], commands[i, 2] = 0.0, 0.0, 0.0
        for k in range(3):  # written out: assigning whole rows costs seconds of compilation
            options[i, 0, k] = commands[i, k]
            options[i, 1, k] = 0.5 * commands[i, k]
            if k < 2:
                options[i, 2, k] = commands[i, k]
            else:
                options[i, 3, k] = commands[i, k]
        for k in range(LEVELS):
            pose, velocity, option = team.poses[i], team.velocities[i], options[i, k]
            roll_out(pose, velocity, option, horizon, horizon.substeps, paths[i, k])
            ahead = paths[i, k]
            if team.evading[i] and boxes.poses.shape[0] > 0:
                ahead = np.empty((horizon.steps, 3))
                roll_out(pose, velocity, option, horizon, horizon.steps, ahead)
            keep = team.clearances[i]
            slack[i, k] = map_slack(paths[i, k], footprint, keep, gaps.obstacle, grid)
            for j in range(others.shape[0]):
                free = pair_slack(ahead, half, others[j], boxes.half[j], gaps.footprint, 0.0)
                slack[i, k] = min(slack[i, k], free)
        level[i] = step_down(level[i], slack[i])
    # What each near pair would have if both stopped is all that can be asked of it.
    near = np.zeros((n, n), np.bool_)
    stopped = np.zeros((n, n))
    centres = np.zeros((n, n))
    around = math.hypot(half[0], half[1])
    for i in range(n):
        for j in range(i + 1, n):
            away = math.hypot(
                team.poses[i, 0] - team.poses[j, 0], team.poses[i, 1] - team.poses[j, 1]
            )
            near[i, j] = away < around + around + NEAR
            near[j, i] = near[i, j]
            if not (frozen[i] or frozen[j]):  # else only footprints matter
                centres[i, j] = gaps.centres
                centres[j, i] = gaps.centres
            if near[i, j]:
                now = pair_slack(
                    paths[i, STOP], half, paths[j, STOP], half, gaps.footprint, centres[i, j]
                )
                stopped[i, j] = min(0.0, now)
                stopped[j, i] = stopped[i, j]
    # Until no pair is worse than stopped: the later in rank steps down, then the other one.
    changed = True
    while changed:
        changed = False
        for i in range(n):
            for j in range(i + 1, n):
                if not near[i, j] or (level[i] == STOP and level[j] == STOP):
                    continue
                now = pair_slack(
                    paths[i, level[i]], half, paths[j, level[j]], half, gaps.footprint,
                    centres[i, j],
                )  # fmt: skip
                if now >= stopped[i, j]:
                    continue
                k = j if rank[j] > rank[i] else i
                if level[k] == STOP:
                    k = i + j - k
                level[k] = step_down(level[k] + 1, slack[k])
                changed = True
    # A robot may have stepped down for one that stopped in the end: step up again, first in
    # rank first, as far as the others' paths allow now.
    for r in range(n):
        i = 0
        for k in range(n):
            if rank[k] == r:
                i = k
        if frozen[i]:
            continue
        for k in range(level[i]):
            if slack[i, k] < min(0.0, slack[i, STOP]):
                continue
            clear = True
            for j in range(n):
                if j != i and near[i, j]:
                    now = pair_slack(
                        paths[i, k], half, paths[j, level[j]], half, gaps.footprint, centres[i, j]
                    )
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
