"""Kernel that tells when a robot on a track first meets others."""

from __future__ import annotations

import math

from numba import njit

from cavalcade.lattice.collision import place_free


@njit(cache=True)
def first_meeting(others, track, dt, delay, mover, margin, step):
    """The first time at which a robot on a track is nearer than `margin` to others; -1 if never.

    Args:
        others: See `_moves_contact`.
        track: `(K, 3)` poses every `dt` s, begun after `delay` s at its first pose.
        dt, delay: s.
        mover: Of the robot.
        margin: m.
        step: Time between looks, s.
    """
    tracks, other_dt, _, spans = others
    if spans.shape[0] == 0:
        return -1.0
    last = len(track) - 1
    end = max((tracks.shape[1] - 1) * other_dt, delay + last * dt)
    count = int(math.ceil(end / step)) + 1
    for k in range(count + 1):
        t = k * step if k < count else end + 1e6
        at = min(max((t - delay) / dt, 0.0), float(last))
        i = min(int(at), max(last - 1, 0))
        f = at - i
        j = min(i + 1, last)
        x = track[i, 0] + f * (track[j, 0] - track[i, 0])
        y = track[i, 1] + f * (track[j, 1] - track[i, 1])
        yaw = track[i, 2] + f * (track[j, 2] - track[i, 2])
        if not place_free(others, x, y, yaw, mover, t, margin):
            return t
    return -1.0
