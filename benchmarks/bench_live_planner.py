"""Cycles of a live planner while goals, shapes and maps change: ten robots in a large office.

The team is driven at 20 Hz in real time on a map of 1,000,000 cells. Every 0.3 s a second thread
asks for another goal, shape or map, at random. Every call of `step` is timed; with `--batch` of a
planner that works out all that follows from a change before it goes on.

    python benchmarks/bench_live_planner.py [--seconds 60] [--batch]
"""

from __future__ import annotations

import os

# Before numpy and numba start their threads.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
import gc
import sys
import threading
import time

import numpy as np
from numpy.typing import NDArray

import cavalcade as cv
from cavalcade.fleet.ideal import IdealFleet

SIZE = (62.5, 40.0)
ROBOTS = 10
PERIOD = 0.05
EVERY = 0.3
"""s between two changes"""
LIMIT = 0.025
"""s that a cycle of a live planner may take"""


def office() -> cv.OccupancyMap:
    """Corridors 3 m wide between rows of rooms of 6 m by 6 m, with doors 1.6 m wide."""
    walls = []
    for low in (3.0, 18.0):
        for left in np.arange(3.0, 57.0, 6.0):
            walls.append(cv.Box((left + 3.0, low + 6.0), (6.0, 0.15)))
            for door in (low, low + 12.0):
                walls += [cv.Box((left + side, door), (2.2, 0.15)) for side in (1.1, 4.9)]
        walls += [cv.Box((x, low + 6.0), (0.15, 12.0)) for x in np.arange(3.0, 57.5, 6.0)]
    return cv.OccupancyMap.empty(SIZE, 0.05).with_shapes(walls)


class Changes(threading.Thread):
    """Asks for something else every now and then."""

    def __init__(self, planner: cv.FormationPlanner, seed: int) -> None:
        super().__init__(name="changes")
        self._planner = planner
        self._rng = np.random.default_rng(seed)
        self._bare = office()
        block = [(-0.9 * (k // 2), 0.9 * (k % 2) - 0.45) for k in range(ROBOTS)]
        self._shapes = [
            cv.Formation.column(ROBOTS, 0.9),
            cv.Formation.custom(block),
            cv.Formation.wedge(ROBOTS, 1.0),
        ]
        self.over = threading.Event()
        self.calls: list[float] = []
        self.error: Exception | None = None

    def run(self) -> None:
        """Until it is over."""
        try:
            while not self.over.wait(EVERY):
                self._change()
        except Exception as error:
            self.error = error

    def _change(self) -> None:
        rng, planner = self._rng, self._planner
        kind = rng.choice(["goal", "shape", "map"])
        x, y, yaw = rng.uniform((2.0, 1.0, -3.1), (60.0, 39.0, 3.1))
        crates = [cv.Box(place, (0.6, 0.6)) for place in rng.uniform((9.0, 4.0), SIZE, (3, 2))]
        world = self._bare.with_shapes(crates)
        began = time.perf_counter()
        if kind == "goal":
            planner.set_goal((x, y, yaw))
        elif kind == "shape":
            planner.set_formation(self._shapes[rng.integers(len(self._shapes))])
        else:
            planner.update_map(world)
        self.calls.append(time.perf_counter() - began)


def drive(seconds: float, live: bool, seed: int) -> tuple[NDArray[np.float64], list[float], float]:
    """Seconds `(cycles, 2)` of wall and of processor, of every call beside, and metres driven."""
    shape = cv.Formation.column(ROBOTS, 0.9)
    planner = cv.FormationPlanner(office(), shape, rate=1.0 / PERIOD, seed=seed, live=live)
    cv.warm_up(planner)
    gc.collect()
    gc.freeze()
    poses = np.column_stack([shape.placed((6.0, 1.5, 0.0)), np.zeros(ROBOTS)])
    fleet = IdealFleet([cv.robot_model("go1")] * ROBOTS, poses)
    planner.set_goal((55.0, 16.5, 0.0))
    planner.step(fleet.observe().poses, -1.0)
    changes = Changes(planner, seed)
    changes.start()
    cycles = []
    driven = 0.0
    began = due = time.perf_counter()
    while due - began < seconds and changes.is_alive():
        before = fleet.observe().poses
        start, busy = time.perf_counter(), time.thread_time()
        commands = planner.step(before, start - began)
        cycles.append((time.perf_counter() - start, time.thread_time() - busy))
        fleet.send(commands)
        fleet.advance(PERIOD)
        driven += float(np.hypot(*(fleet.observe().poses - before)[:, :2].T).mean())
        due += PERIOD
        time.sleep(max(0.0, due - time.perf_counter()))
    changes.over.set()
    changes.join()
    if changes.error is not None:
        raise changes.error
    return np.array(cycles), changes.calls, driven


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--batch", action="store_true", help="not live, for comparison")
    options = parser.parse_args()
    sys.setswitchinterval(0.0005)
    cycles, calls, driven = drive(options.seconds, not options.batch, options.seed)
    missed = int((cycles[:, 0] > LIMIT).sum())
    print(
        f"{len(cycles)} cycles of {ROBOTS} robots, {driven:.1f} m; {missed} over {1e3 * LIMIT:g} ms"
    )
    for what, seconds in zip(("wall time", "processor"), cycles.T, strict=True):
        middle, most, rare, worst = 1e3 * np.percentile(seconds, [50, 99, 99.9, 100])
        print(
            f"  {what}: median {middle:.2f} ms, p99 {most:.2f} ms, p99.9 {rare:.2f} ms, "
            f"max {worst:.2f} ms"
        )
    print(f"{len(calls)} calls from another thread: max {1e3 * max(calls):.1f} ms")
    return 0 if options.batch or missed == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
