"""Gaps between bodies over time, compiled. Metres and radians."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.geometry.distances import body_corners, body_gap


@njit(cache=True)
def nearest_gaps(poses, bodies):
    """The smallest gap of each body to any other at each time.

    Args:
        poses: `(K, N, 3)` x, y, yaw.
        bodies: `(N, 3)` length, width and `grown`, see `cavalcade.geometry.distances`.

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
                grown = bodies[a, 2] + bodies[b, 2]
                reach = grown + 0.5 * (
                    math.hypot(bodies[a, 0], bodies[a, 1]) + math.hypot(bodies[b, 0], bodies[b, 1])
                )
                # The bound says that neither minimum can change.
                if away - reach >= gaps[k, a] and away - reach >= gaps[k, b]:
                    continue
                body_corners(
                    poses[k, a, 0],
                    poses[k, a, 1],
                    poses[k, a, 2],
                    bodies[a, 0],
                    bodies[a, 1],
                    first,
                )
                body_corners(
                    poses[k, b, 0],
                    poses[k, b, 1],
                    poses[k, b, 2],
                    bodies[b, 0],
                    bodies[b, 1],
                    second,
                )
                gap = body_gap(first, second, grown)
                gaps[k, a] = min(gaps[k, a], gap)
                gaps[k, b] = min(gaps[k, b], gap)
    return gaps
