"""How an ideal holonomic robot answers a velocity command: the one model of it.

The ideal fleet moves its robots with it and the safety filter predicts with it. The checker does
not: it judges poses by finite differences.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cavalcade.errors import InputError
from cavalcade.kernels import kernel, subroutine
from cavalcade.robots.model import RobotModel, check_model


class MotionLimits(NamedTuple):
    """The motion limits of one robot, as kernels take them: those of its `RobotModel`."""

    max_speed_x: float
    max_speed_y: float
    max_yaw_rate: float
    max_acceleration: float
    max_yaw_acceleration: float


def limits_of(model: RobotModel) -> MotionLimits:
    """The motion limits that a robot model gives."""
    return MotionLimits(*(float(getattr(model, name)) for name in MotionLimits._fields))


def check_holonomic(model: RobotModel) -> None:
    """Refuse a model that does not move as `advance` says.

    Raises:
        InputError: It does not move sideways, its accelerations have no limit, or its values do
            not fit together.
    """
    check_model(model)
    if model.drive.startswith("unicycle"):
        raise InputError(
            f"robots in formation move sideways, too; {model.name} is a {model.drive}", key="model"
        )
    for name in ("max_acceleration", "max_yaw_acceleration"):
        if not math.isfinite(getattr(model, name)):
            raise InputError(
                f"robots in formation need a finite {name}; that of {model.name} has no limit",
                key="model",
            )


@subroutine
def ellipse_scale(vx, vy, max_x, max_y):
    """Factor in (0, 1] that shrinks the body velocity onto the velocity ellipse (eq. 8)."""
    radius = math.sqrt((vx / max_x) ** 2 + (vy / max_y) ** 2)
    return 1.0 if radius <= 1.0 else 1.0 / radius


@subroutine
def advance(state, command, dt, limits):
    """One time step of one robot under a held command.

    The velocity moves towards the commanded one along a straight line inside the velocity
    ellipse, as far as the acceleration limit allows. Both limits hold exactly at the step's end
    as long as `max_speed_x * max_yaw_rate <= max_acceleration`.

    Args:
        state: Tuple (x, y, yaw, vx, vy, wz): pose and velocity, both in the *map* frame, m, rad,
            m/s and rad/s.
        command: Tuple (vx, vy, wz): the commanded velocity in the *body* frame, m/s and rad/s.
        dt: Length of the step, s.
        limits: The robot's `MotionLimits`.

    Returns:
        The state at the end of the step.
    """
    x, y, yaw, vx, vy, wz = state
    cx, cy, cw = command
    max_x, max_y, max_w, max_a, max_aw = limits
    target_w = min(max(cw, -max_w), max_w)
    new_w = min(max(target_w, wz - max_aw * dt), wz + max_aw * dt)
    # Yaw and velocity change evenly over the step: the mean rate is what turns the body.
    turn = 0.5 * (wz + new_w) * dt
    new_yaw = yaw + turn

    scale = ellipse_scale(cx, cy, max_x, max_y)
    c, s = math.cos(new_yaw), math.sin(new_yaw)
    tx = scale * (c * cx - s * cy)
    ty = scale * (s * cx + c * cy)

    # The present velocity, carried along by the turn, stays in the ellipse.
    ct, st = math.cos(turn), math.sin(turn)
    rx = ct * vx - st * vy
    ry = st * vx + ct * vy
    bx, by = c * rx + s * ry, -s * rx + c * ry
    scale = ellipse_scale(bx, by, max_x, max_y)
    rx, ry = rx * scale, ry * scale

    # Largest step along rotated -> target whose change from (vx, vy) the acceleration allows.
    dx, dy = tx - rx, ty - ry
    ex, ey = rx - vx, ry - vy
    reach = max_a * dt
    a = dx * dx + dy * dy
    b = ex * dx + ey * dy
    root = b * b - a * (ex * ex + ey * ey - reach * reach)
    if a <= 1e-18:
        step = 1.0
    elif root <= 0.0:
        step = 0.0
    else:
        step = min(max((-b + math.sqrt(root)) / a, 0.0), 1.0)
    new_vx, new_vy = rx + step * dx, ry + step * dy
    return (
        x + 0.5 * (vx + new_vx) * dt,
        y + 0.5 * (vy + new_vy) * dt,
        new_yaw,
        new_vx,
        new_vy,
        new_w,
    )


@kernel
def predict_team(poses, velocities, commands, dt, steps, limits):
    """States `(N, 6)` of a team, see `advance`, after commands held for `steps` of `dt` s.

    Poses and velocities `(N, 3)` are in the map frame, commands `(N, 3)` in the body frame.
    """
    out = np.empty((poses.shape[0], 6))
    for k in range(poses.shape[0]):
        pose, velocity = poses[k], velocities[k]
        state = (pose[0], pose[1], pose[2], velocity[0], velocity[1], velocity[2])
        command = (commands[k, 0], commands[k, 1], commands[k, 2])
        for _ in range(steps):
            state = advance(state, command, dt, limits)
        for column in range(6):
            out[k, column] = state[column]
    return out
