"""Arrival times against scikit-fmm (and eikonalfm, where installed): speed and error.

Everything runs in one process on one thread; the solvers take turns, so that a busy machine
slows all of them; the figures are medians. Error is measured where the exact answer is known.

    python benchmarks/bench_eikonal.py [--runs 15] [--quick]
"""

from __future__ import annotations

import os

# Before numpy and numba start their threads.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
import importlib.util
import statistics
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from velocity_maps import CELL, SIZES, free_cell_near, velocity_map

from cavalcade.eikonal import arrival_times

Grid = NDArray[np.float64]
Cell = tuple[int, int]
Solve = Callable[[], Grid]
Solver = Callable[[Grid, Cell], Solve]
"""From speeds and a source cell to the call that is timed."""


def ours(speed: Grid, source: Cell) -> Solve:
    return lambda: arrival_times(speed, [source], CELL)


def scikit_fmm(speed: Grid, source: Cell) -> Solve:
    import skfmm

    phi = np.ones(speed.shape)
    phi[source] = 0.0  # the front starts in the middle of this cell
    return lambda: skfmm.travel_time(phi, speed, dx=CELL, order=1)


def eikonalfm(speed: Grid, source: Cell) -> Solve:
    import eikonalfm

    everywhere = np.maximum(speed, 1e-6)  # it needs a speed above zero
    return lambda: eikonalfm.fast_marching(everywhere, source, (CELL, CELL), 1)


def solvers() -> dict[str, Solver]:
    """Those that are installed, ours first."""
    found: dict[str, Solver] = {"cavalcade": ours}
    if importlib.util.find_spec("skfmm"):
        found["scikit-fmm"] = scikit_fmm
    if importlib.util.find_spec("eikonalfm"):
        found["eikonalfm"] = eikonalfm
    return found


def take_turns(
    contestants: dict[str, Solver], speed: Grid, source: Cell, runs: int
) -> dict[str, float]:
    """Median seconds of each, after one call each that does not count."""
    seconds: dict[str, list[float]] = {name: [] for name in contestants}
    calls = {name: prepare(speed, source) for name, prepare in contestants.items()}
    for turn in range(runs + 1):
        for name, solve in calls.items():
            began = time.perf_counter()
            solve()
            if turn:
                seconds[name].append(time.perf_counter() - began)
    return {name: statistics.median(values) for name, values in seconds.items()}


def exact_problems(rows: int, cols: int) -> dict[str, tuple[Grid, Cell, Grid]]:
    """Speed, source and exact arrival times of problems that have a closed solution."""
    source = (rows // 2, cols // 3)
    y, x = np.mgrid[:rows, :cols] * CELL
    dy, dx = y - source[0] * CELL, x - source[1] * CELL
    away = np.hypot(dx, dy)
    even = np.ones((rows, cols))
    gradient = np.array([0.05, 0.03]) * 14.0 / (cols * CELL)
    sloped = 1.0 + gradient[0] * dx + gradient[1] * dy
    steep = float(gradient @ gradient)
    rays = np.arccosh(1.0 + steep * away**2 / (2.0 * sloped)) / np.sqrt(steep)
    return {"constant speed": (even, source, away), "linear speed": (sloped, source, rays)}


def report_speed(contestants: dict[str, Solver], runs: int, sizes: tuple[Cell, ...]) -> None:
    print(f"FM2 velocity maps, median of {runs} runs, one thread")
    for rows, cols in sizes:
        speed = velocity_map(rows, cols)
        source = free_cell_near(speed, rows // 2, cols - round(1.4 / CELL))
        reached = float(np.isfinite(contestants["cavalcade"](speed, source)()).mean())
        line = f"  {cols:4d} x {rows:4d}, {reached:.0%} of the cells reached:"
        # Peers take turns with us one at a time: what one leaves of the memory is not the other's.
        for name, prepare in contestants.items():
            if name == "cavalcade":
                continue
            pair = {"cavalcade": contestants["cavalcade"], name: prepare}
            medians = take_turns(pair, speed, source, runs)
            ratio = medians[name] / medians["cavalcade"]
            line += f" {name} {1e3 * medians[name]:8.2f} ms, cavalcade "
            line += f"{1e3 * medians['cavalcade']:7.2f} ms, ratio {ratio:5.2f};"
        print(line, flush=True)


def report_error(contestants: dict[str, Solver], sizes: tuple[Cell, ...]) -> None:
    print("Error against the exact solution of a point source, in units of a cell at full speed")
    for rows, cols in sizes:
        for problem, (speed, source, exact) in exact_problems(rows, cols).items():
            for name, prepare in contestants.items():
                wrong = np.abs(prepare(speed, source)() - exact) / CELL
                print(
                    f"  {cols:4d} x {rows:4d}, {problem}: {name:10s} "
                    f"mean {wrong.mean():7.4f}, largest {wrong.max():7.4f}",
                    flush=True,
                )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--runs", type=int, default=15, help="timed runs of each solver")
    parser.add_argument("--quick", action="store_true", help="only the arena's size")
    options = parser.parse_args()
    contestants = solvers()
    for name in ("scikit-fmm", "eikonalfm"):
        if name not in contestants:
            print(f"{name} is not installed and left out")
    sizes = SIZES[:1] if options.quick else SIZES
    report_speed(contestants, options.runs, sizes)
    report_error(contestants, sizes)


if __name__ == "__main__":
    main()
