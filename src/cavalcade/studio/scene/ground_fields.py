"""What the planner of a formation sees of the ground, as pictures: velocity map, arrival times."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cavalcade.execution.formation_policy import settings_of
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.geometry import Array, inverse_transform_points
from cavalcade.scenario import ResolvedScenario, World
from cavalcade.studio.scene.palette import Palette
from cavalcade.world import OccupancyMap, Shape

VELOCITY, ARRIVAL = "velocity map", "arrival times"

_OPACITY = 200
_MOST_PIXELS = 1024
"""Per side; finer fields are sent with every so many-th cell."""

_BANDS = 14
"""Arrival times are drawn in about so many steps, whose edges are contour lines."""


def field_picture(
    layer: str,
    scenario: ResolvedScenario,
    world: World,
    obstacles: Iterable[Shape],
    goal: Array | None,
    palette: Palette,
) -> NDArray[np.uint8] | None:
    """A picture `(rows, cols, 4)` of a field on the grid of the map, row 0 at its lowest y.

    It is what the leader plans on: the planner's own maps with all `obstacles`. None where there
    is no such field: without a formation, or no arrival times without a `goal` `(3,)`.
    """
    if scenario.task.formation is None or (layer == ARRIVAL and goal is None):
        return None
    grid = world.map_with(obstacles)
    width = max(scenario.models, key=lambda model: model.length * model.width).width
    maps = PlanningMaps(
        grid.occupied, grid.resolution, settings_of(scenario.planner), half_width=width / 2.0
    )
    if layer == VELOCITY:
        return _picture(_finite(maps.leader.speed), palette)
    assert goal is not None
    return _arrival(maps, grid, goal, palette)


def _arrival(
    maps: PlanningMaps, grid: OccupancyMap, goal: Array, palette: Palette
) -> NDArray[np.uint8]:
    place = inverse_transform_points(grid.origin, goal[None, :2])[0]
    if not maps.leader.is_free(place):
        near = maps.leader.nearest_free(place)
        place = place if near is None else near
    times = maps.leader.field(place).times
    known = np.isfinite(times)
    if not known.any():
        return np.zeros((*times.shape, 4), dtype=np.uint8)
    # The last few cells before a wall take for ever: they would eat up the whole scale.
    highest = max(float(np.quantile(times[known], 0.97)), 1e-6)
    bands = np.floor(_BANDS * np.clip(np.where(known, times, 0.0) / highest, 0.0, 0.999)) / _BANDS
    return _picture(np.where(known, bands, np.nan), palette)


def _finite(speed: Array) -> Array:
    """Speeds from 0 to 1, nan where nothing can go."""
    return np.where(speed > 0.0, np.clip(speed, 0.0, 1.0), np.nan)


def _picture(shares: Array, palette: Palette) -> NDArray[np.uint8]:
    """Shares `(rows, cols)` from 0 to 1 as colours, clear where they are nan."""
    step = max(1, int(np.ceil(max(shares.shape) / _MOST_PIXELS)))
    shares = shares[::step, ::step]
    low, high = (np.array(color, dtype=float) for color in palette.field)
    known = np.isfinite(shares)
    share = np.where(known, shares, 0.0)[..., None]
    picture = np.empty((*shares.shape, 4), dtype=np.uint8)
    picture[..., :3] = np.rint(low + share * (high - low))
    picture[..., 3] = np.where(known, _OPACITY, 0)
    return picture
