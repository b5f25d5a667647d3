"""Goals: the plan for one formation goal and the partial goals on the way to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cavalcade.eikonal import ArrivalField, TravelGrid
from cavalcade.formation._clearance import Footprint
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.geometry import Array, rotation, transform_points

_SHIFT_REACH = 3.0  # m: how far a goal whose slots do not fit is moved at most
_ESCAPE = 1.5  # m: how far free ground is looked for from within the inflated zone
_W_ESCAPE = 0.1  # velocity-map value assumed on the way out of it
_INFLATIONS = (0.06, 0.02)  # m around the bodies in their slots
_SHIFT_STEP = 0.05  # m: step in which partial goals are moved to free ground


class GoalPlan:
    """What is known of one goal on one state of the maps; in the grid's frame.

    Attributes:
        pose: `(3,)` the formation's centre, moved where its slots did not fit.
        places: `(S, 2)` final places of the slots, m.
        moved: How far the goal was moved, m.
        field: Arrival times on W_A from the centre.
        cut_off: Robots that cannot reach it; the goal is infeasible if there are any.
        problem: What is wrong with a goal that the shape fits nowhere near, in words.
        missing: Slots whose fields have been asked for in vain, and the cells to reach.
    """

    def __init__(
        self, maps: PlanningMaps, goal: Array, slots: Array, points: Array, footprint: Footprint
    ) -> None:
        """Plan for robots at `points` `(S, 2)`, the ones that take part."""
        self.maps = maps
        regions = np.array([maps.component(point) for point in points])
        names, counts = np.unique(regions[regions > 0], return_counts=True)
        wanted = transform_points(goal, slots)
        shift = None
        outside = (goal[:2] < 0.0) | (goal[:2] > maps.size)
        self.problem = "it is off the map" if outside.any() else ""
        self.cut_off: NDArray[np.int64]
        if len(names) > 0:
            common = int(names[np.argmax(counts)])
            body = footprint.discs @ rotation(goal[2]).T
            for inflation in _INFLATIONS:  # with space to turn there if it can be had
                needed = footprint.radius + inflation
                shift = maps.placement(wanted, common, _SHIFT_REACH, body, needed)
                if shift is not None:
                    break
                if maps.placement(wanted, None, 0.0, body, needed) is not None:
                    self.problem = ""
                    break  # the slots fit where they are, but no path leads there
            else:
                nowhere = f"the shape fits nowhere within {_SHIFT_REACH:g} m of it"
                self.problem = self.problem or nowhere
            self.cut_off = np.nonzero(regions != common)[0]
        if shift is not None:
            self.problem = ""
        else:
            self.cut_off = np.arange(len(points))
            shift = np.zeros(2)
        self.moved = float(np.hypot(*shift))
        self.pose = goal + np.append(shift, 0.0)
        self.places = wanted + shift
        centre = self.pose[:2]
        if not maps.leader.is_free(centre):
            # A shape around an obstacle: head for the free ground nearest to its centre.
            near = maps.leader.nearest_free(centre)
            centre = self.places[0] if near is None else near
        self.field = maps.leader.field(centre)
        # Each with whether it holds all that can be reached.
        self._slot_fields: dict[int, tuple[ArrivalField, bool]] = {}
        self._beside: TravelGrid | None = None
        self.missing: dict[int, list[tuple[int, int]]] = {}
        self._entered: tuple[bytes, list[tuple[int, int]]] = (b"", [])

    def slot_field(self, slot: int, points: Array) -> ArrivalField:
        """Arrival times on W_B from a slot's final place, at least as far as `points` `(K, 2)`.

        Computed once, and again should a point lie outside what was settled then.
        """
        known = self._known(slot, points)
        if known is not None:
            return known
        return self._march(self.maps.slots, slot, self._entries(points))

    def march_beside(self) -> None:
        """From now on slot fields are made by `make_missing`, in another thread."""
        self._beside = self.maps.slots.twin()
        self.maps.follower.get_ready()
        self._beside.get_ready()

    def has_slot_field(self, slot: int, points: Array) -> bool:
        """Whether a slot's field can be asked for; one that must be made first is `missing`."""
        if self._beside is None or self._known(slot, points) is not None:
            return True
        self.missing[slot] = self._entries(points)
        return False

    def make_missing(self, slot: int, cells: list[tuple[int, int]]) -> None:
        """Make a slot's field, at least as far as [row, col] cells."""
        if self._beside is not None:
            self._march(self._beside, slot, cells)

    def _known(self, slot: int, points: Array) -> ArrivalField | None:
        known, whole = self._slot_fields.get(slot, (None, False))
        enough = known is not None and (whole or known.reaches(self._entries(points)))
        return known if enough else None

    def _march(self, grid: TravelGrid, slot: int, cells: list[tuple[int, int]]) -> ArrivalField:
        field = grid.field(self.places[slot], targets=cells or None)
        # Where cells are not reached, the march ended because there was nowhere left to go.
        self._slot_fields[slot] = field, not cells or not field.reaches(cells)
        return field

    def _entries(self, points: Array) -> list[tuple[int, int]]:
        """The free [row, col] cells that points stand in or next to, where there are any."""
        key = points.tobytes()
        if self._entered[0] != key:  # every robot of a team asks for the same points
            grid = self.maps.follower
            near = [
                point if grid.is_free(point) else grid.nearest_free(point, reach=_ESCAPE)
                for point in points
            ]
            self._entered = (key, [grid.cell_of(point) for point in near if point is not None])
        return self._entered[1]


@dataclass(frozen=True)
class Descent:
    """A robot's path down a field: points `(K, 2)` m and remaining times `(K,)` s."""

    points: Array
    times: Array

    @property
    def eta(self) -> float:
        """Seconds to the source; inf where there is no path."""
        return float(self.times[0]) if len(self.times) else np.inf

    def ahead(self, time: float) -> tuple[Array, float]:
        """The point `time` seconds along the path, and its direction there in rad."""
        k = int(np.searchsorted(-self.times, -(self.times[0] - time)))
        k = min(max(k, 1), len(self.points) - 1)
        span = self.times[k - 1] - self.times[k]
        share = 1.0
        if span > 0.0:
            share = min(max((self.times[k - 1] - (self.times[0] - time)) / span, 0.0), 1.0)
        point = self.points[k - 1] + share * (self.points[k] - self.points[k - 1])
        before, after = self.points[max(k - 5, 0)], self.points[min(k + 4, len(self.points) - 1)]
        tangent = after - before
        return point, float(np.arctan2(tangent[1], tangent[0]))


def descend_from(field: ArrivalField, point: Array) -> Descent:
    """The path from any point `(2,)`; one in the inflated zone first makes for free ground."""
    points, times = field.path(point)
    if len(points) > 1:
        return Descent(points, times)
    if len(points) == 1:
        return Descent(np.vstack([points, points]), np.append(times, times))
    exit_ = field.nearest_reached(point, reach=_ESCAPE)
    if exit_ is None:
        return Descent(np.empty((0, 2)), np.empty(0))
    points, times = field.path(exit_)
    out = float(np.hypot(*(exit_ - point))) / _W_ESCAPE
    return Descent(np.vstack([point, points]), np.append(times[0] + out, times))


def partial_goals(
    maps: PlanningMaps, anchor: Array, heading: float, slots: Array, w_min: float
) -> Array:
    """Partial goals `(S, 2)` of all slots (Norén et al., eq. 2), moved to free ground if needed, m.

    The leader's, which is the first of the slots `(S, 2)`, is `anchor` `(2,)`, p_1 in the paper;
    `heading` is the direction of its path there, rad, and `w_min` the least W_B of a follower's.
    """
    goals = (slots - slots[0]) @ rotation(heading).T + anchor
    pending = np.nonzero(maps.speed_at(goals) < w_min)[0]
    pending = pending[pending > 0]
    if len(pending) == 0:
        return goals
    offset = anchor - goals[pending]
    length = np.hypot(offset[:, 0], offset[:, 1])
    steps = np.arange(1, int(np.ceil(length.max() / _SHIFT_STEP)) + 1) * _SHIFT_STEP
    share = np.minimum(steps[None] / np.maximum(length, 1e-9)[:, None], 1.0)
    tried = goals[pending][:, None] + share[..., None] * offset[:, None]
    speed = maps.speed_at(tried.reshape(-1, 2)).reshape(share.shape)
    good = (speed >= w_min) | (share >= 1.0)
    first = np.argmax(good, axis=1)
    goals[pending] = tried[np.arange(len(pending)), first]
    return goals


def eta_from(field: ArrivalField, point: Array) -> float:
    """Arrival time from any point, s; from the inflated zone by its nearest free maps."""
    eta = field.eta(point)
    if np.isfinite(eta):
        return eta
    near = field.nearest_reached(point, reach=_ESCAPE)
    if near is None:
        return np.inf
    return field.eta(near) + float(np.hypot(*(near - point))) / _W_ESCAPE


def local_path(
    maps: PlanningMaps, start: Array, goal: Array, guess: float = np.inf
) -> tuple[Array, float]:
    """The local path on W_B; from the inflated zone first to the nearest free ground.

    `guess` is a time that the path will hardly exceed, s; it only saves work. Returns points
    `(K, 2)`, empty where there is no path, and the time, inf where there is none.
    """
    grid = maps.follower
    path, eta = grid.local_path(start, goal, guess)
    if len(path) or grid.is_free(start):
        return path, eta
    out = grid.nearest_free(start, reach=_ESCAPE)
    if out is None:
        return np.empty((0, 2)), np.inf
    rest, eta = grid.local_path(out, goal, guess)
    return np.vstack([start, out if len(rest) == 0 else rest]), eta
