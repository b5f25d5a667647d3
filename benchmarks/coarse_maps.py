"""Teams on grid maps of streets and games with coarse cells: nobody may touch anything.

    python benchmarks/coarse_maps.py [MAP ...] [--cell 0.25] [--teams 4 8 16] [--seed 0]

Takes MovingAI maps, and draws more of their kinds, streets and caves, until there are `--maps` of
them. In each, teams in two rows go from one place to another that the shape fits into, through
ways that a robot fits into; the independent checker judges. Exit code 1 on any contact.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy import ndimage

from cavalcade.checking import check
from cavalcade.eikonal import TravelGrid, surface_distance
from cavalcade.geometry import Array, transform_points
from cavalcade.jobs.running import run
from cavalcade.metrics.summary import Summary
from cavalcade.world import OccupancyMap, load_movingai

SPACING = 1.0
"""m between robots."""
AROUND = 0.50
"""m that every slot keeps off obstacles at the start and at the goal."""
WAY = 0.45
"""m from the middle of a way to its sides, at least."""
LENGTHS = (15.0, 60.0)
"""m of way between start and goal."""


def streets(rng: np.random.Generator, size: int) -> NDArray[np.bool_]:
    """Blocks of houses of all sizes and headings, with streets and alleys between them."""
    y, x = np.mgrid[0:size, 0:size] + 0.5
    sites = rng.uniform(0.0, size, (max(size * size // 500, 4), 2))
    away = np.hypot(x[..., None] - sites[:, 0], y[..., None] - sites[:, 1])
    near = np.sort(away, axis=-1)[..., :2]
    return np.asarray(near[..., 1] - near[..., 0] > rng.uniform(4.0, 7.0))


def caves(rng: np.random.Generator, size: int) -> NDArray[np.bool_]:
    """Halls and passages with ragged walls, as in games: noise, smoothed by its neighbours."""
    rock = rng.random((size, size)) < 0.47
    for _ in range(5):
        rock = ndimage.uniform_filter(rock.astype(float), 3, mode="constant", cval=1.0) > 0.5
    return np.asarray(rock.repeat(2, axis=0).repeat(2, axis=1)[:size, :size])


def write_map(file: Path, occupied: NDArray[np.bool_]) -> Path:
    """A MovingAI file of a grid whose row 0 is at the bottom."""
    rows, cols = occupied.shape
    lines = ("".join("@" if cell else "." for cell in row) for row in occupied[::-1])
    head = f"type octile\nheight {rows}\nwidth {cols}\nmap\n"
    file.write_text(head + "\n".join(lines) + "\n", encoding="ascii")
    return file


def all_maps(given: list[Path], folder: Path, seed: int) -> Iterator[Path]:
    """The given maps, then drawn ones without end."""
    yield from given
    for k in count():
        draw = (streets, caves)[k % 2]
        rng = np.random.default_rng([seed, k])
        yield write_map(folder / f"{draw.__name__}-{k}.map", draw(rng, 128))


def in_two_rows(robots: int) -> Array:
    """Slots `(robots, 2)`, m."""
    across = (np.arange(robots // 2) - (robots // 2 - 1) / 2.0) * SPACING
    return np.array([(along, y) for along in (0.0, -SPACING) for y in across])


class Places:
    """Where a shape fits on a map, and how far it is from there to another such place."""

    def __init__(self, area: OccupancyMap) -> None:
        self._cell = area.resolution
        self._distance = surface_distance(area.occupied, self._cell)
        self._grid = TravelGrid((self._distance >= WAY).astype(float), self._cell)

    def pair(self, slots: Array, rng: np.random.Generator) -> tuple[Array, Array] | None:
        """A start and a goal with a way between them, None if none was found."""
        rows, cols = np.nonzero(self._distance >= WAY)
        for _ in range(200 if len(rows) else 0):
            start = self._fitting(slots, rng, rows, cols)
            if start is None:
                return None
            times = self._grid.field(start[:2]).times
            far = np.nonzero((times > LENGTHS[0]) & (times < LENGTHS[1]))
            goal = self._fitting(slots, rng, *far) if len(far[0]) else None
            if goal is not None:
                return start, goal
        return None

    def _fitting(
        self, slots: Array, rng: np.random.Generator, rows: Array, cols: Array
    ) -> Array | None:
        for _ in range(2000):
            k = rng.integers(len(rows))
            pose = np.array([cols[k] + 0.5, rows[k] + 0.5, 0.0]) * self._cell
            pose[2] = rng.uniform(-np.pi, np.pi)
            cells = np.floor(transform_points(pose, slots) / self._cell).astype(int)
            inside = ((cells >= 0) & (cells < self._distance.shape[::-1])).all()
            # The nearest centre may be farther off obstacles than the slot by this much.
            needed = AROUND + np.sqrt(0.5) * self._cell
            if inside and (self._distance[cells[:, 1], cells[:, 0]] >= needed).all():
                return pose
        return None


def scenario_of(
    file: Path, cell: float, slots: Array, ends: tuple[Array, Array]
) -> dict[str, object]:
    """What a scenario file says of a team in two rows."""
    start, goal = ends
    starts = np.column_stack([transform_points(start, slots), np.full(len(slots), start[2])])
    return {
        "version": 1,
        "name": f"{file.stem}-{len(slots)}",
        "world": {"movingai": {"file": str(file.resolve()), "resolution": cell}},
        "robots": [
            {"model": "go1", "start": [round(v, 4) for v in row]} for row in starts.tolist()
        ],
        "task": {
            "formation": {"shape": "custom", "slots": slots.tolist()},
            "goals": [[round(v, 4) for v in goal.tolist()]],
        },
        "execution": {"timeout": 600},
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path, metavar="MAP")
    parser.add_argument("--cell", type=float, default=0.25, help="size of a cell, m")
    parser.add_argument("--teams", type=int, nargs="+", default=[4, 8, 16])
    parser.add_argument("--maps", type=int, default=14)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    used, runs, arrived, touched = 0, 0, 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for index, file in enumerate(all_maps(options.files, folder, options.seed)):
            if used == options.maps:
                break
            places = Places(load_movingai(file, options.cell))
            teams = []
            for robots in options.teams:
                slots = in_two_rows(robots)
                rng = np.random.default_rng([options.seed, index, robots])
                ends = places.pair(slots, rng)
                if ends is None:
                    print(f"{file.stem:24} no way for a team of {robots}, left out", flush=True)
                    break
                teams.append(scenario_of(file, options.cell, slots, ends))
            if len(teams) < len(options.teams):
                continue
            used += 1
            for team in teams:
                summary, kinds = driven(team, folder)
                runs += 1
                arrived += summary.success
                touched += bool(kinds) or summary.reason == "collision"
                print(described(summary, kinds), flush=True)
    print(f"{used} maps, {runs} runs, {arrived} arrived, {touched} with contacts")
    return 1 if touched else 0


def driven(team: dict[str, object], folder: Path) -> tuple[Summary, list[str]]:
    """What came of a run, and what the checker found wrong."""
    source = folder / f"{team['name']}.yaml"
    source.write_text(yaml.safe_dump(team), encoding="utf-8")
    left = folder / source.stem
    result = run(str(source), left, figures=False, replay=False)
    return result.summary, [violation.kind for violation in check(left).violations]


def described(summary: Summary, kinds: list[str]) -> str:
    """One line."""
    lengths, bounds = summary.path_length_m, [b for b in summary.lower_bound_m if b is not None]
    longer = sum(lengths) / sum(bounds) if len(bounds) == len(lengths) else np.nan
    return (
        f"{summary.name:24} {summary.robots:2} robots: {summary.reason}"
        f" in {summary.sim_time_s:.1f} s, smallest gap {summary.min_footprint_gap_m:.3f} m,"
        f" {longer:.2f} x the shortest ways" + "".join(f", {kind}" for kind in kinds)
    )


if __name__ == "__main__":
    sys.exit(main())
