"""What a user waits for, beside its limit: the first word, maps, terrain, refusals, figures.

Each time is the least of a few runs in this process, after one that compiles what is needed; the
first word is that of a process of its own.

    python benchmarks/bench_waits.py
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import cavalcade as cv
from cavalcade.execution.precedence import Precedence
from cavalcade.geometry.trajectory import WALK, Trajectory

RUNS = 3


def quickest(work: Callable[[], object]) -> float:
    """Least wall time of a few runs, s, after one that is not counted."""
    work()
    times = []
    for _ in range(RUNS):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return min(times)


def first_word() -> object:
    command = [sys.executable, "-m", "cavalcade", "scenarios"]
    return subprocess.run(command, check=True, capture_output=True)


def loading(folder: Path, image: str) -> Callable[[], object]:
    """A map of 2,000 x 2,000 cells."""
    cells = np.random.default_rng(0).choice(np.array([0, 100, -1], dtype=np.int8), (2000, 2000))
    file = folder / f"{image}.yaml"
    cv.save_map(cv.OccupancyMap(cells, 0.05), file, image)
    return lambda: cv.load_map(file)


def hectare() -> Callable[[], object]:
    """Terrain of 600 x 600 cells with a hole."""
    heights = np.random.default_rng(0).uniform(0.0, 0.3, (600, 600))
    heights[100:130, 200:260] = np.nan
    return lambda: cv.Terrain.from_heights(heights)


def mesh(folder: Path) -> Callable[[], object]:
    """A binary STL of 180,000 triangles over 30 m x 30 m."""
    axis = np.linspace(0.0, 30.0, 301)
    x, y = np.meshgrid(axis, axis)
    grid = np.stack([x, y, 0.2 * np.sin(x) * np.sin(y)], axis=2)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    corners = np.concatenate(
        [np.stack(three, axis=2).reshape(-1, 3, 3) for three in ((a, b, c), (a, c, d))]
    )
    record = np.zeros(
        len(corners), dtype=[("normal", "<f4", 3), ("at", "<f4", (3, 3)), ("x", "<u2")]
    )
    record["at"] = corners
    file = folder / "hills.stl"
    file.write_bytes(b"".join((bytes(80), np.uint32(len(corners)).tobytes(), record.tobytes())))
    return lambda: cv.load_terrain(file)


def refusal() -> Callable[[], object]:
    """Two robots, one of them in a closed room on a map of 20 m x 20 m."""
    walls = [
        cv.Box((10.0, 8.1), (4.0, 0.2)),
        cv.Box((10.0, 11.9), (4.0, 0.2)),
        cv.Box((8.1, 10.0), (0.2, 4.0)),
        cv.Box((11.9, 10.0), (0.2, 4.0)),
    ]
    world = cv.OccupancyMap.empty((20.0, 20.0)).with_shapes(walls)
    starts, goals = [(10.0, 10.0, 0.0), (5.0, 5.0, 0.0)], [(2.0, 2.0, 0.0), (7.0, 3.0, 0.0)]
    problem = cv.TeamProblem.on_map(world, ("spirit", "spirit"), starts, goals)

    def refused() -> None:
        if cv.plan_team(problem, "auto").reason != "infeasible":
            raise RuntimeError("it was not refused")

    return refused


def order_of_eight() -> Callable[[], object]:
    """Who goes first where eight plans of 25 s cross."""
    rng = np.random.default_rng(1)
    paths = []
    for _ in range(8):
        points = rng.uniform(0.0, 8.0, (8, 2))
        legs = np.hypot(*np.diff(points, axis=0).T) / 0.6
        marks = np.concatenate([[0.0], np.cumsum(legs)])
        fine = np.unique(np.concatenate([np.arange(0.0, marks[-1], 0.025), marks]))
        at = [np.interp(fine, marks, column) for column in points.T]
        position = np.column_stack([*at, 0.0 * fine])
        phase = np.full(len(fine), WALK, dtype=np.int8)
        velocity = np.gradient(position, fine, axis=0)
        paths.append(Trajectory(fine, position, velocity, 0.1 * fine, phase))
    return lambda: Precedence(paths, [cv.robot_model("go1")] * 8, 0.5)


def figures(folder: Path) -> Callable[[], object]:
    """The figures of a run through the arena."""
    from cavalcade.drawing.figures import make_figures

    done = cv.run("square-clutter")
    place = folder / "figures"
    return lambda: make_figures(done.scenario, done.world, place, recording=done.recording)


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        waits = [
            ("the first word of `cavalcade scenarios`", first_word, 1.0),
            ("loading a PGM map of 2,000 x 2,000 cells", loading(folder, "pgm"), 1.0),
            ("loading a PNG map of 2,000 x 2,000 cells", loading(folder, "png"), 1.0),
            ("terrain of 600 x 600 cells", hectare(), 3.0),
            ("a mesh of 180,000 triangles", mesh(folder), 3.0),
            ("refusing a goal that is walled off", refusal(), 0.1),
            ("the order of eight crossing plans", order_of_eight(), 1.5),
            ("the figures of a run", figures(folder), 20.0),
        ]
        met = True
        for what, work, limit in waits:
            seconds = quickest(work)
            met &= seconds <= limit
            word = "" if seconds <= limit else "  MISSED"
            print(f"{what}: {seconds:.3f} s (limit {limit:g} s){word}")
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
