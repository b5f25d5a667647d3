"""CONNECT: walking from one state to another along a cubic.

Primitives are laid out as `parameters` says; a state `(6,)` is position and velocity.
"""

from __future__ import annotations

import math

from cavalcade.geometry import GRAVITY
from cavalcade.geometry.trajectory import WALK
from cavalcade.kernels import subroutine
from cavalcade.kernels.copying import copy_to
from cavalcade.kinodynamic._validity import (
    STILL,
    carried,
    covered_slack,
    solid_free,
    solid_slack,
    state_problem,
)
from cavalcade.kinodynamic.parameters import (
    CONNECT,
    END,
    GROUND,
    KIND,
    MOTION,
    OK,
    SOLID,
    START,
    TIME,
)
from cavalcade.lattice.surface import surface

_SHORTEST = 1e-3
"""Least duration, s."""

_STRETCHES, _STRETCH = 5, 1.3
"""How often, and by which factor, a walk is slowed down until the forces are within limits."""


@subroutine
def nominal_time(s0, s1, v_nom):
    """Duration of CONNECT between states: T = 6 |dp| / (|v0 + v1| + 4 v_nom)."""
    dx, dy, dz = s1[0] - s0[0], s1[1] - s0[1], s1[2] - s0[2]
    vx, vy, vz = s0[3] + s1[3], s0[4] + s1[4], s0[5] + s1[5]
    way = math.sqrt(dx * dx + dy * dy + dz * dz)
    return 6.0 * way / (math.sqrt(vx * vx + vy * vy + vz * vz) + 4.0 * v_nom)


@subroutine
def cubic(p0, v0, p1, v1, span):
    """Coefficients of t² and t³ of the Hermite cubic that starts with p0 + v0 t."""
    dp = (p1 - p0) / span
    return (3.0 * dp - 2.0 * v0 - v1) / span, (v0 + v1 - 2.0 * dp) / (span * span)


@subroutine
def _planar_cubics(walk):
    """Coefficients of t² and t³ of a CONNECT: those of x and those of y."""
    s0, s1, span = walk[START : START + 6], walk[END : END + 6], walk[TIME]
    a2, a3 = cubic(s0[0], s0[3], s1[0], s1[3], span)
    b2, b3 = cubic(s0[1], s0[4], s1[1], s1[4], span)
    return a2, a3, b2, b3


@subroutine
def clearance_rate(ground, s):
    """Clearance over the smoothed ground and its rate in a state."""
    height, along_x, along_y = surface(ground, s[0], s[1])
    return s[2] - height, s[5] - along_x * s[3] - along_y * s[4]


@subroutine
def walk_state(space, walk, t, out):
    """State `(6,)` of a CONNECT at time `t` after its start, written to `out`.

    The clearance over the smoothed ground is a cubic, too; in the published planner it is linear,
    and the vertical speed is that of the smoothed ground.
    """
    ground = space.ground
    s0, s1, span = walk[START : START + 6], walk[END : END + 6], walk[TIME]
    for k in range(2):
        a2, a3 = cubic(s0[k], s0[k + 3], s1[k], s1[k + 3], span)
        out[k] = s0[k] + t * (s0[k + 3] + t * (a2 + t * a3))
        out[k + 3] = s0[k + 3] + t * (2.0 * a2 + 3.0 * t * a3)
    c0, r0 = clearance_rate(ground, s0)
    c1, r1 = clearance_rate(ground, s1)
    height, along_x, along_y = surface(ground, out[0], out[1])
    tangent = along_x * out[3] + along_y * out[4]
    if space.body.published:
        out[2] = height + c0 + (c1 - c0) * t / span
        out[5] = tangent
    else:
        a2, a3 = cubic(c0, r0, c1, r1, span)
        out[2] = height + c0 + t * (r0 + t * (a2 + t * a3))
        out[5] = tangent + r0 + t * (2.0 * a2 + 3.0 * t * a3)


@subroutine
def walk_heading(walk, last):
    """Cosine and sine of the yaw at the start or, if `last`, at the end; (0, 0) if it never moves.

    At rest that is the direction into which it sets off, or from which it has come.
    """
    s0, s1, span = walk[START : START + 6], walk[END : END + 6], walk[TIME]
    vx, vy = (s1[3], s1[4]) if last else (s0[3], s0[4])
    speed = math.sqrt(vx * vx + vy * vy)
    if speed <= STILL and span > 0.0:
        a2, a3, b2, b3 = _planar_cubics(walk)
        if last:
            vx, vy = -(2.0 * a2 + 6.0 * a3 * span), -(2.0 * b2 + 6.0 * b3 * span)
        else:
            vx, vy = 2.0 * a2, 2.0 * b2
        speed = math.sqrt(vx * vx + vy * vy)
    if speed <= 1e-12:
        return 0.0, 0.0
    return vx / speed, vy / speed


@subroutine
def forces_allowed(space, walk):
    """Whether friction and the largest ground force allow the accelerations of a CONNECT.

    They are linear in time, so their ends suffice. Horizontally |a| <= mu g and, as the legs
    lower or lift the body, |a_xy| <= mu (g + its vertical acceleration over the ground).
    """
    body = space.body
    s0, s1, span = walk[START : START + 6], walk[END : END + 6], walk[TIME]
    a2, a3, b2, b3 = _planar_cubics(walk)
    c2, c3 = 0.0, 0.0
    if not body.published:
        c0, r0 = clearance_rate(space.ground, s0)
        c1, r1 = clearance_rate(space.ground, s1)
        c2, c3 = cubic(c0, r0, c1, r1, span)
    for k in range(2):
        t = k * span
        ax = (2.0 * a2 + 6.0 * a3 * t) / GRAVITY
        ay = (2.0 * b2 + 6.0 * b3 * t) / GRAVITY
        up = 1.0 + (2.0 * c2 + 6.0 * c3 * t) / GRAVITY
        side = ax * ax + ay * ay
        if up < 0.0 or side > (body.mu * min(up, 1.0)) ** 2 + 1e-12:
            return False
        if side + up * up > body.grf_max * body.grf_max:
            return False
    return True


@subroutine
def make_walk(space, s0, s1, walk):
    """Lay a CONNECT between two states out in `walk`; whether the forces are within limits.

    Too short ones take longer than the nominal time, unless as published.
    """
    body = space.body
    walk[KIND] = CONNECT
    copy_to(walk[START:], s0)
    copy_to(walk[END:], s1)
    span = nominal_time(s0, s1, body.v_nom)
    if not body.published and s0[3] == s0[4] == s1[3] == s1[4] == 0.0:
        # The acceleration at the ends of a cubic from rest to rest is 6 x its length / span².
        length = math.hypot(s1[0] - s0[0], s1[1] - s0[1])
        span = max(span, math.sqrt(6.0 * length / (0.99 * body.mu * GRAVITY)))
    walk[TIME] = span
    if span < _SHORTEST:
        return False
    for _ in range(1 if body.published else _STRETCHES):
        if forces_allowed(space, walk):
            return True
        span *= _STRETCH
        walk[TIME] = span
    return False


@subroutine
def is_straight(walk):
    """Whether a CONNECT goes ahead along a straight line, seen from above."""
    s0, s1, span = walk[START : START + 6], walk[END : END + 6], walk[TIME]
    dx, dy = s1[0] - s0[0], s1[1] - s0[1]
    way = math.sqrt(dx * dx + dy * dy)
    if abs(s0[3] * dy - s0[4] * dx) + abs(s1[3] * dy - s1[4] * dx) > 1e-9 * way:
        return False
    before, after = s0[3] * dx + s0[4] * dy, s1[3] * dx + s1[4] * dy
    return before >= 0.0 and after >= 0.0 and 3.0 * way * way / span >= before + after


@subroutine
def fastest(walk):
    """No horizontal speed on a CONNECT is above this, m/s: the largest of its Bézier points."""
    s0, s1, span = walk[START : START + 6], walk[END : END + 6], walk[TIME]
    mx = 3.0 * (s1[0] - s0[0]) / span - s0[3] - s1[3]
    my = 3.0 * (s1[1] - s0[1]) / span - s0[4] - s1[4]
    return math.sqrt(
        max(s0[3] * s0[3] + s0[4] * s0[4], s1[3] * s1[3] + s1[4] * s1[4], mx * mx + my * my)
    )


@subroutine
def is_level(ground, walk):
    """Whether a CONNECT on flat ground keeps its height."""
    return (
        ground.flat
        and walk[START + 2] == walk[END + 2]
        and walk[START + 5] == 0.0
        and walk[END + 5] == 0.0
    )


@subroutine
def turns_too_fast(body, walk):
    """Whether the yaw rate is too large at an end of a CONNECT already."""
    if body.published or is_straight(walk):
        return False
    s0, span = walk[START : START + 6], walk[TIME]
    a2, a3, b2, b3 = _planar_cubics(walk)
    for k in range(2):
        t = k * span
        vx = s0[3] + t * (2.0 * a2 + 3.0 * t * a3)
        vy = s0[4] + t * (2.0 * b2 + 3.0 * t * b3)
        ax, ay = 2.0 * a2 + 6.0 * a3 * t, 2.0 * b2 + 6.0 * b3 * t
        square = vx * vx + vy * vy
        if square <= 1e-6:
            # From rest the direction turns half as fast as that of the acceleration.
            square = 2.0 * (ax * ax + ay * ay)
            vx, vy, ax, ay = ax, ay, 6.0 * a3, 6.0 * b3
        if abs(vx * ay - vy * ax) > body.yaw_rate * square + 1e-12:
            return True
    return False


@subroutine
def some_state_invalid(space, walk, scratch):
    """A quick look at a few places of a CONNECT, the middle first: whether one is invalid."""
    count = 8
    for stride in (4, 2, 1):
        for k in range(stride, count, 2 * stride):
            walk_state(space, walk, walk[TIME] * k / count, scratch)
            vx, vy = scratch[3], scratch[4]
            speed = math.sqrt(vx * vx + vy * vy)
            if speed <= STILL:
                continue
            if state_problem(space, scratch, vx / speed, vy / speed, WALK) != OK:
                return True
    return False


@subroutine
def walk_problem(space, walk, backwards, scratch):
    """What is wrong with a CONNECT whose forces are within limits.

    It is looked at every dt, `backwards` from its end to its start, as a tree that grows from the
    goal does; what solid ground leaves free in all directions is passed over.

    Returns:
        `OK`, `SOLID`, `GROUND` or `MOTION`, and the time from where the look began up to which
        all is well, s; negative if not even there.
    """
    body = space.body
    span = walk[TIME]
    count = max(int(math.ceil(span / body.dt - 1e-9)), 1)
    step = span / count
    cos, sin = walk_heading(walk, backwards)
    turn = math.tan(min(body.yaw_rate * step, 1.5))
    straight = is_straight(walk)
    level = is_level(space.ground, walk)
    most = max(fastest(walk), 1e-6)
    reach = math.sqrt(body.half_length * body.half_length + body.half_width * body.half_width)
    checked = 0  # solids need no look before this sample
    k = -1
    while k < count:
        k += 1
        if straight and level and k < checked:
            k = min(checked, count)
        t = span - k * step if backwards else k * step
        walk_state(space, walk, t, scratch)
        x, y, z, vx, vy = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4]
        # The yaw, which follows the velocity, and whether it turns faster than allowed.
        c, s = cos, sin
        if not straight:
            speed = math.sqrt(vx * vx + vy * vy)
            if k == count:
                c, s = walk_heading(walk, not backwards)
            elif speed > STILL:
                c, s = vx / speed, vy / speed
            if k > 0 and not body.published:
                ahead = cos * c + sin * s
                if ahead <= 0.0 or abs(cos * s - sin * c) > turn * ahead + 1e-9:
                    return MOTION, (k - 1) * step
            cos, sin = c, s
        if vx * vx + vy * vy > body.v_max * body.v_max * (1.0 + 1e-9):
            return MOTION, (k - 1) * step
        # Solids: in any yaw, else all around the footprint, else the footprint itself.
        if k >= checked:
            slack = solid_slack(space, x, y)
            pace = most
            if slack <= 0.0 and (straight or not body.published):
                slack = covered_slack(space, x, y, c, s)
                if not straight:
                    pace += reach * body.yaw_rate
            if slack > 0.0:
                checked = k + 1 + int(slack / (pace * step))
            elif not solid_free(space, x, y, c, s):
                return SOLID, (k - 1) * step
        if not (level and k > 0) and not carried(space, x, y, z, c, s, WALK):
            return GROUND, (k - 1) * step
    return OK, span
