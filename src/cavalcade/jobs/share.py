"""How much of a run is done, as far as its frames tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cavalcade.geometry import Array
from cavalcade.recording.frames import Frame
from cavalcade.recording.status import PlannerStatus


class ShareDone:
    """Of a run that will be given up after `timeout`, s of simulated time.

    `goals` are those of a formation one after the other, x and y first, map frame, m.
    """

    def __init__(self, timeout: float, goals: Sequence[Sequence[float]] = ()) -> None:
        self._timeout = timeout
        self._legs = np.array([goal[:2] for goal in goals], dtype=float).reshape(-1, 2)
        self._centre: Array | None = None
        self._driven = 0.0
        self._share = 0.0

    def __call__(self, frame: Frame) -> float:
        """From 0 to 1, never less than before.

        Plans and commands tell how long they will take. Formations have come as far as the
        distance that they drove is of that and what lies before them.
        """
        status = frame.status
        share = frame.time / self._timeout if self._timeout > 0.0 else 0.0
        if status.goal is not None:
            before = self._left(status, frame.poses)
            share = max(share, self._driven_by(frame.poses) / max(self._driven + before, 1e-9))
        elif status.state != "inactive" and np.isfinite(status.eta).all() and len(status.eta):
            share = max(share, frame.time / max(frame.time + float(status.eta.max()), 1e-9))
        self._share = min(max(share, self._share), 1.0)
        return self._share

    def _driven_by(self, poses: Array) -> float:
        """What the team's centre has driven, m."""
        centre = poses[:, :2].mean(axis=0)
        if self._centre is not None:
            self._driven += float(np.hypot(*(centre - self._centre)))
        self._centre = centre
        return self._driven

    def _left(self, status: PlannerStatus, poses: Array) -> float:
        """What the team still has to drive, m: along the leader's path, and from goal to goal."""
        here = np.linalg.norm(status.goals - poses[:, :2], axis=1)
        left = float(here[status.roles >= 0].max(initial=0.0))
        if status.leader >= 0 and len(status.paths[status.leader]) > 1:
            left = _length(status.paths[status.leader])
        return left + _length(self._legs[status.waypoint :])


def _length(line: Array) -> float:
    """Of a line of points `(K, 2)`, m."""
    return float(np.hypot(*np.diff(line, axis=0).T).sum())
