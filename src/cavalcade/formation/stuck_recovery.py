"""Stuck robots: a body longer than wide cannot turn everywhere its centre can be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from cavalcade.formation.cycle import Cycle, path_heading
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.geometry import Array, wrap_angle
from cavalcade.robots import RobotModel

_NEAR = 0.30  # m from its slot within which a robot should be turning to the goal's heading
_OFF = 0.13  # rad from it that are too much there
_ACROSS = 0.40  # rad off the path ahead that are too much on the way
_STILL = 0.05  # m and rad by which a robot on its way must move
_STEP = 0.05  # rad by which a robot in its slot must turn
_PATIENCE = 2.0  # s without either, after which it is stuck
_TURNED = 0.08  # rad from the wanted heading at which it goes back
_REACH = 1.5  # m within which a place to turn is looked for
_INFLATION = 0.08  # m beyond its half diagonal that a robot needs to turn
_APART = 0.4  # m between places that are tried one after the other
_PASSED = 0.15  # m from where it was stuck, at which it may turn as it likes again
_LONGEST = 10.0  # s for one of these places, and for the way back
_TRIES = 4
_LEAVING = 0.3  # m that are added to the distance left, so that nobody slows down or rests


@dataclass
class _Robot:
    """What is known of one robot.

    Attributes:
        slot: Where it is going.
        least, since: Smallest error of its heading in the slot, and when it last got on, s.
        pose: Where it last got on.
        place: Where it goes to turn, None if it does not.
        heading: What it turns to, and keeps to once it has `turned`, rad.
        spot: Where on its path it was stuck, None for in its slot.
        begun: When it set out for `place`, or back, s.
        tried: Places it has been sent to.
    """

    slot: int = -1
    least: float = math.inf
    since: float = 0.0
    pose: Array | None = None
    place: Array | None = None
    heading: float = 0.0
    turned: bool = False
    spot: Array | None = None
    begun: float = 0.0
    tried: list[Array] = field(default_factory=list)


class StuckRecovery:
    """Finds robots that cannot turn where they are and sends them to turn where there is room.

    Such a robot drives to the nearest place that is wide enough, turns there to the heading that
    it needs, the goal's or that of the path ahead, and comes back with that heading kept.
    """

    def __init__(self, model: RobotModel) -> None:
        self._radius = math.hypot(model.length, model.width) / 2.0 + _INFLATION
        self.restart()

    def restart(self) -> None:
        """Another goal, shape or team."""
        self._robots: dict[int, _Robot] = {}
        self._time = 0.0
        self._idle = False

    def go_on(self) -> None:
        """Time has passed without cycles: it counts for nobody's patience."""
        self._idle = True

    def update(self, cycle: Cycle, paths: Sequence[Array] | None = None) -> bool:
        """Fill in the cycle's `detours` and `facing`; True if any robot is on a detour.

        In the states final and resolving, with `roles` and `away` known. With the robots' `paths`
        those who get nowhere on them are helped, too.
        """
        if self._idle:
            for known in self._robots.values():
                known.since += cycle.time - self._time
                known.begun += cycle.time - self._time
        self._time, self._idle = cycle.time, False
        final = float(cycle.plan.pose[2])
        off = np.abs(wrap_angle(final - cycle.poses[:, 2]))
        for k in (int(robot) for robot in cycle.active):
            robot = self._robots.setdefault(k, _Robot())
            if robot.slot != cycle.roles[k]:
                if robot.spot is None:
                    robot = self._robots[k] = _Robot(tried=robot.tried)
                robot.slot = int(cycle.roles[k])
            if robot.place is not None or robot.spot is not None:
                self._go_on(robot, cycle.poses[k], cycle.time)
            elif cycle.away[k] < _NEAR and off[k] > _OFF:
                self._watch_slot(robot, k, float(off[k]), cycle)
            elif paths is not None:
                robot.least = math.inf
                self._watch_path(robot, k, path_heading(paths[k]), cycle)
            else:
                robot.least, robot.pose = math.inf, None
            if robot.place is not None:
                cycle.detours[k] = robot.place
                cycle.away[k] = float(np.hypot(*(robot.place - cycle.points[k]))) + _LEAVING
            if robot.place is not None or robot.turned:
                cycle.facing[k] = robot.heading
        return bool(cycle.detours)

    def _go_on(self, robot: _Robot, pose: Array, time: float) -> None:
        """On the way to a place to turn, or back to where the robot was stuck."""
        late = time - robot.begun > _LONGEST
        if robot.place is not None:
            robot.turned = abs(float(wrap_angle(robot.heading - pose[2]))) < _TURNED
            if robot.turned or late:
                robot.place, robot.least, robot.begun = None, math.inf, time
                if not robot.turned:
                    robot.spot = None
        elif robot.spot is not None and (late or np.hypot(*(robot.spot - pose[:2])) < _PASSED):
            robot.turned, robot.spot, robot.pose = False, None, None

    def _watch_slot(self, robot: _Robot, k: int, off: float, cycle: Cycle) -> None:
        if off < robot.least - _STEP:
            robot.least, robot.since = off, cycle.time
        if cycle.time - robot.since >= _PATIENCE:
            self._send(robot, k, float(cycle.plan.pose[2]), None, cycle)

    def _watch_path(self, robot: _Robot, k: int, heading: float | None, cycle: Cycle) -> None:
        pose, maps = cycle.poses[k], cycle.plan.maps
        across = heading is not None and abs(float(wrap_angle(heading - pose[2]))) > _ACROSS
        still = False
        if robot.pose is not None:
            moved = pose - robot.pose
            turned = abs(float(wrap_angle(moved[2])))
            still = float(np.hypot(moved[0], moved[1])) < _STILL and turned < _STILL
        if not (across and still) or maps.distance_at(pose[:2]) >= self._radius:
            robot.pose, robot.since = pose.copy(), cycle.time
        elif heading is not None and cycle.time - robot.since >= _PATIENCE:
            self._send(robot, k, heading, pose[:2].copy(), cycle)

    def _send(
        self, robot: _Robot, k: int, heading: float, spot: Array | None, cycle: Cycle
    ) -> None:
        if len(robot.tried) >= _TRIES:
            return
        robot.since = cycle.time
        place = self._room_near(k, robot.tried, cycle)
        if place is not None:
            robot.tried.append(place)
            robot.place, robot.heading, robot.spot = place, heading, spot
            robot.begun, robot.turned = cycle.time, False

    def _room_near(self, k: int, tried: list[Array], cycle: Cycle) -> Array | None:
        """The nearest free place with room to turn, clear of the others and of what was tried."""
        places = _turning_places(cycle.plan.maps, cycle.points[k], self._radius)
        others = [cycle.points[j] for j in range(len(cycle.points)) if j != k]
        for points, gap in ((others, 2.0 * self._radius - _INFLATION), (tried, _APART)):
            for point in points:
                places = places[np.hypot(*(places - point).T) >= gap]
        if len(places) == 0:
            return None
        return places[np.argmin(np.hypot(*(places - cycle.points[k]).T))]


def _turning_places(maps: PlanningMaps, point: Array, radius: float) -> Array:
    """Cell centres `(P, 2)` near a point that are `radius` clear and joined to it."""
    row, col = (int(v) for v in np.floor(point[::-1] / maps.cell))
    reach = int(_REACH / maps.cell)
    top, left = max(row - reach, 0), max(col - reach, 0)
    window = maps.distance[top : row + reach + 1, left : col + reach + 1]
    regions = maps.regions()[top : row + reach + 1, left : col + reach + 1]
    rows, cols = np.nonzero((window >= radius) & (regions == maps.component(point)))
    cells = np.column_stack([cols + left, rows + top]).astype(np.float64)
    return (cells + 0.5) * maps.cell
