"""Other methods in the same harness: virtual structure and behaviour-based."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cavalcade.formation.goals import GoalPlan, descend_from
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.formation.settings import FormationSettings
from cavalcade.formation.shapes import Formation
from cavalcade.formation.team import Team
from cavalcade.formation.variants import Variant
from cavalcade.geometry import Array, rotation

_LEASH = 0.5  # m: a virtual structure waits for robots this far behind their places
_SPACE = 1.0  # m: neighbours nearer than this are pushed off by the behaviour-based method


def rigid_maps(maps: PlanningMaps, formation: Formation) -> PlanningMaps:
    """The maps as one rigid body of the whole shape sees it, whatever its heading."""
    extent = float(np.hypot(formation.slots[:, 0], formation.slots[:, 1]).max())
    return maps.tightened(maps.settings.r_max + extent)


def behave(
    variant: Variant,
    plan: GoalPlan,
    team: Team,
    points: Array,
    roles: NDArray[np.int64],
    settings: FormationSettings,
    top: float,
) -> tuple[Array, Array, tuple[Array, ...], bool]:
    """Wanted velocities `(N, 2)` in m/s, targets `(N, 2)`, paths, and whether the goal is near."""
    if variant.rigid:
        return _virtual_structure(plan, team, points, roles, settings, top)
    return _behaviours(plan, team, points, roles, settings, top)


def _virtual_structure(
    plan: GoalPlan,
    team: Team,
    points: Array,
    roles: NDArray[np.int64],
    settings: FormationSettings,
    top: float,
) -> tuple[Array, Array, tuple[Array, ...], bool]:
    """One reference pose for the shape moves down the field; robots hold their places on it."""
    active = team.active
    middle = team.formation.slots.mean(axis=0)
    centre = points[active].mean(axis=0)
    path = descend_from(plan.field, centre)
    if not np.isfinite(path.eta):
        paths = (np.empty((0, 2)),) * len(points)
        return np.zeros_like(points), points.copy(), paths, False
    final = path.eta < settings.lookahead
    if final:
        heading, ahead = float(plan.pose[2]), plan.pose[:2]
    else:
        ahead, heading = path.ahead(0.5)
    slots = team.formation.slots if final else team.formation.slots - middle
    places = slots @ rotation(heading).T + (ahead if final else centre)
    targets = np.vstack([places, [np.nan, np.nan]])[roles]
    error = np.nan_to_num(targets - points)
    lag = np.hypot(error[:, 0], error[:, 1])
    pace = top * max(0.0, 1.0 - float(lag[active].max()) / _LEASH)
    course = ahead - centre
    length = float(np.hypot(*course))
    course = course / length if length > 1e-9 else course
    velocity = 1.5 * error + (0.0 if final else pace) * course
    paths = tuple(path.points if k == active[0] else np.empty((0, 2)) for k in range(len(points)))
    return velocity, targets, paths, final


def _behaviours(
    plan: GoalPlan,
    team: Team,
    points: Array,
    roles: NDArray[np.int64],
    settings: FormationSettings,
    top: float,
) -> tuple[Array, Array, tuple[Array, ...], bool]:
    """Weighted goal seeking and neighbour spacing; obstacles are left to the avoidance layer.

    No common plan: every robot heads straight for its own place at the goal and is pushed off by
    neighbours and obstacles that are too near.
    """
    targets = np.vstack([plan.places, [np.nan, np.nan]])[roles]
    error = np.nan_to_num(targets - points)
    away = np.hypot(error[:, 0], error[:, 1])
    velocity = top * error / np.maximum(away, 1e-9)[:, None]
    for k in team.active:
        for j in range(len(points)):
            offset = points[k] - points[j]
            gap = float(np.hypot(*offset))
            if 1e-9 < gap < _SPACE:
                velocity[k] += top * (_SPACE - gap) / _SPACE * offset / gap
        slope = _slope(plan.maps, points[k])
        velocity[k] += top * slope
    final = bool(away[team.active].max() < settings.lookahead * top)
    paths = tuple(
        np.vstack([points[k], targets[k]]) if roles[k] >= 0 else np.empty((0, 2))
        for k in range(len(points))
    )
    return velocity, targets, paths, final


def _slope(maps: PlanningMaps, point: Array) -> Array:
    """A push off near obstacles, 1 at the inflated ones and 0 from d_safe_b on."""
    step = np.array([[maps.cell, 0.0], [0.0, maps.cell]])
    w = float(maps.speed_at(point[None])[0])
    if w >= 1.0:
        return np.zeros(2)
    rise = maps.clearance(point + step) - maps.clearance(point - step)
    length = float(np.hypot(*rise))
    return (1.0 - w) * rise / length if length > 1e-9 else np.zeros(2)
