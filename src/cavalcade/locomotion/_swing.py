"""Where a swinging foot goes, and how it gets there, compiled. World frame, m, s.

`robot, gait, body, state` are rows of `ROBOT`, `GAIT`, `BODY`, `STATE`, `footing` is a `Footing`.
"""

from __future__ import annotations

import math

from cavalcade.kernels import subroutine
from cavalcade.locomotion._footholds import interpolate, nearest_place

SEARCH = 0.12  # how far a foothold may be moved to ground that carries it, m
LEAST = 0.3  # least traversability of such ground
PROBES = 6  # points of a swing at which the ground below it is looked at

LEANING, RISING = 0.6, 0.9
"""A calf leans backwards from its foot: so far, in lengths of it, and it rises by so much per m."""

SHIFT, SHIFTS = 0.03, 3
"""A foothold is moved along the heading to give the calf room, by so many m up to so often."""


@subroutine
def to_ground(frame, x, y):
    """A place of the world in the frame of the ground's grid (`frame`: its x, y, yaw)."""
    dx, dy = x - frame[0], y - frame[1]
    c, s = math.cos(frame[2]), math.sin(frame[2])
    return c * dx + s * dy, c * dy - s * dx


@subroutine
def ground_height(footing, x, y):
    """Height of the ground at a place of the world, m."""
    if footing.flat:
        return 0.0
    u, v = to_ground(footing.frame, x, y)
    return interpolate(u, v, footing.cell, footing.height)


@subroutine
def choose_foothold(robot, gait, body, state, leg, left, footing):
    """Put `state.landing` of a leg where the foot is to stand next.

    Below the place where the shoulder will be in the middle of the coming stance (Raibert), moved
    by the error of the velocity to catch the body, away from edges behind that the calf would
    meet, then to ground that carries it. It lands in `left` s.
    """
    # Where the shoulder will be, at the heading of then.
    stance = gait.duty * gait.period
    turn = state.velocity[2]
    yaw = body.angles[2] + turn * left
    c, s = math.cos(yaw), math.sin(yaw)
    wanted_x = c * state.velocity[0] - s * state.velocity[1]
    wanted_y = s * state.velocity[0] + c * state.velocity[1]
    vx, vy = body.velocity[0], body.velocity[1]
    c, s = math.cos(yaw + 0.5 * turn * stance), math.sin(yaw + 0.5 * turn * stance)
    ahead, aside = robot.hip[leg, 0], robot.hip[leg, 1] + robot.side[leg]
    x = body.trunk[0] + vx * left + c * ahead - s * aside
    y = body.trunk[1] + vy * left + s * ahead + c * aside
    x += 0.5 * stance * vx + gait.capture * (vx - wanted_x)
    y += 0.5 * stance * vy + gait.capture * (vy - wanted_y)
    if not footing.flat:
        for trial in range(2 * SHIFTS + 1):
            # 0, 1, -1, 2, -2, ... steps along the heading.
            shift = SHIFT * ((trial + 1) // 2) * (1 if trial % 2 else -1)
            there_x, there_y = x + shift * c, y + shift * s
            if shank_clears(robot, footing, there_x, there_y, c, s):
                x, y = there_x, there_y
                break
    place_foot(robot, gait, state, leg, x, y, footing)


@subroutine
def shank_clears(robot, footing, x, y, c, s):
    """Whether the ground behind a foot at (x, y) leaves room for its calf, which leans backwards.

    `c` and `s` are cosine and sine of the heading.
    """
    foot = ground_height(footing, x, y)
    for probe in range(1, PROBES + 1):
        back = probe * LEANING * robot.calf / PROBES
        rise = ground_height(footing, x - back * c, y - back * s) - foot
        if rise > max(back * RISING - robot.foot_radius, 0.25 * robot.foot_radius):
            return False
    return True


@subroutine
def place_foot(robot, gait, state, leg, x, y, footing):
    """Let a leg's swing end at (x, y) or at the nearest place that carries it."""
    start = state.lifted[leg]
    z = highest = 0.0
    if not footing.flat:
        frame = footing.frame
        u, v = to_ground(frame, x, y)
        a, b, found = nearest_place(u, v, footing, LEAST, SEARCH)
        if found:
            c, s = math.cos(frame[2]), math.sin(frame[2])
            x, y = frame[0] + c * a - s * b, frame[1] + s * a + c * b
        z = ground_height(footing, x, y)
        # The foot swings over the highest ground between here and there.
        highest = z
        for probe in range(PROBES):
            t = (probe + 0.5) / PROBES
            under_x, under_y = start[0] + t * (x - start[0]), start[1] + t * (y - start[1])
            highest = max(highest, ground_height(footing, under_x, under_y))
    landing = state.landing[leg]
    landing[0], landing[1], landing[2] = x, y, z + robot.foot_radius
    state.apex[leg] = max(start[2], landing[2], highest + robot.foot_radius) + gait.clearance


@subroutine
def smooth(t):
    """From 0 to 1 without a jump of speed or acceleration, and the derivative."""
    return t * t * t * (10.0 - 15.0 * t + 6.0 * t * t), 30.0 * t * t * (1.0 - t) ** 2


@subroutine
def swing_point(lifted, landing, apex, t, lasts, place, velocity):
    """A foot's place and velocity at the share `t` of its swing, which `lasts` s; overwritten."""
    share, rate = smooth(t)
    for a in range(2):
        place[a] = lifted[a] + share * (landing[a] - lifted[a])
        velocity[a] = rate * (landing[a] - lifted[a]) / lasts
    if t < 0.5:
        share, rate = smooth(2.0 * t)
        low, high = lifted[2], apex
    else:
        share, rate = smooth(2.0 * t - 1.0)
        low, high = apex, landing[2]
    place[2] = low + share * (high - low)
    velocity[2] = 2.0 * rate * (high - low) / lasts
