"""Springs, obstacle avoidance and speed limits (Norén et al., eqs. 3-9). Compiled."""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import kernel, subroutine

SPRING = np.dtype(
    [(name, float) for name in ("rest", "k_rep", "k_att", "dv_max_att", "b_att", "b_rep")]
)
"""One connection of a shape: its rest length in m, and its `SpringLaw`."""


@kernel
def add_springs(velocity, points, pairs, springs, previous, period):
    """Add springs and dampers to the velocities (Norén et al., eqs. 3-5).

    Args:
        velocity: `(N, 2)` m/s, changed in place.
        points: `(N, 2)` m.
        pairs: `(C, 2)` robots joined by each connection, -1 where a slot is empty.
        springs: `(C,)` of type `SPRING`.
        previous: `(C,)` lengths one cycle ago, nan where other robots were joined then.
        period: Seconds per cycle.

    Returns:
        `(C,)` lengths now, m.
    """
    count = pairs.shape[0]
    length = np.full(count, np.nan)
    for k in range(count):
        a, b = pairs[k, 0], pairs[k, 1]
        if a < 0 or b < 0:
            continue
        dx, dy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
        apart = math.hypot(dx, dy)
        length[k] = apart
        if apart < 1e-9:
            continue
        spring = springs[k]
        stretch = apart - spring.rest
        if stretch < 0.0:
            force = -spring.k_rep * stretch * stretch
        else:
            force = min(spring.k_att * stretch * stretch, spring.dv_max_att)
        if not math.isnan(previous[k]):
            rate = (apart - previous[k]) / period
            force += (spring.b_att if rate < 0.0 else spring.b_rep) * rate
        ux, uy = dx / apart * force, dy / apart * force
        velocity[a, 0] += ux
        velocity[a, 1] += uy
        velocity[b, 0] -= ux
        velocity[b, 1] -= uy
    return length


@subroutine
def sobel(speed, row, col):
    """Gradient (du, dv) of the velocity map at a cell, per cell, by the Sobel operator.

    Normalised so that a plain slope of s per cell gives s. Beyond the map the speed is 0.
    """
    gu, gv = 0.0, 0.0
    rows, cols = speed.shape
    for dr in range(-1, 2):
        for dc in range(-1, 2):
            r, c = row + dr, col + dc
            if r < 0 or c < 0 or r >= rows or c >= cols:
                continue
            gu += dc * (2.0 - abs(dr)) * speed[r, c]
            gv += dr * (2.0 - abs(dc)) * speed[r, c]
    return gu / 8.0, gv / 8.0


@kernel
def avoid_obstacles(velocity, points, speed, cell, safe, w_min):
    """Remove motion towards near obstacles (Norén et al., Algorithm 1).

    Args:
        velocity: `(N, 2)` m/s, changed in place.
        points: `(N, 2)` m from the corner of cell [0, 0].
        speed: `(rows, cols)` the paper's W_B.
        cell, safe: Cell size and d_safe_b, m.
        w_min: The paper's W_min,avoid.
    """
    rows, cols = speed.shape
    for k in range(points.shape[0]):
        row, col = int(math.floor(points[k, 1] / cell)), int(math.floor(points[k, 0] / cell))
        if row < 0 or col < 0 or row >= rows or col >= cols:
            continue
        w = speed[row, col]
        if w >= 1.0:
            continue
        gu, gv = sobel(speed, row, col)
        dot = gu * velocity[k, 0] + gv * velocity[k, 1]
        square = gu * gu + gv * gv
        if dot >= 0.0 or math.sqrt(square) <= 0.5 * cell / safe:
            continue  # moving away, or on a ridge where no single direction leads out
        alpha = min(max((1.0 - w) / (1.0 - w_min), 0.0), 1.0)
        velocity[k, 0] -= alpha * dot / square * gu
        velocity[k, 1] -= alpha * dot / square * gv


@kernel
def limit_speeds(velocity, yaw, w, to_goal, limits):
    """Limit speeds, directions kept (Norén et al., eqs. 7-9).

    Args:
        velocity: `(N, 2)` m/s, map frame, changed in place.
        yaw: `(N,)` headings, rad.
        w: `(N,)` W_B at the robots.
        to_goal: `(N,)` distances to the robots' own goals, m; inf switches that limit off.
        limits: (v_max_x, v_max_y, v_min, d_slowdown), m/s and m.
    """
    v_x, v_y, v_min, slowdown = limits
    for k in range(velocity.shape[0]):
        vx, vy = velocity[k, 0], velocity[k, 1]
        speed = math.hypot(vx, vy)
        if speed < 1e-12:
            continue
        theta = math.atan2(vy, vx) - yaw[k]
        ellipse = v_x * v_y / math.hypot(math.sin(theta) * v_x, math.cos(theta) * v_y)
        top = min(ellipse, v_min + w[k] * (v_x - v_min))
        top = min(top, to_goal[k] / slowdown * v_x)
        if speed > top:
            velocity[k, 0] = vx * top / speed
            velocity[k, 1] = vy * top / speed
