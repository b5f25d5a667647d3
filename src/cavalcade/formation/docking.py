"""Turning before docking: for slots too tight to turn to the goal's heading in."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cavalcade.formation.cycle import Cycle
from cavalcade.formation.ground import Ground
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel

_NEAR = 0.30  # m from its slot within which a robot should be turning
_OFF = 0.13  # rad from the goal's heading that are too much
_TURNED = 0.08  # rad from it at which a robot goes to its slot
_PATIENCE = 2.0  # s without turning by
_STEP = 0.05  # rad, after which it is wedged
_REACH = 1.5  # m from the slot within which a place to turn is looked for
_ROOM = 0.08  # m beyond its half diagonal that a robot needs to turn
_APART = 0.4  # m between places that are tried one after the other
_LONGEST = 10.0  # s for one of them
_TRIES = 4
_LEAVING = 0.3  # m that are added to the distance left, so that nobody slows down or rests


@dataclass
class _Robot:
    """What is known of one robot's docking."""

    slot: int = -1
    least: float = math.inf
    since: float = 0.0
    place: Array | None = None
    begun: float = 0.0
    turned: bool = False
    tried: list[Array] = field(default_factory=list)


class DockingWatch:
    """Finds robots that are wedged in their slots and sends them to turn where there is room.

    A wedged robot drives to the nearest place that is wide enough, turns to the goal's heading
    there and comes back with that heading kept.

    Args:
        model: The robots' size.
    """

    def __init__(self, model: RobotModel) -> None:
        self._radius = math.hypot(model.length, model.width) / 2.0
        self.restart()

    def restart(self) -> None:
        """Another goal, shape or team."""
        self._robots: dict[int, _Robot] = {}

    def update(self, cycle: Cycle) -> bool:
        """Fill in the cycle's `detours` and `docking`, its `roles` and `away` being known.

        Returns:
            Whether any robot is on a detour.
        """
        off = np.abs(wrap_angle(cycle.plan.pose[2] - cycle.poses[:, 2]))
        for k in cycle.active:
            slot = int(cycle.roles[k])
            robot = self._robots.get(int(k))
            if robot is None or robot.slot != slot:
                robot = self._robots[int(k)] = _Robot(slot)
            if robot.place is not None:
                self._turn(robot, float(off[k]), cycle.time)
            elif cycle.away[k] < _NEAR and off[k] > _OFF:
                self._watch(robot, int(k), float(off[k]), cycle)
            else:
                robot.least = math.inf
            cycle.docking[k] = robot.place is not None or robot.turned
            if robot.place is not None:
                cycle.detours[int(k)] = robot.place
                cycle.away[k] = float(np.hypot(*(robot.place - cycle.points[k]))) + _LEAVING
        return bool(cycle.detours)

    def _turn(self, robot: _Robot, off: float, time: float) -> None:
        robot.turned = off < _TURNED
        if robot.turned or time - robot.begun > _LONGEST:
            robot.place, robot.least = None, math.inf

    def _watch(self, robot: _Robot, k: int, off: float, cycle: Cycle) -> None:
        if off < robot.least - _STEP:
            robot.least, robot.since = off, cycle.time
        if cycle.time - robot.since < _PATIENCE or len(robot.tried) >= _TRIES:
            return
        robot.place = self._room_near(k, robot.tried, cycle)
        robot.begun, robot.since = cycle.time, cycle.time
        if robot.place is not None:
            robot.tried.append(robot.place)

    def _room_near(self, k: int, tried: list[Array], cycle: Cycle) -> Array | None:
        """The nearest free place with room to turn, clear of the others and of what was tried."""
        places = _roomy(cycle.plan.ground, cycle.points[k], self._radius + _ROOM)
        others = [cycle.points[j] for j in range(len(cycle.points)) if j != k]
        for points, gap in ((others, 2.0 * self._radius + _ROOM), (tried, _APART)):
            for point in points:
                places = places[np.hypot(*(places - point).T) >= gap]
        if len(places) == 0:
            return None
        return places[np.argmin(np.hypot(*(places - cycle.points[k]).T))]


def _roomy(ground: Ground, point: Array, radius: float) -> Array:
    """Cell centres `(P, 2)` near a point that are `radius` clear and joined to it."""
    row, col = (int(v) for v in np.floor(point[::-1] / ground.cell))
    reach = int(_REACH / ground.cell)
    top, left = max(row - reach, 0), max(col - reach, 0)
    window = ground.distance[top : row + reach + 1, left : col + reach + 1]
    rows, cols = np.nonzero(window >= radius)
    places = (np.column_stack([cols + left, rows + top]) + 0.5) * ground.cell
    home = ground.component(point)
    joined = [ground.component(place) == home for place in places]
    return places[np.array(joined, dtype=bool)]
