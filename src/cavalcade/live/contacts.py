"""Tells when simulated robots begin to touch something."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from cavalcade.geometry import Array
from cavalcade.metrics.clearance import clearance
from cavalcade.recording.frames import Recording
from cavalcade.robots import RobotModel
from cavalcade.scenario import World

_PERIOD = 0.1
"""How often is looked, s."""


class ContactWatch:
    """Judges footprints as the summary of a run does, between any two looks.

    Only who is near something is judged exactly.
    """

    def __init__(self, world: World, models: Sequence[RobotModel]) -> None:
        from scipy.ndimage import distance_transform_edt

        self._world = world
        self._models = tuple(models)
        self._reach = np.array([0.5 * math.hypot(m.length, m.width) for m in models])
        area = world.map
        free = np.pad(~area.occupied, 1)
        self._room = distance_transform_edt(free)[1:-1, 1:-1] * area.resolution
        self._touching: set[tuple[int, int | None]] = set()
        self._before: tuple[float, Array] | None = None

    def look(self, time: float, poses: Array) -> list[str]:
        """What begins to touch at poses `(N, 3)`, a line each; most calls are not yet a look."""
        if self._before is None:
            self._before = time, poses
        since, before = self._before
        if time - since < _PERIOD - 1e-9:
            return []
        self._before = time, poses
        steps = np.hypot(*(poses - before)[:, :2].T)
        cells = self._world.map.cell_of(poses[:, :2])
        rows, cols = np.clip(cells, 0, np.array(self._room.shape) - 1).T
        near = self._room[rows, cols] - 2.0 * self._world.map.resolution < self._reach + steps
        now: set[tuple[int, int | None]] = set()
        for robot in np.flatnonzero(near).tolist():
            if self._touches([robot], before, poses):
                now.add((robot, None))
        for one, other in combinations(range(len(poses)), 2):
            apart = math.hypot(*(poses[one] - poses[other])[:2])
            reach = self._reach[one] + self._reach[other] + steps[one] + steps[other]
            if apart < reach and self._touches([one, other], before, poses):
                now.add((one, other))
        begun = sorted(now - self._touching, key=str)
        self._touching = now
        return [
            f"robot {robot} touches " + ("an obstacle" if other is None else f"robot {other}")
            for robot, other in begun
        ]

    def _touches(self, who: list[int], before: Array, after: Array) -> bool:
        poses = np.stack([before[who], after[who]])
        still = np.zeros_like(poses)
        time = np.array([0.0, _PERIOD])
        recording = Recording(time, poses, poses, still, (), (), ())
        found = clearance(self._world, recording, [self._models[robot] for robot in who])
        return bool(found.robot_robot if len(who) > 1 else found.robot_obstacle)
