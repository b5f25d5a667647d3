"""Kernels of moves: what a robot that walks, turns and stands does between two poses.

A plan in the plane is a start pose and rows (M, 6) of moves: length (m along the heading, negative
backwards), turn (rad), v0, v1 (m/s at its ends, not signed), vmax (m/s) and duration (s).

- length and turn: an arc, with the turn spread evenly over the length;
- length only: a straight line;
- turn only: on the spot, from rest to rest;
- neither: standing still for the duration.

Speed along a line or arc is the trapezoid from v0 over at most vmax to v1.

A robot's `limits` are `cavalcade.lattice.motion_limits.MotionLimits`.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.kernels import kernel, subroutine

LENGTH, TURN, V0, V1, VMAX, DURATION = range(6)
"""Columns of a table of moves."""


@kernel
def trapezoid(length, v0, v1, vmax, acceleration):
    """Duration and largest speed of the quickest motion over `length` >= 0; -1, 0 without one."""
    peak = math.sqrt(max(0.5 * (2.0 * acceleration * length + v0 * v0 + v1 * v1), 0.0))
    if peak < max(v0, v1) - 1e-9:
        return -1.0, 0.0
    peak = min(max(peak, max(v0, v1)), max(vmax, max(v0, v1)))
    if peak <= 1e-12:
        return 0.0, 0.0
    ramps = (2.0 * peak * peak - v0 * v0 - v1 * v1) / (2.0 * acceleration)
    cruise = max(length - ramps, 0.0) / peak
    return (2.0 * peak - v0 - v1) / acceleration + cruise, peak


@subroutine
def along(duration, v0, v1, peak, acceleration, t):
    """Distance gone and speed at time `t` of a trapezoid."""
    up = (peak - v0) / acceleration
    down = (peak - v1) / acceleration
    if t <= up:
        return v0 * t + 0.5 * acceleration * t * t, v0 + acceleration * t
    gone = 0.5 * (v0 + peak) * up
    cruise = duration - up - down
    if t <= up + cruise:
        return gone + peak * (t - up), peak
    late = min(t, duration) - up - cruise
    gone += peak * cruise
    return gone + peak * late - 0.5 * acceleration * late * late, peak - acceleration * late


@subroutine
def advanced(x, y, yaw, length, turn):
    """The pose after `length` along the heading while turning by `turn` evenly."""
    if abs(turn) < 1e-9 or length == 0.0:
        return x + length * math.cos(yaw), y + length * math.sin(yaw), yaw + turn
    radius = length / turn
    end = yaw + turn
    return (
        x + radius * (math.sin(end) - math.sin(yaw)),
        y - radius * (math.cos(end) - math.cos(yaw)),
        end,
    )


@kernel
def make_move(move, length, turn, v0, v1, vmax, limits):
    """Fill in a row; False if the ends' speeds don't fit into the length."""
    move[LENGTH], move[TURN], move[V0], move[V1], move[VMAX] = length, turn, v0, v1, vmax
    if length == 0.0:
        if limits.free:
            move[DURATION] = 0.0
        else:
            move[DURATION], _ = trapezoid(
                abs(turn), 0.0, 0.0, limits.yaw_rate, limits.yaw_acceleration
            )
        return True
    move[DURATION], _ = trapezoid(abs(length), v0, v1, vmax, limits.acceleration)
    return move[DURATION] >= 0.0


@subroutine
def duration_of(moves):
    """How long moves `(M, 6)` take one after another, s."""
    duration = 0.0
    for k in range(len(moves)):
        duration += moves[k, DURATION]
    return duration


@subroutine
def within(x, y, yaw, move, limits, t):
    """Pose, speed along the heading (signed) and yaw rate at time `t` of a move from a pose."""
    length, turn = move[LENGTH], move[TURN]
    if length == 0.0:
        if turn == 0.0:
            return x, y, yaw, 0.0, 0.0
        if move[DURATION] <= 0.0:
            return x, y, yaw + turn, 0.0, 0.0
        duration, peak = trapezoid(abs(turn), 0.0, 0.0, limits.yaw_rate, limits.yaw_acceleration)
        angle, rate = along(duration, 0.0, 0.0, peak, limits.yaw_acceleration, t)
        sign = 1.0 if turn > 0.0 else -1.0
        return x, y, yaw + sign * angle, 0.0, sign * rate
    duration, peak = trapezoid(abs(length), move[V0], move[V1], move[VMAX], limits.acceleration)
    gone, speed = along(duration, move[V0], move[V1], peak, limits.acceleration, t)
    sign = 1.0 if length > 0.0 else -1.0
    share = gone / abs(length)
    px, py, pyaw = advanced(x, y, yaw, sign * gone, turn * share)
    return px, py, pyaw, sign * speed, turn / abs(length) * speed


@kernel
def sample_moves(start, moves, limits, times):
    """Motion `(K, 6)` x, y, yaw, vx, vy, yaw rate at increasing times `(K,)`.

    Before 0 and after the end the robot stands.
    """
    out = np.empty((len(times), 6))
    x, y, yaw = start[0], start[1], start[2]
    begin = 0.0
    at = 0
    for k in range(len(times)):
        t = times[k]
        while at < len(moves) and t > begin + moves[at, DURATION]:
            x, y, yaw = advanced(x, y, yaw, moves[at, LENGTH], moves[at, TURN])
            begin += moves[at, DURATION]
            at += 1
        if at < len(moves) and t >= begin:
            px, py, pyaw, speed, rate = within(x, y, yaw, moves[at], limits, t - begin)
        else:
            px, py, pyaw, speed, rate = x, y, yaw, 0.0, 0.0
        out[k, 0], out[k, 1], out[k, 2] = px, py, pyaw
        out[k, 3], out[k, 4] = speed * math.cos(pyaw), speed * math.sin(pyaw)
        out[k, 5] = rate
    return out


@subroutine
def poses_between(start, moves):
    """Poses `(M + 1, 3)` at the ends of the moves."""
    out = np.empty((len(moves) + 1, 3))
    x, y, yaw = start[0], start[1], start[2]
    out[0, 0], out[0, 1], out[0, 2] = x, y, yaw
    for k in range(len(moves)):
        x, y, yaw = advanced(x, y, yaw, moves[k, LENGTH], moves[k, TURN])
        out[k + 1, 0], out[k + 1, 1], out[k + 1, 2] = x, y, yaw
    return out
