"""What the live plots of a drive show: the last minutes in arrays of a fixed size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.geometry import Array
from cavalcade.metrics.run_summary import placement_errors
from cavalcade.robots import RobotModel
from cavalcade.studio.snapshot import Snapshot
from cavalcade.world import OccupancyMap, Shape, shape_from_mapping
from cavalcade.world.gaps import body_at, gap_between, nearest_obstacle

POINTS = 600
"""Points that are kept."""

PERIOD = 0.2
"""Between two of them, s, at least."""

REACH, REACH_OF_CELLS = 1.0, 0.4
"""Obstacles are looked for so far around a footprint, m; on maps with occupied cells, of which
there may be thousands, not as far."""

CURVES = ("obstacles", "robots", "formation", "cycle")
"""What is kept: smallest gap of a footprint to an obstacle and between two robots, m; largest
distance of a robot to its place in the shape, m; time of a planner's cycle, ms. nan where there
is none."""


@dataclass(frozen=True)
class Ground:
    """What robots may run into.

    Attributes:
        map: Without the shapes.
        shapes: Exact ones that stand now.
    """

    map: OccupancyMap
    shapes: tuple[Shape, ...]


class History:
    """The last `POINTS` points of each curve, the newest at the end; memory stays the same."""

    def __init__(self) -> None:
        self._values = np.full((1 + len(CURVES), POINTS), np.nan)
        self._count = 0

    def __len__(self) -> int:
        return min(self._count, POINTS)

    def clear(self) -> None:
        """Begin anew."""
        self._count = 0

    def add(
        self, moment: Snapshot, ground: Ground, models: Sequence[RobotModel], planning: float
    ) -> None:
        """Keep a moment, unless it is too near to the last one."""
        if self._count:
            last = self._values[0, (self._count - 1) % POINTS]
            if moment.time < last:
                self.clear()
            elif moment.time - last < PERIOD - 1e-9:
                return
        self._values[:, self._count % POINTS] = (
            moment.time,
            *gaps(moment, ground, models),
            formation_error(moment),
            1e3 * planning,
        )
        self._count += 1

    def curve(self, name: str) -> tuple[Array, Array]:
        """Times and values, both `(K,)`, in order of time."""
        order = self._order()
        return self._values[0, order], self._values[1 + CURVES.index(name), order]

    def _order(self) -> NDArray[np.int64]:
        count = len(self)
        return np.arange(self._count - count, self._count) % POINTS


def gaps(moment: Snapshot, ground: Ground, models: Sequence[RobotModel]) -> tuple[float, float]:
    """Smallest gap of a footprint to an obstacle, and between two, m; nan where nothing is near."""
    bodies = [body_at(model, pose) for model, pose in zip(models, moment.poses, strict=True)]
    moving = [shape_from_mapping(obstacle.to_dict()) for obstacle in moment.obstacles]
    shapes = (*ground.shapes, *moving)
    reach = REACH_OF_CELLS if ground.map.occupied.any() else REACH
    near = min(nearest_obstacle(body, ground.map, shapes, reach)[0] for body in bodies)
    if near >= reach:
        near = np.nan
    between = [gap_between(one, other) for k, one in enumerate(bodies) for other in bodies[k + 1 :]]
    return near, min(between, default=np.nan)


def formation_error(moment: Snapshot) -> float:
    """Largest distance of a robot to its place in the shape, as it fits best, m."""
    status = moment.status
    if status is None or not len(status.slots):
        return np.nan
    has_slot = (status.roles >= 0) & (status.roles < len(status.slots))
    if not has_slot.any():
        return np.nan
    slots = np.zeros((len(moment.poses), 2))
    slots[has_slot] = status.slots[status.roles[has_slot]]
    errors = placement_errors(moment.poses[None, :, :2], slots[None], has_slot[None])
    return float(errors[0, has_slot].max())
