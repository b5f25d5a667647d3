"""Evasive manoeuvres, rolled out with the motion model and judged. Compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cavalcade.formation._clearance import (
    DistanceMap,
    ObstacleBoxes,
    distance_at,
    point_rectangle,
    rectangle,
    rectangle_gap,
)
from cavalcade.kernels import kernel, subroutine
from cavalcade.robots.motion import MotionLimits, advance

STEP = 0.1
"""s between the poses of a manoeuvre."""
SEEN = 0.3
"""m: larger gaps are as good as this one."""
_GAIN = 3.0  # 1/s, of a body that turns its longer axis into its direction of motion
_EPS = 1e-6
_FINEST = 1.0 / 32.0  # of a step, to which it is known when a gap becomes too small


class Manoeuvres(NamedTuple):
    """Candidates: every direction for every duration, then a stop.

    Attributes:
        directions: `(C, 2)` of unit length.
        turning: `(C,)` whether the body turns its longer axis into the direction.
        durations: `(D,)` numbers of steps, rising.
    """

    directions: np.ndarray
    turning: np.ndarray
    durations: np.ndarray


class Drive(NamedTuple):
    """How robots move: their motion limits, and the speed to command, m/s."""

    limits: MotionLimits
    speed: float


class Gaps(NamedTuple):
    """Gaps to keep, m; where one is smaller at first, that is kept instead.

    Attributes:
        obstacle: Footprint to what stands.
        footprint, centres: Between robots: of footprints and of centres.
        box: Footprint to what moves.
        aimed: The same, aimed at.
        clearance: Of the centre from what stands, aimed at in the end.
    """

    obstacle: float
    footprint: float
    centres: float
    box: float
    aimed: float
    clearance: float = 0.0


@kernel
def turn_rate(yaw, dx, dy, most):
    """Yaw rate that turns a body's longer axis, front or rear, into a direction, rad/s."""
    turn = math.atan2(dy, dx) - yaw
    turn = (turn + 0.5 * math.pi) % math.pi - 0.5 * math.pi
    return min(max(_GAIN * turn, -most), most)


@kernel
def roll_out_manoeuvre(pose, velocity, direction, turning, moving, drive, out):
    """States `(T, 6)` of a robot that goes in a direction for some steps and then stops.

    Args:
        pose, velocity: `(3,)` each, in the map frame.
        direction: `(2,)` of unit length.
        turning: Whether the body turns into it.
        moving: Number of steps.
        drive: The robot's.
        out: The states; the first is the present one.
    """
    x, y, yaw = pose[0], pose[1], pose[2]
    vx, vy, wz = velocity[0], velocity[1], velocity[2]
    dx, dy, top, limits = direction[0], direction[1], drive.speed, drive.limits
    for t in range(out.shape[0]):
        out[t, 0], out[t, 1], out[t, 2] = x, y, yaw
        out[t, 3], out[t, 4], out[t, 5] = vx, vy, wz
        cx, cy, cw = 0.0, 0.0, 0.0
        if t < moving:
            c, s = math.cos(yaw), math.sin(yaw)
            cx, cy = top * (c * dx + s * dy), top * (c * dy - s * dx)
            cw = turn_rate(yaw, dx, dy, limits.max_yaw_rate) if turning else 0.0
        x, y, yaw, vx, vy, wz = advance((x, y, yaw, vx, vy, wz), (cx, cy, cw), STEP, limits)


@subroutine
def map_gap(pose, footprint, map, boxes):
    """Gap of a body to what stands, m, up to `SEEN`; the map may show what moves as well."""
    discs = footprint.discs
    x, y = pose[0], pose[1]
    least = SEEN
    # Where the centre alone shows that the whole body is clear, no disc is looked at.
    middle, _, _ = distance_at(map, x, y)
    if middle >= footprint.radius + math.hypot(discs[0, 0], discs[0, 1]) + SEEN:
        return least
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(discs.shape[0]):
        px, py = x + c * discs[i, 0] - s * discs[i, 1], y + s * discs[i, 0] + c * discs[i, 1]
        d, _, _ = distance_at(map, px, py)
        if d - footprint.radius >= least:
            continue
        moves = False
        for j in range(boxes.poses.shape[0]):
            away, _, _ = point_rectangle(px, py, rectangle(boxes.poses[j], boxes.half[j]))
            if away <= max(d, 0.0) + 2.0 * map.cell:
                moves = True  # what is nearest is the picture of this one, drawn a little late
        if not moves:
            least = d - footprint.radius
    return least


@subroutine
def box_gap(pose, half, boxes, time):
    """Gap of a body to the dynamic obstacles at a time in s: m, up to `SEEN`."""
    least = SEEN
    at = np.empty(3)
    for j in range(boxes.poses.shape[0]):
        at[0] = boxes.poses[j, 0] + time * boxes.velocities[j, 0]
        at[1] = boxes.poses[j, 1] + time * boxes.velocities[j, 1]
        at[2] = boxes.poses[j, 2]
        size = boxes.half[j]
        reach = math.hypot(half[0], half[1]) + math.hypot(size[0], size[1]) + least
        if math.hypot(pose[0] - at[0], pose[1] - at[1]) < reach:
            gap = rectangle_gap(rectangle(pose, half), rectangle(at, size))
            least = min(least, gap.distance)
    return least


@subroutine
def meets(before, after, half, boxes, t, gaps):
    """When a body on its way to step `t` comes nearer to a dynamic obstacle than it may.

    By conservative advancement: until it has gone by the gap that is left, it cannot be there.
    A corner that passes a corner between two poses is nearer there than at both.

    Args:
        before, after: Poses `(3,)` of the body one step before and at step `t`.
        half: Of the body.
        boxes: The dynamic obstacles.
        t: The step.
        gaps: At both poses, and the one to keep, m.

    Returns:
        The fraction of the step gone by then, found to within `_FINEST`; inf for never.
    """
    first, last, least = gaps
    dx, dy, turn = after[0] - before[0], after[1] - before[1], after[2] - before[2]
    travel = 0.0
    for j in range(boxes.poses.shape[0]):
        vx, vy = boxes.velocities[j, 0], boxes.velocities[j, 1]
        travel = max(travel, math.hypot(dx - STEP * vx, dy - STEP * vy))
    travel = max(travel + math.hypot(half[0], half[1]) * abs(turn), _EPS)
    part, end = (first - least) / travel, 1.0 - max(last - least, 0.0) / travel
    at = np.empty(3)
    while part < end:
        part = max(part, _FINEST)
        at[0], at[1], at[2] = before[0] + part * dx, before[1] + part * dy, before[2] + part * turn
        gap = box_gap(at, half, boxes, (t - 1 + part) * STEP)
        if gap < least:
            return part
        part += max((gap - least) / travel, _FINEST)
    return 1.0 if last < least else np.inf


@subroutine
def barred(pose, half, others, t, gaps, first):
    """Whether one of the others `(K, T, 3)` is too near at step `t`, and nearer than at first.

    `first` `(2, K)` holds the gaps of footprints and the distances of centres at first, m.
    """
    for k in range(others.shape[0]):
        away = math.hypot(pose[0] - others[k, t, 0], pose[1] - others[k, t, 1])
        if away < min(gaps.centres, first[1, k] - _EPS):
            return True
        if away < 2.0 * math.hypot(half[0], half[1]) + gaps.footprint:
            gap = rectangle_gap(rectangle(pose, half), rectangle(others[k, t], half))
            if gap.distance < min(gaps.footprint, first[0, k] - _EPS):
                return True
    return False


@kernel
def judge_manoeuvres(pose, velocity, candidates, drive, footprint, surroundings, others, gaps):
    """What comes of each candidate.

    Args:
        pose, velocity: `(3,)` each of the robot, in the map frame.
        candidates: The `Manoeuvres`.
        drive: The robot's.
        footprint: The robots'.
        surroundings: Map and dynamic obstacles.
        others: `(K, T, 3)` the robots that do not give way, at each step.
        gaps: To keep.

    Returns:
        `(C, D)` when the robot is hit, s (inf for never, -1 where it is barred before its end),
        and how far gap and clearance stay behind those aimed at, m.
    """
    half, durations = footprint.half, candidates.durations
    never, steps = np.inf, others.shape[1]
    grid = DistanceMap(surroundings.distances, surroundings.cell)
    boxes = ObstacleBoxes(surroundings.poses, surroundings.half, surroundings.velocities)
    hits = np.full((len(candidates.directions), len(durations)), -1.0)
    short = np.zeros((len(candidates.directions), len(durations)))
    # No gap can be asked for that is larger than the present one.
    first = np.empty((2, others.shape[0]))
    for k in range(others.shape[0]):
        gap = rectangle_gap(rectangle(pose, half), rectangle(others[k, 0], half))
        first[0, k] = gap.distance
        first[1, k] = math.hypot(pose[0] - others[k, 0, 0], pose[1] - others[k, 0, 1])
    stands = min(gaps.obstacle, map_gap(pose, footprint, grid, boxes) - _EPS)
    to_box = box_gap(pose, half, boxes, 0.0)
    least, aimed = min(gaps.box, to_box - _EPS), min(gaps.aimed, to_box)
    states = np.empty((steps, 6))
    for c in range(len(candidates.directions)):
        known = 0  # steps that are judged: the beginning is common to all durations
        hit, behind, gap_then = never, 0.0, to_box
        for d in range(len(durations)):
            moving = durations[d]
            roll_out_manoeuvre(
                pose, velocity, candidates.directions[c], candidates.turning[c], moving, drive,
                states,
            )  # fmt: skip
            here_hit, here_behind, closed = hit, behind, False
            gap_before = gap_then
            for t in range(known, steps):
                at = states[t, :3]
                still = t > moving and math.hypot(states[t, 3], states[t, 4]) < 0.01
                if not still:
                    closed = map_gap(at, footprint, grid, boxes) < stands
                if not closed and t > 0:
                    closed = barred(at, half, others, t, gaps, first)
                if closed:
                    break
                gap_now = box_gap(at, half, boxes, t * STEP)
                here_behind = max(here_behind, aimed - gap_now)
                if t > 0:
                    before, near = states[t - 1, :3], (gap_before, gap_now, least)
                    here_hit = min(never, (t - 1 + meets(before, at, half, boxes, t, near)) * STEP)
                gap_before = gap_now
                if t <= moving:
                    known, hit, behind, gap_then = t + 1, here_hit, here_behind, gap_now
                if here_hit < never:
                    break
            if closed:
                if known <= moving:
                    break  # longer durations are barred, too
                continue
            hits[c, d] = here_hit
            clear, _, _ = distance_at(grid, states[-1, 0], states[-1, 1])
            short[c, d] = here_behind + max(0.0, gaps.clearance - clear)
            if hit < never:
                break
    return hits, short
