"""Gaps between bodies over time, compiled. Metres and radians."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.geometry.boxes import boxes_gap


@njit(cache=True)
def nearest_gaps(poses, bodies):
    """The smallest gap of each body to any other at each time.

    Args:
        poses: `(K, N, 3)` x, y, yaw.
        bodies: `(N, 3)` length, width and inflation, see `cavalcade.geometry.boxes`.

    Returns:
        `(K, N)` m, inf for a body that is alone.
    """
    count, robots = poses.shape[0], poses.shape[1]
    gaps = np.full((count, robots), np.inf)
    first, second = np.empty((4, 2)), np.empty((4, 2))
    for k in range(count):
        for a in range(robots):
            for b in range(a):
                away = math.hypot(poses[k, a, 0] - poses[k, b, 0], poses[k, a, 1] - poses[k, b, 1])
                reach = bodies[a, 2] + bodies[b, 2]
                reach += 0.5 * (
                    math.hypot(bodies[a, 0], bodies[a, 1]) + math.hypot(bodies[b, 0], bodies[b, 1])
                )
                # The bound says that neither minimum can change.
                if away - reach >= gaps[k, a] and away - reach >= gaps[k, b]:
                    continue
                gap = boxes_gap(poses[k, a], poses[k, b], bodies[a], bodies[b], first, second)
                gaps[k, a] = min(gaps[k, a], gap)
                gaps[k, b] = min(gaps[k, b], gap)
    return gaps
