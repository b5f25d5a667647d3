"""Who goes first where two bodies' paths come near each other, compiled. Metres, s, radians.

A cell (a, b) of a pair (i, j) stands for i at the plan time `a dt` and j at `b dt`, each give or
take half of `dt`. Only cells with a < b are looked at, where i is to pass first; those of the
pair (j, i) are the others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.geometry.boxes import boxes_gap
from cavalcade.kernels import kernel, subroutine

NEVER = 1 << 30
"""A cell's number where there is none."""

CONCESSION = 0.01
"""Out of step, bodies may come this much closer than the plan brings them at that time, m."""


class Order(NamedTuple):
    """The first blocked cells of all pairs (i, j) and rows a, see `first_cells`.

    Attributes:
        near: `(N, N, K)` within the band.
        ahead: `(N, N, K)` the same including rows after each.
        far: `(N, N, K)` beyond the band.
        dt: Side of the cells, s.
        slack: Of this many cells two may be out of step where the plan keeps them close.
    """

    near: NDArray[np.int64]
    ahead: NDArray[np.int64]
    far: NDArray[np.int64]
    dt: float
    slack: int


class Progress(NamedTuple):
    """How far the robots have come along their trajectories.

    Attributes:
        reference: `(N,)` plan times of the references, s.
        sure: `(N,)` plan times that the bodies have reached, at most `reference`.
        caps: `(N,)` plan times that the robots may not go beyond for reasons of their own, s.
        lowest: `(N,)` rates below which robots cannot come within this cycle.
    """

    reference: Array
    sure: Array
    caps: Array
    lowest: Array


class Braking(NamedTuple):
    """How robots stop.

    Attributes:
        period: Of a cycle, s.
        deceleration: Change of a rate per s.
        trust: Whether robots in step, as the plan has them, count on each other to brake no
            harder than they do; otherwise any may stop dead.
    """

    period: float
    deceleration: float
    trust: bool


@kernel(nogil=True)
def first_cells(poses, spread, rests, bodies, margin, band):
    """The first blocked cell of each row of each pair.

    A cell is blocked where the gap of the bodies is less than `margin` and what they may move
    within the cell. Within `band` cells of the diagonal, where the plan itself may bring the two
    closer than that, only what is closer than the plan is blocked: a robot may be in front of
    its time where that leads it away from the other one, and not where it leads it nearer. Cells
    in which one of the two has stood still since the diagonal are left out: they hold nothing
    that the plan itself does not.

    Args:
        poses: `(N, K, 3)` at the centres of the cells.
        spread: `(N, K)` m, how far any point of a body is at most from where it is at the sample,
            within the sample's cell.
        rests: `(N, K)` the last sample up to which the body stands as it does at this one.
        bodies: `(N, 3)` length, width, inflation, m.
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
    # How far each robot gets, and what it may move, within any one cell at most.
    strides = np.zeros(robots)
    widest = np.zeros(robots)
    for i in range(robots):
        for k in range(count):
            widest[i] = max(widest[i], spread[i, k])
            if k:
                step = math.hypot(
                    poses[i, k, 0] - poses[i, k - 1, 0], poses[i, k, 1] - poses[i, k - 1, 1]
                )
                strides[i] = max(strides[i], step)
    # `own` are gaps that the plan itself has at a moment, computed when first asked for.
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
            # From the last row up, so that `soonest` holds for a row and all after it.
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
                        # So many cells ahead nothing can be blocked.
                        b += (
                            max(1, int((away - reach) / max(strides[j], 1e-9)))
                            if strides[j] > 1e-9
                            else count
                        )
                        continue
                    loose = spread[i, a] + spread[j, b]
                    # Near the diagonal no more is asked for than the plan keeps until then.
                    wanted = margin + loose
                    if inside:
                        while known <= b:
                            if own[known] < 0.0:
                                own[known] = boxes_gap(
                                    poses[i, known], poses[j, known], bodies[i], bodies[j], p, q
                                )
                            least = min(least, own[known])
                            known += 1
                        wanted = max(min(wanted, least - CONCESSION), loose)
                    if boxes_gap(poses[i, a], poses[j, b], bodies[i], bodies[j], p, q) < wanted:
                        if inside:
                            near[i, j, a] = b
                            b = a + band + 1
                            continue
                        soonest = b
                        break
                    b += 1
                far[i, j, a] = soonest
    return near, far


@subroutine
def cell_of(moment, dt, count):
    """The cell in which a plan time lies; one on a border counts as past it."""
    return min(max(int(math.floor(moment / dt + 0.5 + 1e-9)), 0), count - 1)


@subroutine
def pair_bound(order, i, j, sure, coming, lead):
    """The plan time that j may not go beyond because of i, by their `Order`.

    Args:
        order, i, j: The order and the two robots.
        sure: Where i is now, s.
        coming: Where i will be if it brakes at once, s.
        lead: How far j is, or will be, ahead of i at most until both stand, s.
    """
    near, dt = order.near[i, j], order.dt
    count = near.shape[0]
    now, then = cell_of(sure, dt, count), cell_of(coming, dt, count)
    bound = min(order.far[i, j, now], order.ahead[i, j, then])
    for a in range(now, then):
        # i will have left the cell by the time j gets there, if j is not too far ahead.
        if near[a] < bound and (near[a] - a - 1 + order.slack) * dt < lead - 1e-9:
            bound = near[a]
    return (bound - 0.5) * dt if bound < NEVER else math.inf


@kernel
def strict_bounds(order, sure):
    """The plan times `(N,)` that robots at `sure` `(N,)` may not pass before others move on, s."""
    ahead, far = order.ahead, order.far
    robots, count = ahead.shape[0], ahead.shape[2]
    bounds = np.full(robots, math.inf)
    for i in range(robots):
        a = cell_of(sure[i], order.dt, count)
        for j in range(robots):
            first = min(far[i, j, a], ahead[i, j, a])
            if first < NEVER:
                bounds[j] = min(bounds[j], (first - 0.5) * order.dt)
    return bounds


@subroutine
def stopping(rate, braking):
    """Plan time that passes at least, if braking begins after the next cycle, s."""
    return rate * braking.period + 0.5 * rate * rate / braking.deceleration


@kernel
def allowed_rates(order, progress, wanted, braking):
    """The largest rates with which all can still stop before they are where it is not their turn.

    Rates `(N,)` only come down from those wanted, in [0, 1], until no pair objects. The other
    arguments are an `Order`, a `Progress` and a `Braking`.
    """
    reference, sure, caps, lowest = progress
    robots = reference.shape[0]
    period, deceleration = braking.period, braking.deceleration
    rates = wanted.copy()
    for _ in range(50):
        changed = False
        for j in range(robots):
            if rates[j] <= lowest[j]:
                continue
            after = reference[j] + stopping(rates[j], braking)
            bound = caps[j]
            for i in range(robots):
                if i == j:
                    continue
                coming = sure[i]
                if braking.trust:
                    coming += stopping(rates[i], braking)
                lead = max(reference[j] - sure[i], after - coming)
                bound = min(bound, pair_bound(order, i, j, sure[i], coming, lead))
            if after <= bound + 1e-9:
                continue
            # The rate whose stopping distance is what is left.
            left = max(bound - reference[j], 0.0)
            rate = deceleration * (math.sqrt(period * period + 2.0 * left / deceleration) - period)
            rate = max(min(rate, rates[j] - 1e-6), lowest[j], 0.0)
            if rate < rates[j]:
                rates[j] = rate
                changed = True
        if not changed:
            break
    return rates
