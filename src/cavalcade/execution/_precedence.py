"""Who goes first where two bodies' ways come near each other, compiled. Metres, s, radians.

A cell (a, b) of a pair (i, j) stands for i at the plan time `a dt` and j at `b dt`, each give or
take half of `dt`. Only cells with a < b are looked at, where i is to pass first; those of the
pair (j, i) are the others.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.geometry.distances import body_corners, body_gap

NEVER = 1 << 30
"""A cell's number where there is none."""

CONCESSION = 0.01
"""Out of step, bodies may come this much closer than the plan brings them at that time, m."""


@njit(cache=True)
def pose_gap(one, other, first, second, a, b):
    """Gap of two bodies `(3,)` (length, width, grown) at poses `(3,)`; `a`, `b` `(4, 2)` are used.

    Bodies whose centres are farther apart than their radii have that distance at least.
    """
    body_corners(one[0], one[1], one[2], first[0], first[1], a)
    body_corners(other[0], other[1], other[2], second[0], second[1], b)
    return body_gap(a, b, first[2] + second[2])


@njit(cache=True)
def first_cells(poses, spread, rests, bodies, margin, band):
    """The first blocked cell of each row of each pair.

    A cell is blocked where the gap of the bodies is less than `margin` and what they may move
    within the cell. Within `band` cells of the diagonal, where the plan itself may bring the two
    closer than that, only what is closer than the plan is blocked: a robot may be in front of
    its time where that leads it away from the other one, and not where it leads it nearer. Cells
    in which one of the two has stood still since the diagonal are left out: they hold nothing
    that the plan itself does not.

    Args:
        poses: `(N, K, 3)` every `dt`.
        spread: `(N, K)` m, how far any point of a body is at most from where it is at the sample,
            within the sample's cell.
        rests: `(N, K)` the last sample up to which the body stands as it does at this one.
        bodies: `(N, 3)` length, width, grown.
        margin: m.
        band: Cells.

    Returns:
        `(N, N, K)` within the band and `(N, N, K)` beyond it, by i, j and a: the smallest b of a
        blocked cell, `NEVER` without one. Of those beyond the band rows after a are included.
    """
    robots, count = poses.shape[0], poses.shape[1]
    near = np.full((robots, robots, count), NEVER, dtype=np.int64)
    far = np.full((robots, robots, count), NEVER, dtype=np.int64)
    p, q = np.empty((4, 2)), np.empty((4, 2))
    strides = np.zeros(robots)
    widest = np.zeros(robots)
    for i in range(robots):
        for k in range(count):
            widest[i] = max(widest[i], spread[i, k])
            if k:
                way = math.hypot(
                    poses[i, k, 0] - poses[i, k - 1, 0], poses[i, k, 1] - poses[i, k - 1, 1]
                )
                strides[i] = max(strides[i], way)
    own = np.empty(count)
    for i in range(robots):
        for j in range(robots):
            if i == j:
                continue
            reach = bodies[i, 2] + bodies[j, 2] + margin + widest[i] + widest[j]
            reach += 0.5 * math.hypot(bodies[i, 0], bodies[i, 1])
            reach += 0.5 * math.hypot(bodies[j, 0], bodies[j, 1])
            for k in range(count):
                own[k] = -1.0
            soonest = NEVER
            for a in range(count - 1, -1, -1):
                least = math.inf
                b = max(a, rests[i, a], rests[j, a]) + 1
                known = a
                while b < count:
                    inside = b <= a + band
                    if not inside and b >= soonest:
                        break
                    if not inside and b < a + band + 1:
                        b = a + band + 1
                        continue
                    away = math.hypot(
                        poses[i, a, 0] - poses[j, b, 0], poses[i, a, 1] - poses[j, b, 1]
                    )
                    if away > reach:
                        b += (
                            max(1, int((away - reach) / max(strides[j], 1e-9)))
                            if strides[j] > 1e-9
                            else count
                        )
                        continue
                    loose = spread[i, a] + spread[j, b]
                    wanted = margin + loose
                    if inside:
                        while known <= b:
                            if own[known] < 0.0:
                                own[known] = pose_gap(
                                    poses[i, known], poses[j, known], bodies[i], bodies[j], p, q
                                )
                            least = min(least, own[known])
                            known += 1
                        wanted = max(min(wanted, least - CONCESSION), loose)
                    if pose_gap(poses[i, a], poses[j, b], bodies[i], bodies[j], p, q) < wanted:
                        if inside:
                            near[i, j, a] = b
                            b = a + band + 1
                            continue
                        soonest = b
                        break
                    b += 1
                far[i, j, a] = soonest
    return near, far


@njit(cache=True)
def cell_of(moment, dt, count):
    """The cell in which a plan time lies; one on a border counts as past it."""
    return min(max(int(math.floor(moment / dt + 0.5 + 1e-9)), 0), count - 1)


@njit(cache=True)
def pair_bound(near, ahead, far, dt, sure, coming, lead, slack):
    """The plan time that j may not go beyond because of i.

    Args:
        near: `(K,)` of the pair, see `first_cells`.
        ahead: `(K,)` the same including rows after it.
        far: `(K,)` of the pair.
        dt: s.
        sure: Where i is now, s.
        coming: Where i will be if it brakes at once, s.
        lead: How far j is, or will be, ahead of i at most until both stand, s.
        slack: Of this many cells two may be out of step where the plan keeps them close.
    """
    count = near.shape[0]
    now, then = cell_of(sure, dt, count), cell_of(coming, dt, count)
    bound = min(far[now], ahead[then])
    for a in range(now, then):
        # i will have left the cell by the time j gets there, if j is not too far ahead.
        if near[a] < bound and (near[a] - a - 1 + slack) * dt < lead - 1e-9:
            bound = near[a]
    return (bound - 0.5) * dt if bound < NEVER else math.inf


@njit(cache=True)
def strict_bounds(ahead, far, dt, sure):
    """`(N,)` the plan times that robots may not go beyond before others have moved on.

    Args:
        ahead, far: `(N, N, K)`, see `pair_bound`.
        dt: s.
        sure: `(N,)` where the robots are, s.
    """
    robots, count = ahead.shape[0], ahead.shape[2]
    bounds = np.full(robots, math.inf)
    for i in range(robots):
        a = cell_of(sure[i], dt, count)
        for j in range(robots):
            first = min(far[i, j, a], ahead[i, j, a])
            if first < NEVER:
                bounds[j] = min(bounds[j], (first - 0.5) * dt)
    return bounds


@njit(cache=True)
def stopping(rate, period, brake):
    """Plan time that passes at least, if braking begins after the next cycle, s."""
    return rate * period + 0.5 * rate * rate / brake


@njit(cache=True)
def allowed_rates(tables, dt, progress, sure, caps, wanted, lowest, period, brake, trust, slack):
    """The largest rates with which all can still stop before they are where it is not their turn.

    Rates only come down from those wanted, until no pair objects.

    Args:
        tables: near, ahead, far, each `(N, N, K)`, see `pair_bound`.
        dt: Of their cells, s.
        progress: `(N,)` plan times of the references, s.
        sure: `(N,)` plan times that the bodies have reached, at most `progress`.
        caps: `(N,)` plan times that the robots may not go beyond for reasons of their own, s.
        wanted: `(N,)` rates in [0, 1].
        lowest: `(N,)` rates below which robots cannot come within this cycle.
        period: Of a cycle, s.
        brake: Change of a rate per s when braking.
        trust: Whether robots in step, as the plan has them, count on each other to brake no
            harder than they do; otherwise any may stop dead.
        slack: See `pair_bound`.

    Returns:
        `(N,)` rates.
    """
    near, ahead, far = tables
    robots = progress.shape[0]
    rates = wanted.copy()
    for _ in range(50):
        changed = False
        for j in range(robots):
            if rates[j] <= lowest[j]:
                continue
            after = progress[j] + stopping(rates[j], period, brake)
            bound = caps[j]
            for i in range(robots):
                if i == j:
                    continue
                coming = sure[i]
                if trust:
                    coming += stopping(rates[i], period, brake)
                lead = max(progress[j] - sure[i], after - coming)
                bound = min(
                    bound,
                    pair_bound(
                        near[i, j], ahead[i, j], far[i, j], dt, sure[i], coming, lead, slack
                    ),
                )
            if after <= bound + 1e-9:
                continue
            room = max(bound - progress[j], 0.0)
            rate = brake * (math.sqrt(period * period + 2.0 * room / brake) - period)
            rate = max(min(rate, rates[j] - 1e-6), lowest[j], 0.0)
            if rate < rates[j]:
                rates[j] = rate
                changed = True
        if not changed:
            break
    return rates
