"""How well robots did what they were told: the metrics of commanded velocities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from cavalcade.geometry import Array
from cavalcade.metrics.summary import CommandTracking, rounded
from cavalcade.recording.frames import Recording

SETTLED = 2.0
"""A velocity counts once it has been commanded for so long, s,"""

LEAST = 1.0
"""and if it goes on for so long then, s."""

_MOVING = 0.05
"""Smaller commands, m/s or rad/s, are standing still."""

_GRAIN = 1e-6
"""Smaller changes of a command are none, m/s or rad/s."""


Push = tuple[float, int]
"""When somebody was pushed, s, and who."""


def summarise_commands(recording: Recording, pushes: Sequence[Push] = ()) -> CommandTracking:
    """What `commanded` holds in `summary.json`; null where no velocity was held long enough.

    Of the stretches of a robot's way over which its commanded velocity had stood for 2 s, and
    nobody had pushed it:

    - `speed_error`: of the mean velocity in the commanded direction, in shares of the command,
    - `yaw_rate_error`: of the mean yaw rate, in the same way; of both the largest of all stretches,
    - `drift_m_s`: the largest mean velocity across the commanded direction,
    - `rms_m_s`: root of the mean square of the velocity in that direction less the command, the
      largest of all stretches: trunks sway at each step.
    """
    found: dict[str, list[float]] = {key: [] for key in CommandTracking.__dataclass_fields__}
    for wanted, velocities in stretches(recording, pushes):
        speed = float(np.hypot(*wanted[:2]))
        mean = velocities.mean(axis=0)
        if speed >= _MOVING:
            along = wanted[:2] / speed
            found["speed_error"].append(abs(float(mean[:2] @ along) / speed - 1.0))
            found["drift_m_s"].append(abs(float(along[0] * mean[1] - along[1] * mean[0])))
            off = velocities[:, :2] @ along - speed
            found["rms_m_s"].append(float(np.sqrt((off**2).mean())))
        if abs(wanted[2]) >= _MOVING:
            found["yaw_rate_error"].append(abs(float(mean[2] / wanted[2]) - 1.0))
    return CommandTracking(
        **{key: rounded(max(values, default=None)) for key, values in found.items()}
    )


def stretches(recording: Recording, pushes: Sequence[Push] = ()) -> Iterator[tuple[Array, Array]]:
    """Command `(3,)` and measured velocities `(K, 3)` of each stretch of constant commands.

    Both are of the body frame, robot after robot, without the first seconds of each stretch; a
    push begins another one.
    """
    time, poses = _motion(recording)
    if len(time) < 2:
        return
    middle = 0.5 * (time[1:] + time[:-1])
    for robot in range(poses.shape[1]):
        measured = body_velocities(time, poses[:, robot])
        said = recording.commands[:, robot]
        change = np.flatnonzero((np.abs(np.diff(said, axis=0)) > _GRAIN).any(axis=1)) + 1
        # The last cycle stops the team: its command is not the task's.
        pushed = [int(np.searchsorted(recording.time, at)) for at, who in pushes if who == robot]
        inner = sorted({*(int(k) for k in change), *pushed} - {0, len(said)})
        ends = [0, *inner, len(said) - 1]
        for first, last in pairwise(ends):
            if first >= last:
                continue
            begin, end = recording.time[first] + SETTLED, recording.time[last]
            inside = (middle >= begin) & (middle <= end)
            if end - begin >= LEAST and inside.any():
                yield said[first], measured[inside]


def body_velocities(time: Array, poses: Array) -> Array:
    """Mean velocities `(T - 1, 3)` between poses `(T, 3)`, in the frame of the body in between."""
    steps = np.diff(time)[:, None]
    yaw = np.unwrap(poses[:, 2])
    heading = 0.5 * (yaw[1:] + yaw[:-1])
    c, s = np.cos(heading), np.sin(heading)
    x, y = np.diff(poses[:, :2], axis=0).T
    turned = np.column_stack([c * x + s * y, c * y - s * x, np.diff(yaw)])
    return np.asarray(turned / steps)


def _motion(recording: Recording) -> tuple[Array, Array]:
    """The finest record of planar poses: times `(T,)` and poses `(T, N, 3)`."""
    track = recording.physics
    if track is None:
        return recording.time, recording.poses
    w, x, y, z = np.moveaxis(track.base[..., 3:], -1, 0)
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y**2 + z**2))
    return track.time, np.concatenate([track.base[..., :2], yaw[..., None]], axis=-1)
