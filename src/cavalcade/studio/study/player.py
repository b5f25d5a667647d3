"""A recording or a plan as a source of moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.recording import Recording
from cavalcade.recording.physics_track import PhysicsTrack
from cavalcade.robots import RobotModel
from cavalcade.scenario import Obstacle
from cavalcade.studio.snapshot import Snapshot


class Player(Protocol):
    """Moments by time, in any order.

    Attributes:
        begin, end: Its first and last moment, s.
    """

    begin: float
    end: float

    def at(self, time: float) -> Snapshot:
        """The moment at `time` s; before the first and after the last one, that one."""
        ...


class RecordingPlayer:
    """A run of one cycle or more."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self.begin, self.end = float(recording.time[0]), float(recording.time[-1])
        self._obstacles = [Obstacle.model_validate(track.shape) for track in recording.obstacles]
        self._poses = recording.poses.copy()
        self._poses[..., 2] = np.unwrap(recording.poses[..., 2], axis=0)

    def at(self, time: float) -> Snapshot:
        """The moment at `time` s: poses between those of two cycles, all else of the last one."""
        recording = self._recording
        time = min(max(time, self.begin), self.end)
        cycle, share = _place(recording.time, time)
        poses = _between(self._poses, cycle, share)
        status = recording.status[cycle]
        obstacles = tuple(
            obstacle.moved((float(x), float(y)))
            for obstacle, track in zip(self._obstacles, recording.obstacles, strict=True)
            if track.start <= time < track.end
            for x, y in [track.offset_at(time)]
        )
        # Without a task nobody has a role; with one, who has none is lost.
        roles = np.asarray(status.roles)
        lost = np.flatnonzero((roles < 0) & (roles >= 0).any())
        trunks, joints = None, None
        if recording.physics is not None and len(recording.physics.time):
            trunks, joints = _bodies(recording.physics, time)
        return Snapshot(
            time=time,
            poses=poses,
            commands=recording.commands[cycle],
            status=status,
            trunks=trunks,
            joints=joints,
            obstacles=obstacles,
            lost=tuple(lost.tolist()),
        )


class PlanPlayer:
    """A plan that nobody has carried out.

    Args:
        trajectories: By robot; who has none stands at its start.
        models, starts: Of all robots.
    """

    def __init__(
        self,
        trajectories: Mapping[int, Trajectory],
        models: Sequence[RobotModel],
        starts: Sequence[tuple[float, float, float]],
    ) -> None:
        self._trajectories = {k: one for k, one in trajectories.items() if k < len(models)}
        self._legged = all(model.legs is not None for model in models)
        self._starts = np.array(starts, dtype=float).reshape(-1, 3)
        self.begin = 0.0
        self.end = max((one.duration for one in self._trajectories.values()), default=0.0)

    def at(self, time: float) -> Snapshot:
        """The moment at `time` s."""
        time = min(max(time, self.begin), self.end)
        poses = self._starts.copy()
        trunks = None
        if self._legged and len(self._trajectories) == len(poses):
            trunks = np.zeros((len(poses), 7))
        for robot, path in self._trajectories.items():
            poses[robot] = path.poses_at(np.array([time]))[0]
            if trunks is not None:
                trunks[robot, 2] = np.interp(time, path.time, path.position[:, 2])
        if trunks is not None:
            trunks[:, :2] = poses[:, :2]
            trunks[:, 5], trunks[:, 6] = np.sin(poses[:, 2] / 2.0), np.cos(poses[:, 2] / 2.0)
        return Snapshot(time=time, poses=poses, trunks=trunks)


def _bodies(track: PhysicsTrack, time: float) -> tuple[Array, tuple[Array, ...]]:
    """Trunks `(N, 7)` and the joints of each robot."""
    sample, share = _place(track.time, time)
    trunks = np.empty((track.size, 7))
    trunks[:, :3] = _between(track.base[..., :3], sample, share)
    # Quaternions: w, x, y, z in a track; q and -q are the same rotation.
    ends = track.base[sample : sample + 2, :, 3:]
    near = np.where((ends[0] * ends[-1]).sum(axis=1, keepdims=True) < 0.0, -ends[-1], ends[-1])
    mixed = (1.0 - share) * ends[0] + share * near
    mixed /= np.linalg.norm(mixed, axis=1, keepdims=True)
    trunks[:, 3:] = mixed[:, (1, 2, 3, 0)]
    return trunks, tuple(_between(track.joints, sample, share))


def _place(times: Array, time: float) -> tuple[int, float]:
    """The last sample at or before `time`, and the share of the way to the next, below 1."""
    last = len(times) - 1
    sample = int(np.clip(np.searchsorted(times, time, side="right") - 1, 0, last))
    if sample == last or time <= times[sample]:
        return sample, 0.0
    return sample, float((time - times[sample]) / (times[sample + 1] - times[sample]))


def _between(values: Array, sample: int, share: float) -> Array:
    if share == 0.0:
        return np.array(values[sample])
    return np.asarray((1.0 - share) * values[sample] + share * values[sample + 1])
