"""A timed body trajectory of one robot: what a body planner returns and everything else reads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.values import number_array

WALK, TAKE_OFF, FLIGHT, LANDING = 0, 1, 2, 3
"""Phases, as `plan.npz` numbers them."""

_MOST = 1e9
"""Largest number in a trajectory, SI units."""

STEP = 0.03
"""Largest time between two samples, s (the paper's dt)."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Samples of a body's motion; the robot stands at its last pose for good afterwards.

    Positions are of the body's centre in the frame of the planner's ground or, where it says so,
    the map. Between samples the motion is the cubic that both ends' velocities give.

    Attributes:
        time: `(T,)` s, increasing, from 0, at most `STEP` apart; ends of phases are samples.
        position: `(T, 3)` m.
        velocity: `(T, 3)` m/s.
        yaw: `(T,)` rad, continuous (not wrapped).
        phase: `(T,)` `WALK`, `TAKE_OFF`, `FLIGHT` or `LANDING`: of the motion from this sample
            to the next.

    Raises:
        InputError: Arrays that do not fit together, or are not finite.
    """

    time: Array
    position: Array
    velocity: Array
    yaw: Array
    phase: NDArray[np.int8]

    def __post_init__(self) -> None:
        count = len(number_array(self.time, "time", (None,), "times (T,) in s", _MOST))
        shapes = {"time": (count,), "position": (count, 3), "velocity": (count, 3), "yaw": (count,)}
        for name, shape in shapes.items():
            # Plans have thousands of samples: what is an array of floats is not copied.
            value = getattr(self, name)
            if type(value) is not np.ndarray or value.dtype != float or value.shape != shape:
                value = number_array(value, name, shape, f"an array {shape}", _MOST)
                object.__setattr__(self, name, value)
            elif not (np.abs(value) <= _MOST).all():
                raise InputError("expected finite numbers", key=name)
        phase = number_array(self.phase, "phase", (count,), f"{count} phases", LANDING)
        if count == 0 or phase.min() < WALK or (np.diff(self.time) < 0.0).any():
            raise InputError(
                "expected samples in the order of time, and phases from 0 to 3", key="time"
            )
        object.__setattr__(self, "phase", np.asarray(self.phase, dtype=np.int8))

    @property
    def duration(self) -> float:
        """Until the robot is at its goal for good, s."""
        return float(self.time[-1])

    @property
    def length(self) -> float:
        """Of the path of the body's centre in space, m."""
        steps = np.diff(self.position, axis=0)
        return float(np.sqrt((steps * steps).sum(axis=1)).sum())

    def poses_at(self, times: Array) -> Array:
        """Poses `(K, 3)` x, y, yaw at times `(K,)` s; before the start and after the end it stands.

        Linear between samples: within 1 mm at walking speeds.
        """
        times = number_array(times, "times", (None,), "times (K,) in s", _MOST)
        poses = np.empty((len(times), 3))
        for k, column in enumerate((self.position[:, 0], self.position[:, 1], self.yaw)):
            poses[:, k] = np.interp(times, self.time, column)
        return poses


def common_clock(trajectories: Sequence[Trajectory], step: float = STEP) -> Array:
    """Times `(K,)` from 0 to the moment when all are parked, that one included, s."""
    end = max((trajectory.duration for trajectory in trajectories), default=0.0)
    times = np.arange(0.0, end, step)
    return np.append(times[times < end - 1e-9], end)


def team_poses(trajectories: Sequence[Trajectory], times: Array) -> Array:
    """Poses `(K, N, 3)` x, y, yaw at times `(K,)`; who has arrived stands at its goal."""
    return np.stack([trajectory.poses_at(times) for trajectory in trajectories], axis=1)
