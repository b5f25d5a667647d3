"""Plans as legs can follow them: headings without corners, and how fast each place may be passed.

Planned robots turn at once, from one bend into the next; legs take a moment. What is cut off is
only the heading's corner; the way remains, and is passed more slowly where it asks for more than
legs do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.world import Terrain

GRAIN = 0.025
"""Step of the profile, s of plan time."""

_SLOWEST = 0.15
"""No place is passed more slowly than this part of the plan's pace."""

_BELOW_X, _BELOW_Y = np.linspace(-0.3, 0.4, 8), np.linspace(-0.2, 0.2, 5)
"""Places below a body and where it steps next, in its frame, m."""


@dataclass(frozen=True)
class LegLimits:
    """What walking robots follow well.

    Attributes:
        ahead, sideways: Speeds, m/s.
        turning: rad/s.
        acceleration: Of the velocity in the body frame, m/s².
        turning_acceleration: rad/s².
        relief: Between these departures of the ground from a plane, from the lowest to the highest
            below the body, m,
        rough_ahead: the speed ahead falls from `ahead` to this, m/s.
        window: Corners of the heading are rounded over so much plan time, s: it is off by at most
            an eighth of the change of the yaw rate times this.
    """

    ahead: float = 1.0
    sideways: float = 0.35
    turning: float = 1.6
    acceleration: float = 1.0
    turning_acceleration: float = 3.0
    relief: tuple[float, float] = (0.06, 0.16)
    rough_ahead: float = 0.3
    window: float = 0.25


def rounded_headings(path: Trajectory, window: float) -> Trajectory:
    """The same with the mean heading of `window` s around each moment; less near both ends."""
    time = path.time
    if len(time) < 2:
        return path
    area = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (path.yaw[1:] + path.yaw[:-1]))])
    half = np.minimum(0.5 * window, np.minimum(time - time[0], time[-1] - time))
    low, high = (_area_at(time, path.yaw, area, time + side * half) for side in (-1.0, 1.0))
    inside = half > 1e-9
    yaw = np.where(inside, (high - low) / np.where(inside, 2.0 * half, 1.0), path.yaw)
    return replace(path, yaw=yaw)


def _area_at(time: Array, yaw: Array, area: Array, moments: Array) -> Array:
    """The integral of a piecewise linear heading up to each moment."""
    at = np.clip(np.searchsorted(time, moments, side="right") - 1, 0, len(time) - 2)
    after = moments - time[at]
    slope = (yaw[at + 1] - yaw[at]) / (time[at + 1] - time[at])
    return np.asarray(area[at] + after * (yaw[at] + 0.5 * slope * after))


def rate_profile(
    path: Trajectory, limits: LegLimits, brake: float, terrain: Terrain | None = None
) -> Array:
    """Largest rates of progress `(K,)` every `GRAIN` s of plan time that keep to the limits.

    Before a slow place the rate comes down by at most `brake` per second. The path's headings are
    rounded already.
    """
    count = int(np.ceil(path.duration / GRAIN)) + 2
    times = GRAIN * np.arange(count, dtype=float)
    around = 0.5 * max(limits.window, 2.0 * GRAIN)
    before, after = (path.poses_at(times + side * around) for side in (-1.0, 1.0))
    here = path.poses_at(times)
    speeds = _body_velocity(before, after, here, 2.0 * around)
    into = _body_velocity(before, here, 0.5 * (before + here), around)
    out = _body_velocity(here, after, 0.5 * (here + after), around)
    change = (out - into) / around
    rates = np.ones(count)
    ahead = np.full(count, limits.ahead)
    if terrain is not None:
        slow = (limits.ahead, min(limits.rough_ahead, limits.ahead))
        ahead = np.interp(relief_along(terrain, here), limits.relief, slow)
    for value, most in (
        (np.abs(speeds[:, 0]), ahead),
        (np.abs(speeds[:, 1]), limits.sideways),
        (np.abs(speeds[:, 2]), limits.turning),
    ):
        rates = np.minimum(rates, most / np.maximum(value, most))
    for value, most in (
        (np.hypot(change[:, 0], change[:, 1]), limits.acceleration),
        (np.abs(change[:, 2]), limits.turning_acceleration),
    ):
        rates = np.minimum(rates, np.sqrt(most / np.maximum(value, most)))
    rates = np.maximum(rates, _SLOWEST)
    squares = rates**2
    # Rates fall by `brake` per second, that is by brake / rate per second of plan time.
    for k in range(count - 2, -1, -1):
        squares[k] = min(squares[k], squares[k + 1] + 2.0 * brake * GRAIN)
    return np.asarray(np.sqrt(squares))


def relief_along(terrain: Terrain, poses: Array) -> Array:
    """How far the ground below bodies departs from a plane, lowest to highest, `(K,)` m."""
    x, y = (grid.ravel() for grid in np.meshgrid(_BELOW_X, _BELOW_Y))
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    points = np.stack([poses[:, :1] + c * x - s * y, poses[:, 1:2] + s * x + c * y], axis=-1)
    heights = terrain.heights_at(points.reshape(-1, 2)).reshape(len(poses), -1)
    plane = np.column_stack([np.ones_like(x), x, y])
    off = heights - heights @ (plane @ np.linalg.pinv(plane)).T
    return np.asarray(off.max(axis=1) - off.min(axis=1))


def _body_velocity(start: Array, end: Array, facing: Array, span: float) -> Array:
    """Mean velocities `(K, 3)` between poses in the frame of a third one."""
    move = (end - start) / span
    c, s = np.cos(facing[:, 2]), np.sin(facing[:, 2])
    return np.column_stack(
        [c * move[:, 0] + s * move[:, 1], c * move[:, 1] - s * move[:, 0], move[:, 2]]
    )
