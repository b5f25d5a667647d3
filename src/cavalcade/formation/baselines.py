"""Other methods in the same harness: virtual structure and behaviour-based.

Both are given a cycle whose roles are known, fill in its targets and paths and whether the goal
is near (`final`), and return wanted velocities `(N, 2)`, m/s.
"""

from __future__ import annotations

import numpy as np

from cavalcade.formation.cycle import EMPTY_PATH, Cycle, by_robot
from cavalcade.formation.goals import descend_from
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.geometry import Array, rotation

_LEASH = 0.5  # m: a virtual structure waits for robots this far behind their places
_SPACE = 1.0  # m: neighbours nearer than this are pushed off by the behaviour-based method


def rigid_maps(maps: PlanningMaps, slots: Array) -> PlanningMaps:
    """The maps as one rigid body of the whole shape `(S, 2)` sees it, whatever its heading."""
    extent = float(np.hypot(slots[:, 0], slots[:, 1]).max())
    return maps.tightened(maps.settings.r_max + extent)


def virtual_structure(cycle: Cycle, lookahead: float, top: float) -> Array:
    """One reference pose for the shape moves down the field; robots hold their places on it."""
    plan, points, active = cycle.plan, cycle.points, cycle.active
    slots = cycle.team.formation.slots
    centre = points[active].mean(axis=0)
    path = descend_from(plan.field, centre)
    if not np.isfinite(path.eta):
        cycle.targets = points.copy()
        return np.zeros_like(points)
    final = cycle.final = path.eta < lookahead
    if final:
        heading, ahead = float(plan.pose[2]), plan.pose[:2]
    else:
        ahead, heading = path.ahead(0.5)
        slots = slots - slots.mean(axis=0)
    places = slots @ rotation(heading).T + (ahead if final else centre)
    cycle.targets = by_robot(places, cycle.roles)
    error = np.nan_to_num(cycle.targets - points)
    lag = np.hypot(error[:, 0], error[:, 1])
    pace = top * max(0.0, 1.0 - float(lag[active].max()) / _LEASH)
    course = ahead - centre
    length = float(np.hypot(*course))
    course = course / length if length > 1e-9 else course
    cycle.paths = tuple(path.points if k == active[0] else EMPTY_PATH for k in range(len(points)))
    return 1.5 * error + (0.0 if final else pace) * course


def seek_and_space(cycle: Cycle, lookahead: float, top: float) -> Array:
    """Weighted goal seeking and neighbour spacing; obstacles are left to the avoidance layer.

    No common plan: every robot heads straight for its own place at the goal and is pushed off by
    neighbours and obstacles that are too near.
    """
    points, active = cycle.points, cycle.active
    targets = cycle.targets = by_robot(cycle.plan.places, cycle.roles)
    error = np.nan_to_num(targets - points)
    away = np.hypot(error[:, 0], error[:, 1])
    velocity = top * error / np.maximum(away, 1e-9)[:, None]
    for k in active:
        for j in range(len(points)):
            offset = points[k] - points[j]
            gap = float(np.hypot(*offset))
            if 1e-9 < gap < _SPACE:
                velocity[k] += top * (_SPACE - gap) / _SPACE * offset / gap
        velocity[k] += top * _slope(cycle.plan.maps, points[k])
    cycle.final = bool(away[active].max() < lookahead * top)
    cycle.paths = tuple(
        np.vstack([points[k], targets[k]]) if cycle.roles[k] >= 0 else EMPTY_PATH
        for k in range(len(points))
    )
    return velocity


def _slope(maps: PlanningMaps, point: Array) -> Array:
    """A push off near obstacles, 1 at the inflated ones and 0 from d_safe_b on."""
    step = np.array([[maps.cell, 0.0], [0.0, maps.cell]])
    w = float(maps.speed_at(point[None])[0])
    if w >= 1.0:
        return np.zeros(2)
    rise = maps.clearance(point + step) - maps.clearance(point - step)
    length = float(np.hypot(*rise))
    return (1.0 - w) * rise / length if length > 1e-9 else np.zeros(2)
