"""Gaps between bodies over time, compiled. Metres and radians."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cavalcade.running._kernels import body_corners, polygons_gap


@njit(cache=True)
def nearest_gaps(poses, sizes, rounds):
    """The smallest gap of each body to any other at each time.

    Args:
        poses: `(K, N, 3)` x, y, yaw.
        sizes: `(N, 2)` length and width.
        rounds: `(N,)` radius of those that are discs, else 0.

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
                reach = 0.5 * (
                    math.hypot(sizes[a, 0], sizes[a, 1]) + math.hypot(sizes[b, 0], sizes[b, 1])
                )
                # The bound says that neither minimum can change.
                if away - reach >= gaps[k, a] and away - reach >= gaps[k, b]:
                    continue
                # A disc is the rectangle without extent that is grown by its radius.
                la, wa = (0.0, 0.0) if rounds[a] > 0.0 else (sizes[a, 0], sizes[a, 1])
                lb, wb = (0.0, 0.0) if rounds[b] > 0.0 else (sizes[b, 0], sizes[b, 1])
                body_corners(poses[k, a, 0], poses[k, a, 1], poses[k, a, 2], la, wa, first)
                body_corners(poses[k, b, 0], poses[k, b, 1], poses[k, b, 2], lb, wb, second)
                gap = max(polygons_gap(first, second) - rounds[a] - rounds[b], 0.0)
                gaps[k, a] = min(gaps[k, a], gap)
                gaps[k, b] = min(gaps[k, b], gap)
    return gaps
