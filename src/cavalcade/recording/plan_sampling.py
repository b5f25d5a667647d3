"""A team plan on one clock, as pictures and distances need it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.recording.frames import Recording

STEP = 0.03
"""Between two common samples, s."""


def common_clock(trajectories: Sequence[Trajectory], step: float = STEP) -> Array:
    """Times `(K,)` from 0 to the moment when all are parked, that one included."""
    end = max((trajectory.duration for trajectory in trajectories), default=0.0)
    times = np.arange(0.0, end, step)
    return np.append(times[times < end - 1e-9], end)


def team_poses(trajectories: Sequence[Trajectory], times: Array) -> Array:
    """Poses `(K, N, 3)` x, y, yaw at times `(K,)`; who has arrived stands at its goal."""
    return np.stack([trajectory.poses_at(times) for trajectory in trajectories], axis=1)


def as_recording(trajectories: Sequence[Trajectory]) -> Recording:
    """The plan as if it had been carried out to the letter; without commands and status.

    Its times are those of all samples of all robots, so that nothing is left out in between.
    """
    times = np.unique(np.concatenate([trajectory.time for trajectory in trajectories]))
    poses = team_poses(trajectories, times)
    return Recording(
        time=times,
        poses=poses,
        estimated=poses,
        commands=np.zeros_like(poses),
        status=(),
        obstacles=(),
        notes=(),
    )
