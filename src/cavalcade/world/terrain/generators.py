"""Seeded terrains of several kinds: `generate_terrain("gap", (9, 4), seed=0, width=0.4)`.

All lie along x: what has to be crossed spans the whole width, and the ground near the left and
the right edge is level.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.world.generators.model import check_options, count, number, options_of
from cavalcade.world.occupancy import grid_shape
from cavalcade.world.terrain.terrain import RESOLUTION, Terrain, check_terrain_size, checked_cell

_EDGE = 1e-9
"""Cells whose centre lies on an edge but for rounding are on its far side, m."""

Heights = Callable[..., Array]
"""Takes a `Site` and, by keyword, its options; gives heights `(rows, cols)` m."""


class Site(NamedTuple):
    """What a terrain is drawn on.

    Attributes:
        x, y: `(1, cols)`, `(rows, 1)` m, of the cells' centres.
        size: Width (x) and height (y), m.
        rng: Source of all randomness.
    """

    x: Array
    y: Array
    size: tuple[float, float]
    rng: np.random.Generator


def gap(site: Site, *, width: float = 0.4, depth: float = 1.0, at: float | None = None) -> Array:
    """A pit across the whole width.

    Args:
        width: Along x, m.
        depth: m.
        at: x of its middle, m; by default that of the terrain.
    """
    width, depth = number("width", width, 0.0, 1.0), number("depth", depth, 0.5, 100.0)
    middle = _place(site, at, width / 2.0)
    inside = (site.x >= middle - width / 2.0 - _EDGE) & (site.x < middle + width / 2.0 - _EDGE)
    return np.where(inside, -depth, 0.0) + 0.0 * site.y


def step(site: Site, *, height: float = 0.25, at: float | None = None) -> Array:
    """One step up (down if negative) across the whole width.

    Args:
        height: m.
        at: x of its edge, m; by default the middle of the terrain.
    """
    height = number("height", height, -10.0, 10.0)
    return np.where(site.x >= _place(site, at, 0.0) - _EDGE, height, 0.0) + 0.0 * site.y


def stairs(
    site: Site, *, steps: int = 5, height: float = 0.1, tread: float = 0.4, at: float | None = None
) -> Array:
    """A flight of stairs up (down if negative) across the whole width.

    Args:
        steps: How many edges.
        height: Of each, m.
        tread: Depth of each, m.
        at: x of its middle, m; by default that of the terrain.
    """
    steps = count("steps", steps, 1, 1000)
    height, tread = number("height", height, -10.0, 10.0), number("tread", tread, 0.05, 100.0)
    half = (steps - 1) * tread / 2.0
    first = _place(site, at, half) - half
    number_of = np.clip(np.floor((site.x - first + _EDGE) / tread) + 1.0, 0.0, steps)
    return height * number_of + 0.0 * site.y


def slope(
    site: Site, *, angle: float = 0.35, length: float = 2.0, at: float | None = None
) -> Array:
    """A ramp up (down if negative) across the whole width.

    Args:
        angle: Inclination, rad.
        length: Seen from above, m.
        at: x of its middle, m; by default that of the terrain.
    """
    angle, length = number("angle", angle, -1.0, 1.0), number("length", length, 0.05)
    first = _place(site, at, length / 2.0) - length / 2.0
    return math.tan(angle) * np.clip(site.x - first, 0.0, length) + 0.0 * site.y


def rough(site: Site, *, height: float = 0.25, spacing: float = 0.4, zone: float = 1.0) -> Array:
    """Hills and hollows: random heights at the nodes of a grid, joined smoothly.

    Args:
        height: Between the lowest and the highest point, m.
        spacing: Of the nodes, m.
        zone: Level ground at the left and the right edge, m.
    """
    height = number("height", height, 0.0, 10.0)
    zone, spacing = number("zone", zone, 0.0, site.size[0] / 2.0), number("spacing", spacing, 0.2)
    cols, rows = math.ceil(site.size[0] / spacing) + 1, math.ceil(site.size[1] / spacing) + 1
    check_terrain_size(max(rows, 2), max(cols, 2), "spacing")
    nodes = site.rng.uniform(0.0, 1.0, (rows, cols))
    u, v = site.x / spacing, site.y / spacing
    i, j = np.floor(v).astype(int), np.floor(u).astype(int)
    s, t = _smooth(u - j), _smooth(v - i)
    low = nodes[i, j] + s * (nodes[i, j + 1] - nodes[i, j])
    high = nodes[i + 1, j] + s * (nodes[i + 1, j + 1] - nodes[i + 1, j])
    ground = low + t * (high - low)
    ground = (ground - ground.min()) / max(float(np.ptp(ground)), 1e-12)
    edge = np.minimum(site.x, site.size[0] - site.x) - zone
    return height * ground * _smooth(np.clip(edge / spacing, 0.0, 1.0))


def blocks(site: Site, *, height: float = 0.05, side: float = 0.25, zone: float = 1.0) -> Array:
    """Square blocks of random heights, side by side.

    Args:
        height: Of the highest at most, m.
        side: Of each block, m.
        zone: Level ground at the left and the right edge, m.
    """
    height, side = number("height", height, 0.0, 10.0), number("side", side, 0.05)
    zone = number("zone", zone, 0.0, site.size[0] / 2.0)
    rows, cols = math.ceil(site.size[1] / side) + 1, math.ceil(site.size[0] / side) + 1
    check_terrain_size(max(rows, 2), max(cols, 2), "side")
    lift = site.rng.uniform(0.0, height, (rows, cols))
    i, j = (np.floor(along / side + _EDGE).astype(int) for along in (site.y, site.x))
    return np.where((site.x < zone) | (site.x >= site.size[0] - zone - _EDGE), 0.0, lift[i, j])


def stepping_stones(
    site: Site,
    *,
    stone: float = 0.8,
    width: float = 0.15,
    height: float = 0.05,
    depth: float = 1.0,
    zone: float = 1.5,
) -> Array:
    """Square stones in rows with pits between them; neighbouring rows are shifted at random.

    Args:
        stone: Side of a stone, m.
        width: Of the pits between them, m.
        height: Stones differ in height by at most this much, m.
        depth: Of the pits, m.
        zone: Level ground at the left and the right edge, m.
    """
    stone, width = number("stone", stone, 0.1), number("width", width, 0.0, 1.0)
    height, depth = number("height", height, 0.0, 1.0), number("depth", depth, 0.5, 100.0)
    zone = number("zone", zone, 0.0, site.size[0] / 2.0)
    pitch = stone + width
    rows = max(math.ceil((site.size[0] - 2.0 * zone) / pitch), 1)
    stones = math.ceil(site.size[1] / pitch) + 2
    check_terrain_size(max(rows, 2), stones, "stone")
    shift = site.rng.uniform(0.0, pitch, rows)
    lift = site.rng.uniform(-height / 2.0, height / 2.0, (rows, stones))
    # A pit comes first, so that the band ends with one as well or with part of a stone.
    along = site.x - zone + _EDGE
    row = np.clip(np.floor(along / pitch), 0, rows - 1).astype(int)
    across = site.y + shift[row] + _EDGE
    index = np.floor(across / pitch).astype(int)
    pit = (along - row * pitch < width) | (across - index * pitch < width)
    ground = np.where(pit, -depth, lift[row, index])
    return np.where((along < 0.0) | (site.x >= site.size[0] - zone - _EDGE), 0.0, ground)


TERRAINS: Mapping[str, Heights] = MappingProxyType(
    {
        "blocks": blocks,
        "gap": gap,
        "rough": rough,
        "slope": slope,
        "stairs": stairs,
        "step": step,
        "stepping-stones": stepping_stones,
    }
)
"""Kind to its generator."""


def generate_terrain(
    kind: str, size: Sequence[float], seed: int = 0, resolution: float = RESOLUTION, **options: Any
) -> Terrain:
    """Draw a terrain; the same arguments give the same terrain.

    Args:
        kind: `blocks`, `gap`, `rough`, `slope`, `stairs`, `step` or `stepping-stones`.
        size: Width (x) and height (y), m; the lower left corner is (0, 0).
        seed: Not negative; only `blocks`, `rough` and `stepping-stones` depend on it.
        resolution: Side of its cells, m.
        options: Of the kind; see its function.

    Raises:
        InputError: An unknown kind or option, or a value out of range; its key says which.
    """
    check_options(kind, TERRAINS, options)
    cell = checked_cell(resolution)
    rows, cols = grid_shape(size, cell)
    check_terrain_size(rows, cols, "size")
    rng = np.random.default_rng(np.random.SeedSequence(count("seed", seed, 0, 2**63 - 1)))
    x = (np.arange(cols, dtype=float)[None, :] + 0.5) * cell
    y = (np.arange(rows, dtype=float)[:, None] + 0.5) * cell
    site = Site(x, y, (float(size[0]), float(size[1])), rng)
    return Terrain.from_heights(TERRAINS[kind](site, **options), cell)


def terrain_options(kind: str) -> dict[str, Any]:
    """The names of a kind's options and their defaults."""
    return options_of(TERRAINS[kind])


def _place(site: Site, at: float | None, reach: float) -> float:
    """The place along x of something that reaches `reach` to both sides of it."""
    if site.size[0] <= 2.0 * reach:
        raise InputError(f"{site.size[0]:g} m are too short for what lies across", key="size")
    return site.size[0] / 2.0 if at is None else number("at", at, reach, site.size[0] - reach)


def _smooth(part: Array) -> Array:
    """From 0 to 1 without a kink at the ends."""
    return part * part * (3.0 - 2.0 * part)
