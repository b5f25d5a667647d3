"""The body planner's parts, and the whole of it against OMPL's RRT-Connect, where installed.

Everything runs in one process on one thread; the planners take turns on the same problems, so
that a busy machine slows both; numbers are medians. OMPL plans a path without time in SE(2)
(x, y, yaw; motions turn while they go along a straight line) for the same oriented footprint on
the same occupancy map, both with our test of a footprint, compiled; its longest step between
tests is ours, 2.25 cm (walking speed times dt), and it stops at its first path, which is not
shortened. Ours is the timed motion of a quadruped, shortened.

    python benchmarks/bench_body.py [--problems 100] [--quick]
"""

from __future__ import annotations

import os

# Before numpy and numba start their threads.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
import importlib.util
import math
import statistics
import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numba import njit

from cavalcade.kinodynamic._leap_over_barrier import Line, find_barrier, leap_over
from cavalcade.kinodynamic._validity import solid_free, state_problem
from cavalcade.kinodynamic.obstruction import obstruction
from cavalcade.kinodynamic.parameters import SIZE, StateSpace, make_body, make_space
from cavalcade.kinodynamic.planner import plan_body
from cavalcade.kinodynamic.settings import BodySettings
from cavalcade.lattice.ground import Ground, make_ground
from cavalcade.lattice.surface import surface
from cavalcade.robots import robot_model
from cavalcade.world import OccupancyMap, generate, rasterise
from cavalcade.world.terrain import generate_terrain

NO_DISCS = np.zeros((0, 3))
CELL = 0.05
STEP = 0.0225
"""Longest step between OMPL's tests: what our robot walks in dt, m."""

Pose = tuple[float, float, float]
Problem = tuple[Ground, Pose, Pose]


def rough_ground() -> Ground:
    terrain = generate_terrain("rough", (10.0, 8.0), seed=0)
    return make_ground(OccupancyMap(np.zeros(terrain.height.shape, bool), CELL), terrain)


@njit
def _check_all(space, states, yaws, phases):
    good = 0
    for k in range(len(states)):
        if state_problem(space, states[k], yaws[k, 0], yaws[k, 1], phases[k]) == 0:
            good += 1
    return good


@njit
def _leap_all(space, line, barrier, count, rng):
    leap, scratch = np.empty(SIZE), np.empty(12)
    good = 0
    for k in range(count):
        if leap_over(space, line, barrier, 12 + k, rng, leap, scratch):
            good += 1
    return good


def parts() -> None:
    """Time of a state check, and of a leap sampled, laid out and checked."""
    body = make_body(robot_model("spirit"), margin=0.01)
    rng = np.random.default_rng(0)
    ground = rough_ground()
    space = make_space(ground, body)
    count = 20_000
    states, yaws = np.zeros((count, 6)), np.empty((count, 2))
    for k in range(count):
        x, y, yaw = rng.uniform(0.5, 9.5), rng.uniform(0.5, 7.5), rng.uniform(-math.pi, math.pi)
        z = surface(ground, x, y)[0] + body.h_nom
        c, s = math.cos(yaw), math.sin(yaw)
        states[k, :5], yaws[k] = (x, y, z, 0.75 * c, 0.75 * s), (c, s)
    phases = rng.integers(0, 4, count)
    good = _check_all(space, states, yaws, phases)
    seconds = [_timed(lambda: _check_all(space, states, yaws, phases)) for _ in range(15)]
    print(
        f"A state check on rough ground, all phases: {1e6 * statistics.median(seconds) / count:.3f}"
        f" us ({good / count:.0%} valid; at most 1 us is asked for)"
    )
    for kind, options in (("gap", {"width": 0.4}), ("step", {"height": 0.25})):
        terrain = generate_terrain(kind, (9.0, 4.0), **options)
        ground = make_ground(OccupancyMap(np.zeros(terrain.height.shape, bool), CELL), terrain)
        space, line = make_space(ground, body), Line(2.0, 2.0, 1.0, 0.0)
        barrier = find_barrier(space, line, 2.0, False)
        state = np.array([1], dtype=np.uint64)
        count = 2_000
        arguments = (space, line, barrier, count, state)
        good = _leap_all(*arguments)
        seconds = [_timed(lambda: _leap_all(*arguments)) for _ in range(15)]  # noqa: B023
        print(
            f"A leap with its checks, {kind}: {1e6 * statistics.median(seconds) / count:.2f} us"
            f" ({good / count:.0%} valid; at most 30 us is asked for)"
        )


def flat_plan(runs: int) -> None:
    ground = make_ground(OccupancyMap(np.zeros((80, 180), bool), CELL))
    model = robot_model("spirit")
    rng = np.random.default_rng(0)
    plan_body(ground, model, (2, 2, 0), (7, 2, 0))
    seconds = []
    for seed in range(runs):
        y = rng.uniform(0.6, 3.4, 2)
        start, goal = (2.0, y[0], rng.uniform(-3, 3)), (7.0, y[1], rng.uniform(-3, 3))
        seconds.append(_timed(lambda: plan_body(ground, model, start, goal, seed=seed)))  # noqa: B023
    print(
        f"A plan of 5 m over flat ground, with shortening and samples: "
        f"{1e3 * statistics.median(seconds):.3f} ms (at most 1 ms is asked for)"
    )


def clutter(count: int, kind: str) -> list[Problem]:
    """Problems between random free poses at least 6 m apart in generated worlds."""
    model = robot_model("go1")
    body = make_body(model, margin=0.01)
    problems: list[Problem] = []
    for seed in range(count):
        world = generate(kind, (14.0, 10.0), seed=seed)
        ground = make_ground(OccupancyMap(rasterise(world.shapes, 200, 280, CELL), CELL))
        space = make_space(ground, body)
        rng = np.random.default_rng(seed)
        poses: list[Pose] = []
        for _ in range(10_000):
            pose = (rng.uniform(0.0, 14.0), rng.uniform(0.0, 10.0), rng.uniform(-math.pi, math.pi))
            if obstruction(space, pose):
                continue
            if not poses or math.dist(pose[:2], poses[0][:2]) > 6.0:
                poses.append(pose)
            if len(poses) == 2:
                problems.append((ground, *poses))
                break
    return problems


@njit
def _footprint_free(cell, solid, clearance, body, x, y, yaw):
    ground = Ground(
        cell, solid, clearance, True, clearance, clearance, clearance, clearance, clearance
    )
    space = StateSpace(ground, body, NO_DISCS)
    return solid_free(space, x, y, math.cos(yaw), math.sin(yaw))


@njit
def _footprints_free(cell, solid, clearance, body, poses):
    good = 0
    for k in range(len(poses)):
        if _footprint_free(cell, solid, clearance, body, poses[k, 0], poses[k, 1], poses[k, 2]):
            good += 1
    return good


class Ompl:
    """OMPL's RRT-Connect in SE(2) on one problem; counts its tests of states."""

    def __init__(self, problem: Problem, seed: int) -> None:
        from ompl import base

        ground, *ends = problem
        self.seed, self.checks = seed, 0
        self.solid, self.clearance = ground.solid, ground.clearance
        self.body = make_body(robot_model("go1"), margin=0.01)
        self.space = base.SE2StateSpace()
        bounds = base.RealVectorBounds(2)
        rows, cols = ground.solid.shape
        for k, high in enumerate((cols * CELL, rows * CELL)):
            bounds.setLow(k, 0.0)
            bounds.setHigh(k, high)
        self.space.setBounds(bounds)
        self.space.setLongestValidSegmentFraction(STEP / self.space.getMaximumExtent())
        self.ends = []
        for x, y, yaw in ends:
            state = self.space.allocState()
            state.setXY(x, y)
            state.setYaw(yaw)
            self.ends.append(state)

    def valid(self, state) -> bool:
        """Whether OMPL's state is valid."""
        return _footprint_free(
            CELL,
            self.solid,
            self.clearance,
            self.body,
            state.getX(),
            state.getY(),
            state.getYaw(),
        )

    def counted(self, state) -> bool:
        """The same, counted."""
        self.checks += 1
        return self.valid(state)

    def solve(self, counting: bool = False) -> float | None:
        """The length of the path in x and y, m; None without one."""
        from ompl import geometric, util

        util.RNG.setSeed(self.seed + 1)
        setup = geometric.SimpleSetup(self.space)
        setup.setStateValidityChecker(self.counted if counting else self.valid)
        setup.setStartAndGoalStates(*self.ends)
        setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
        setup.solve(10.0)
        if not setup.haveExactSolutionPath():
            return None
        states = setup.getSolutionPath().getStates()
        points = [(state.getX(), state.getY()) for state in states]
        return sum(math.dist(a, b) for a, b in pairwise(points))

    def callback_overhead(self) -> float:
        """What a test costs more when it is called from Python than in compiled code, s."""
        count = 20_000
        rng = np.random.default_rng(0)
        rows, cols = self.solid.shape
        poses = rng.uniform((0, 0, -3), (cols * CELL, rows * CELL, 3), (count, 3))
        state = self.ends[0]

        def by_python() -> None:
            for _ in range(count):
                self.valid(state)

        same = np.tile([state.getX(), state.getY(), state.getYaw()], (count, 1))
        arguments = (CELL, self.solid, self.clearance, self.body)
        _footprints_free(*arguments, poses)
        return (_timed(by_python) - _timed(lambda: _footprints_free(*arguments, same))) / count


def against_ompl(count: int) -> None:
    from ompl import util

    util.noOutputHandler()
    model = robot_model("go1")
    for kind in ("clutter", "forest", "rooms"):
        ours: list[float] = []
        theirs: list[float] = []
        compiled: list[float] = []
        lengths: list[tuple[float, float]] = []
        unsolved = [0, 0]
        overhead = None
        for number, problem in enumerate(clutter(count, kind)):
            ground, start, goal = problem
            other = Ompl(problem, number)
            if overhead is None:
                other.solve()
                plan_body(ground, model, start, goal)
                overhead = other.callback_overhead()
            began = time.perf_counter()
            plan = plan_body(ground, model, start, goal, BodySettings(), number)
            ours.append(time.perf_counter() - began)
            began = time.perf_counter()
            length = other.solve()
            theirs.append(time.perf_counter() - began)
            other.solve(counting=True)
            compiled.append(theirs[-1] - other.checks * overhead)
            unsolved[0] += not plan.solved
            unsolved[1] += length is None
            if plan.trajectory is not None and length is not None:
                lengths.append((plan.trajectory.length, length))
        a, b, c = (1e3 * statistics.median(v) for v in (ours, theirs, compiled))
        mean = [statistics.median(v) for v in zip(*lengths, strict=True)]
        print(
            f"{len(ours)} problems, {kind}: cavalcade {a:.2f} ms, {mean[0]:.2f} m, "
            f"{unsolved[0]} unsolved; OMPL RRT-Connect {b:.2f} ms "
            f"(about {c:.2f} ms if its tests were called from compiled code), {mean[1]:.2f} m, "
            f"{unsolved[1]} unsolved; ratio {b / a:.2f}",
            flush=True,
        )


def _timed(call: Callable[[], object]) -> float:
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--problems", type=int, default=100, help="of each kind, against OMPL")
    parser.add_argument("--quick", action="store_true", help="only the parts")
    options = parser.parse_args()
    parts()
    flat_plan(100)
    if options.quick:
        return
    if importlib.util.find_spec("ompl") is None:
        print("ompl is not installed and left out")
        return
    against_ompl(options.problems)


if __name__ == "__main__":
    main()
