"""Ways out of the path of moving obstacles, rolled out with the motion model. Compiled."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.formation._bodies import distance_at, point_rectangle, rectangle_gap
from cavalcade.robots.motion import advance

STEP = 0.1
"""s between the poses of a way."""
SEEN = 0.3
"""m: larger gaps are as good as this one."""
_GAIN = 3.0  # 1/s, of a body that turns its longer axis into its way
_EPS = 1e-6


@njit(cache=True)
def turn_rate(yaw, dx, dy, most):
    """Yaw rate that turns a body's longer axis, front or rear, into a direction; rad/s."""
    turn = math.atan2(dy, dx) - yaw
    turn = (turn + 0.5 * math.pi) % math.pi - 0.5 * math.pi
    return min(max(_GAIN * turn, -most), most)


@njit(cache=True)
def roll(pose, velocity, dx, dy, turning, top, moving, limits, out):
    """States `(T, 6)` of a robot that goes one way for `moving` steps and then stops.

    Args:
        pose, velocity: `(3,)` each, in the map frame.
        dx, dy: The way's unit direction.
        turning: Whether the body turns into it.
        top: Speed to command, m/s.
        moving: Number of steps.
        limits: Of the robot's motion, see `robots.motion`.
        out: The states; the first is the present one.
    """
    x, y, yaw = pose[0], pose[1], pose[2]
    vx, vy, wz = velocity[0], velocity[1], velocity[2]
    for t in range(out.shape[0]):
        out[t, 0], out[t, 1], out[t, 2] = x, y, yaw
        out[t, 3], out[t, 4], out[t, 5] = vx, vy, wz
        cx, cy, cw = 0.0, 0.0, 0.0
        if t < moving:
            c, s = math.cos(yaw), math.sin(yaw)
            cx, cy = top * (c * dx + s * dy), top * (c * dy - s * dx)
            cw = turn_rate(yaw, dx, dy, limits.max_yaw_rate) if turning else 0.0
        x, y, yaw, vx, vy, wz = advance((x, y, yaw, vx, vy, wz), (cx, cy, cw), STEP, limits)


@njit(cache=True)
def ground_gap(x, y, yaw, discs, disc_radius, movers, distance, cell):
    """Gap of a body to what stands, m, up to `SEEN`; the map may show what moves as well."""
    least = SEEN
    c, s = math.cos(yaw), math.sin(yaw)
    for i in range(-1, discs.shape[0]):
        px, py = x, y
        if i >= 0:
            px, py = x + c * discs[i, 0] - s * discs[i, 1], y + s * discs[i, 0] + c * discs[i, 1]
        d, _, _ = distance_at(distance, cell, px, py)
        if i < 0:
            # Where the centre alone shows that the whole body is clear, no disc is looked at.
            reach = disc_radius + math.hypot(discs[0, 0], discs[0, 1])
            if d >= reach + SEEN:
                return least
            continue
        if d - disc_radius >= least:
            continue
        moves = False
        for j in range(movers.shape[0]):
            away, _, _ = point_rectangle(
                px, py, movers[j, 0], movers[j, 1], math.cos(movers[j, 2]),
                math.sin(movers[j, 2]), movers[j, 3], movers[j, 4],
            )  # fmt: skip
            if away <= max(d, 0.0) + 2.0 * cell:
                moves = True  # what is nearest is the picture of this one, drawn a little late
        if not moves:
            least = d - disc_radius
    return least


@njit(cache=True)
def mover_gap(pose, half, movers, speeds, time):
    """Gap of a body to what moves, at a time; m, up to `SEEN`."""
    least = SEEN
    at = np.empty(3)
    for j in range(movers.shape[0]):
        at[0], at[1] = movers[j, 0] + time * speeds[j, 0], movers[j, 1] + time * speeds[j, 1]
        at[2] = movers[j, 2]
        reach = math.hypot(half[0], half[1]) + math.hypot(movers[j, 3], movers[j, 4]) + least
        if math.hypot(pose[0] - at[0], pose[1] - at[1]) < reach:
            gap = rectangle_gap(pose, half[0], half[1], at, movers[j, 3], movers[j, 4])[0]
            least = min(least, gap)
    return least


@njit(cache=True)
def barred(pose, half, others, t, hard, centres, first, first_centres):
    """Whether one of the others `(K, T, 3)` is too near at step `t`, and nearer than at first."""
    for k in range(others.shape[0]):
        away = math.hypot(pose[0] - others[k, t, 0], pose[1] - others[k, t, 1])
        if away < min(centres, first_centres[k] - _EPS):
            return True
        if away < 2.0 * math.hypot(half[0], half[1]) + hard:
            gap = rectangle_gap(pose, half[0], half[1], others[k, t], half[0], half[1])[0]
            if gap < min(hard, first[k] - _EPS):
                return True
    return False


@njit(cache=True)
def judge_ways(pose, velocity, ways, turning, durations, top, limits, half, movers, speeds,
               others, discs, disc_radius, gaps, radius, distance, cell, steps):  # fmt: skip
    """What comes of going each way for each of some times and then standing.

    Args:
        pose, velocity: `(3,)` each, in the map frame.
        ways: `(C, 2)` unit directions.
        turning: `(C,)` whether the body turns into them.
        durations: `(D,)` numbers of steps, rising.
        top: Speed to command, m/s.
        limits: Of the robot's motion, see `robots.motion`.
        half: `(2,)` half length and half width, m.
        movers, speeds: `(M, 5)` and `(M, 2)` what moves, and how.
        others: `(K, T, 3)` the robots that do not give way, at each step.
        discs, disc_radius: Cover of a footprint, m.
        gaps: To keep to what stands, to robots, between their centres and to what moves, and
            the one to what moves that is aimed at; m. None is larger than at first.
        radius: Clearance of the centre that is aimed at in the end, m.
        distance, cell: Distance map and its cell size, m.
        steps: T.

    Returns:
        `(C, D)` when the robot is hit, s (inf for never, -1 where the way is barred before its
        end), and how far gap and clearance stay behind those aimed at, m.
    """
    never = np.inf
    hits = np.full((len(ways), len(durations)), -1.0)
    short = np.zeros((len(ways), len(durations)))
    first = np.empty(others.shape[0])
    first_centres = np.empty(others.shape[0])
    for k in range(others.shape[0]):
        first_centres[k] = math.hypot(pose[0] - others[k, 0, 0], pose[1] - others[k, 0, 1])
        first[k] = rectangle_gap(pose, half[0], half[1], others[k, 0], half[0], half[1])[0]
    to_ground = ground_gap(pose[0], pose[1], pose[2], discs, disc_radius, movers, distance, cell)
    stands = min(gaps[0], to_ground - _EPS)
    to_mover = mover_gap(pose, half, movers, speeds, 0.0)
    least, aimed = min(gaps[3], to_mover - _EPS), min(gaps[4], to_mover)
    states = np.empty((steps, 6))
    for c in range(len(ways)):
        known = 0  # steps of the way that are judged: the beginning is common to all durations
        hit, behind = never, 0.0
        for d in range(len(durations)):
            moving = durations[d]
            roll(pose, velocity, ways[c, 0], ways[c, 1], turning[c], top, moving, limits, states)
            here_hit, here_behind, closed = hit, behind, False
            for t in range(known, steps):
                at = states[t, :3]
                still = t > moving and math.hypot(states[t, 3], states[t, 4]) < 0.01
                if not still:
                    closed = ground_gap(at[0], at[1], at[2], discs, disc_radius, movers,
                                             distance, cell) < stands  # fmt: skip
                if not closed and t > 0:
                    closed = barred(at, half, others, t, gaps[1], gaps[2], first,
                                         first_centres)  # fmt: skip
                if closed:
                    break
                gap = mover_gap(at, half, movers, speeds, t * STEP)
                here_behind = max(here_behind, aimed - gap)
                if gap < least:
                    here_hit = t * STEP
                if t <= moving:
                    known, hit, behind = t + 1, here_hit, here_behind
                if here_hit < never:
                    break
            if closed:
                if known <= moving:
                    break  # longer ways are barred, too
                continue
            hits[c, d] = here_hit
            clear, _, _ = distance_at(distance, cell, states[steps - 1, 0], states[steps - 1, 1])
            short[c, d] = here_behind + max(0.0, radius - clear)
            if hit < never:
                break
    return hits, short
