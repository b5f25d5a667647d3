"""Where each foot stands: below its hip over the stance, on ground that carries it.

The wanted place is the hip's mean position over the stance, moved by the capture point's
sqrt(h / g) times how much faster the body is at touch-down than over the stance (Raibert's rule
with a planned motion in the place of a commanded one), then the nearest traversable cell; where a
leg cannot reach that, the one which it reaches best.
"""

from __future__ import annotations

import math

import numpy as np

from cavalcade.geometry import GRAVITY, Array, inverse_transform_points, transform_points
from cavalcade.geometry.trajectory import FLIGHT, LANDING, TAKE_OFF, Trajectory
from cavalcade.lattice.ground import Ground
from cavalcade.locomotion import _footholds as kernels
from cavalcade.locomotion.gait import stances
from cavalcade.locomotion.records import Footing
from cavalcade.robots import RobotModel
from cavalcade.robots.model import LegModel

FARTHEST = 0.25
"""How far a foot may be put from the wanted place to find ground that carries it, m."""

LEAST_TRAVERSABILITY = 0.3
"""Least traversability of ground that carries a foot, 0 to 1."""

_STRETCHED = 1.2
"""A stretched leg as a multiple of the reach that bodies are planned with: thigh and shank of Go1
measure 0.43 m together, of Spirit 0.41 m; plans count on 0.375 m."""

_REST = 1.0
"""How long a robot is taken to stand before its start and after its end, s."""

_SAMPLES = 17
Pose = tuple[float, float, float]


def plan_footholds(
    trajectory: Trajectory,
    model: RobotModel,
    ground: Ground,
    origin: Pose = (0.0, 0.0, 0.0),
) -> Array:
    """The footholds of a whole trajectory.

    Args:
        trajectory: Of the body's centre, in the map frame.
        model: The robot; one without legs has no footholds.
        ground: What carries feet.
        origin: Pose (x m, y m, yaw rad) of the ground's frame in the map frame.

    Returns:
        `(M, 6)` t_down, t_up (s), leg (0 front left, 1 front right, 2 rear left, 3 rear right),
        x, y, z (m, map frame), sorted by t_down and leg. The last foothold of each leg is kept
        for good; its t_up is the trajectory's end.
    """
    if model.legs is None:
        return np.zeros((0, 6))
    legs = model.legs
    times = stances(trajectory, legs)
    wanted = inverse_transform_points(origin, _wanted(trajectory, legs, times))
    footing = Footing.of(ground, origin)
    places = kernels.place_feet(
        np.ascontiguousarray(wanted), footing, LEAST_TRAVERSABILITY, FARTHEST
    )
    feet = np.column_stack([times[:, 2], places])
    hips = _hips(trajectory, legs, ground, origin)
    hips[..., :2] = inverse_transform_points(origin, hips[..., :2].reshape(-1, 2)).reshape(-1, 4, 2)
    standing = _standing(trajectory, hips, times, feet)
    kernels.bring_in_reach(standing, longest_leg(legs), footing, LEAST_TRAVERSABILITY, FARTHEST)
    feet[:, 1:3] = transform_points(origin, feet[:, 1:3])
    return np.column_stack([times[:, :2], feet])


def leg_lengths(
    footholds: Array,
    trajectory: Trajectory,
    model: RobotModel,
    ground: Ground,
    origin: Pose = (0.0, 0.0, 0.0),
) -> Array:
    """How far each leg must stretch: the longest distance of its hip from the standing foot.

    Hips are at the height of the body's centre, pitched as the smoothed ground is along the
    heading. During take-off the front legs may hang, during landing the rear ones: then they
    reach for nothing. Compare with `longest_leg`.

    Returns:
        `(M,)` m.
    """
    if model.legs is None or not len(footholds):
        return np.zeros(0)
    hips = _hips(trajectory, model.legs, ground, origin)
    feet = np.ascontiguousarray(footholds[:, 2:])
    return np.asarray(kernels.leg_lengths(_standing(trajectory, hips, footholds, feet)))


def longest_leg(legs: LegModel) -> float:
    """The length of a leg that is stretched, m."""
    return _STRETCHED * legs.h_max


def _standing(trajectory: Trajectory, hips: Array, times: Array, feet: Array) -> kernels.Stances:
    """What kernels take: `feet` themselves, and their times from the first columns of `times`."""
    down, up = np.ascontiguousarray(times[:, 0]), np.ascontiguousarray(times[:, 1])
    time = np.ascontiguousarray(trajectory.time)
    # Front legs reach for nothing during take-off, rear ones during landing.
    needed = np.repeat((trajectory.phase != FLIGHT)[:, None], 4, axis=1)
    needed[trajectory.phase == TAKE_OFF, :2] = False
    needed[trajectory.phase == LANDING, 2:] = False
    return kernels.Stances(time, hips, needed, down, up, feet)


def _wanted(trajectory: Trajectory, legs: LegModel, times: Array) -> Array:
    """Wanted places `(M, 2)` before the ground is looked at, map frame, m."""
    down, up, leg = times[:, 0], times[:, 1], times[:, 2].astype(int)
    # At both ends the robot stands for longer than the plan says.
    down = np.where(down <= 0.0, down - _REST, down)
    up = np.where(up >= trajectory.duration - 1e-9, up + _REST, up)
    moments = down[:, None] + (up - down)[:, None] * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    poses = trajectory.poses_at(moments.ravel()).reshape(len(times), _SAMPLES, 3)
    offset = _offsets(legs)[leg]
    c, s = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x = poses[..., 0] + c * offset[:, None, 0] - s * offset[:, None, 1]
    y = poses[..., 1] + s * offset[:, None, 0] + c * offset[:, None, 1]
    below = np.column_stack([x.mean(axis=1), y.mean(axis=1)])
    ends = trajectory.poses_at(np.concatenate([down, up])).reshape(2, len(times), 3)
    mean = (ends[1] - ends[0])[:, :2] / np.maximum(up - down, 1e-9)[:, None]
    at_touch = np.column_stack(
        [
            np.interp(times[:, 0], trajectory.time, trajectory.velocity[:, axis], left=0.0)
            for axis in (0, 1)
        ]
    )
    # A foot that stood or that is to stand for long has nothing to catch.
    short = ((up - down) < 2.0 * legs.gait_period)[:, None]
    return np.asarray(
        below + np.where(short, math.sqrt(legs.h_nom / GRAVITY) * (at_touch - mean), 0.0)
    )


def _hips(trajectory: Trajectory, legs: LegModel, ground: Ground, origin: Pose) -> Array:
    """Where hips are, `(T, 4, 3)` in the map frame, m; legs in their order."""
    c, s = np.cos(trajectory.yaw)[:, None], np.sin(trajectory.yaw)[:, None]
    offset = _offsets(legs)
    hips = np.empty((len(trajectory.time), 4, 3))
    hips[..., 0] = trajectory.position[:, :1] + c * offset[:, 0] - s * offset[:, 1]
    hips[..., 1] = trajectory.position[:, 1:2] + s * offset[:, 0] + c * offset[:, 1]
    hips[..., 2] = trajectory.position[:, 2:]
    if not ground.flat:
        local = inverse_transform_points(origin, trajectory.position[:, :2])
        heading = trajectory.yaw - origin[2]
        slope = np.array(
            [
                math.cos(yaw) * kernels.interpolate(x, y, ground.cell, ground.slope_x)
                + math.sin(yaw) * kernels.interpolate(x, y, ground.cell, ground.slope_y)
                for (x, y), yaw in zip(local, heading, strict=True)
            ]
        )
        hips[..., 2] += slope[:, None] * offset[:, 0]
    return hips


def _offsets(legs: LegModel) -> Array:
    """`(4, 2)` hips in the body frame, in the order of the legs."""
    signs = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])
    return signs * (legs.hip_x, legs.hip_y)
