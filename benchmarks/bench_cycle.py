"""One cycle of the formation planner against one scikit-fmm solve of the same map.

The team crosses the map in simulated time; every cycle is timed, and now and then scikit-fmm
solves the leader's velocity map once in between, in the same process and on one thread.

    python benchmarks/bench_cycle.py [--robots 4 16] [--solves 15]
"""

from __future__ import annotations

import os

# Before numpy and numba start their threads.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
import importlib.util
import time

import numpy as np
from bench_eikonal import scikit_fmm
from numpy.typing import NDArray
from velocity_maps import CELL, free_cell_near, velocity_map

from cavalcade.fleet.ideal import IdealFleet
from cavalcade.formation import Formation, FormationPlanner
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap
from cavalcade.world.generators import generate

SIZE = (14.0, 10.0)
RATE = 20.0
LONGEST = 120.0
"""s of simulated time"""


def arena(seed: int) -> OccupancyMap:
    """A feasible world of 25 obstacles."""
    world = generate("clutter", SIZE, seed, obstacles=25, require_feasible=True)
    return OccupancyMap.empty(SIZE, CELL).with_shapes(world.shapes)


def team(robots: int) -> tuple[Formation, NDArray[np.float64]]:
    """A formation and start poses `(robots, 3)`: a square, or rows of four."""
    if robots == 4:
        places = np.array([[2.2, 5.0], [1.4, 5.9], [1.4, 4.1], [0.6, 5.0]])
        return Formation.square(1.0), np.column_stack((places, np.zeros(4)))
    ranks = np.arange(robots) // 4
    files = np.arange(robots) % 4
    slots = np.column_stack((-0.72 * ranks, 0.8 * (files - 1.5)))
    slots -= slots.mean(axis=0)
    poses = np.column_stack((slots + np.array((1.55, 5.0)), np.zeros(robots)))
    return Formation.custom(slots.tolist()), poses


def crossing(robots: int, seed: int, solves: int) -> tuple[NDArray[np.float64], list[float], bool]:
    """Seconds of every cycle and of every scikit-fmm solve, and whether the team arrived."""
    world = arena(seed)
    formation, poses = team(robots)
    planner = FormationPlanner(world, formation, robots=robots, model="go1", rate=RATE, seed=seed)
    planner.set_goal((12.5, 5.0, 0.0))
    fleet = IdealFleet([robot_model("go1")] * robots, poses)
    speed = velocity_map(world.rows, world.cols)
    source = free_cell_near(speed, world.rows // 2, world.cols - 28)
    peer = scikit_fmm(speed, source) if importlib.util.find_spec("skfmm") else None
    cycles: list[float] = []
    solved: list[float] = []
    every = int(40.0 * RATE / max(solves, 1))
    while fleet.time < LONGEST and not planner.status.arrived:
        began = time.perf_counter()
        command = planner.step(fleet.observe().poses, fleet.time)
        cycles.append(time.perf_counter() - began)
        fleet.send(command)
        fleet.advance(1.0 / RATE)
        if peer is not None and len(cycles) % every == 0:
            began = time.perf_counter()
            peer()
            solved.append(time.perf_counter() - began)
    return np.array(cycles), solved, planner.status.arrived


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robots", type=int, nargs="+", default=[4, 16])
    parser.add_argument("--solves", type=int, default=15, help="scikit-fmm solves per 40 s")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    for robots in options.robots:
        crossing(robots, options.seed, 0)  # compile
        cycles, solved, arrived = crossing(robots, options.seed, options.solves)
        median, p99 = np.percentile(cycles, [50, 99])
        state = "arrived" if arrived else "not arrived"
        print(
            f"{robots} robots on 280 x 200 cells, {len(cycles)} cycles ({state}): "
            f"median {1e3 * median:.2f} ms, p99 {1e3 * p99:.2f} ms, "
            f"max {1e3 * cycles.max():.2f} ms"
        )
        if solved:
            peer = float(np.median(solved))
            print(
                f"  one scikit-fmm solve: {1e3 * peer:.2f} ms (median of {len(solved)}); "
                f"cycle / solve: median {median / peer:.3f}, p99 {p99 / peer:.3f}"
            )


if __name__ == "__main__":
    main()
