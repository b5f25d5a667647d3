"""Legs in the flight of a leap, compiled: tucked, forward, down to their footholds. World, SI."""

from __future__ import annotations

import numpy as np
from numba import njit

from cavalcade.locomotion._joints import track_foot
from cavalcade.locomotion._kinematics import turned, turned_back
from cavalcade.locomotion._leap_horizon import foothold
from cavalcade.locomotion._swing import smooth
from cavalcade.locomotion.records import FLIGHT, LANDING, FootTarget

FORWARD = (0.1, 0.75)
"""Feet go forward in this part of the flight."""

UP, DOWN = 0.3, (0.6, 0.9)
"""Feet are tucked until that share of the flight, and reach down in that part of it."""

BELOW, BESIDE = 0.11, 0.12
"""Feet stay at least so far below their hips, and at most so far beside their shoulders, m."""

SINK = 0.5
"""A foot that meets no ground goes down with that speed, m/s."""


@njit(cache=True)
def flying_foot(leap, centroid, leg, t, place, rate):
    """Where a flying foot is to be at `t` s of the flight, and its velocity; `(3,)`, overwritten.

    It is tucked first, then goes forward, then down. `centroid` is the robot's `Centroid`.
    """
    lasts = leap.lasts[FLIGHT]
    goal, start = leap.foothold[leg], leap.left[leg]
    x, y = foothold(leap, leg)
    begin, end = FORWARD[0] * lasts, FORWARD[1] * lasts
    # Along the ground in one smooth motion; the foothold may still be shifted meanwhile.
    share, speed = smooth(min(max((t - begin) / (end - begin), 0.0), 1.0))
    speed /= end - begin
    place[0], place[1] = start[0] + share * (x - start[0]), start[1] + share * (y - start[1])
    rate[0], rate[1] = speed * (x - start[0]), speed * (y - start[1])
    # Heights are from the centre of centroid.
    high, down, end = UP * lasts, DOWN[0] * lasts, DOWN[1] * lasts
    low = start[2] - leap.lift[2]
    landed = goal[2] - leap.down[2] - SINK * max(t - lasts, 0.0)
    if t < high:
        share, speed = smooth(t / high)
        place[2] = low - share * (leap.tuck + low)
        rate[2] = -speed / high * (leap.tuck + low)
    else:
        share, speed = smooth(min(max((t - down) / (end - down), 0.0), 1.0))
        place[2] = -leap.tuck + share * (landed + leap.tuck)
        rate[2] = speed / (end - down) * (landed + leap.tuck)
    place[2] += centroid.centre[2]
    rate[2] += centroid.velocity[2]


@njit(cache=True)
def keep_clear(robot, body, leg, place):
    """Move a foot's goal `(3,)` to where its leg can be whichever way the trunk is turned.

    Near the hip's own axis a small motion of the foot asks for a large one of the joints.
    """
    arm, local = np.empty(3), np.empty(3)
    for a in range(3):
        arm[a] = place[a] - body.trunk[a]
    turned_back(body.matrix, arm, local)
    hip = robot.hip[leg]
    aside = hip[1] + robot.side[leg]
    local[1] = min(max(local[1], aside - BESIDE), aside + BESIDE)
    local[2] = min(local[2], hip[2] - BELOW)
    turned(body.matrix, local, arm)
    for a in range(3):
        place[a] = body.trunk[a] + arm[a]


@njit(cache=True)
def flight_torques(robot, leap, body, centroid, leg, measured, torques):
    """Torques of a leg in the air; arguments as of `step_leap`, and the robot's `Centroid`."""
    place, rate = np.empty(3), np.empty(3)
    t = measured.time - leap.began
    if leap.phase == LANDING:
        t += leap.lasts[FLIGHT]
    flying_foot(leap, centroid, leg, t, place, rate)
    keep_clear(robot, body, leg, place)
    target = FootTarget(place, rate, leap.stiffness, leap.joint_damping)
    track_foot(robot, body, leg, target, measured, torques)
