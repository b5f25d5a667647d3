"""One solve of predictive control against DAQP: time and agreement on the same problems.

Both get the same matrices in one process on one thread and take turns on every problem; of some
turns each keeps its best, so that a busy machine slows neither. Times are those of the calls from
Python, from matrices to forces; for DAQP its own clock (set-up and solution) as well. Whole calls
(matrices built from state, reference and contacts, then solved) are timed by the score in
compiled code, as the controller makes them.

    python benchmarks/bench_mpc.py [--problems 200] [--turns 7]
"""

from __future__ import annotations

import os

# Before numpy and numba start their threads.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import daqp
import numpy as np
from numba import njit
from numpy.typing import NDArray

from cavalcade.locomotion import MpcProblem
from cavalcade.locomotion._mpc import build_qp, solve
from cavalcade.locomotion._qp import solve_qp

Array = NDArray[np.float64]

STEPS, HEIGHT, MASS, MU, MOST, MANY = 10, 0.28, 12.7, 0.5, 180.0, 100_000
HIPS = np.array([[0.19, 0.13], [0.19, -0.13], [-0.19, 0.13], [-0.19, -0.13]])
INERTIA = np.diag([0.08, 0.26, 0.28])
WEIGHTS = np.array([2.0, 2.0, 2.0, 4.0, 4.0, 50.0, 0.02, 0.02, 0.15, 0.6, 0.6, 0.2])
PUSHES = {"calm": 0.0, "pushed": 0.3, "thrown": 1.0}
"""Velocity off the reference, m/s; thrice as many rad/s."""


class Case(NamedTuple):
    """What both solvers get, and the problem of a whole call."""

    problem: MpcProblem
    hessian: Array
    gradient: Array
    rows: Array
    upper: Array
    lower: Array


def schedule(rng: np.random.Generator, kind: str) -> NDArray[np.bool_]:
    """Which feet stand in which step."""
    contacts = np.ones((STEPS, 4), bool)
    if kind == "trot":
        first = (np.arange(STEPS) + rng.integers(12)) // 6 % 2 == 0
        contacts[np.ix_(first, [1, 2])] = False
        contacts[np.ix_(~first, [0, 3])] = False
    elif kind == "leap":
        off = rng.integers(1, 6)
        contacts[off : off + 4] = False
    return contacts


def draw(rng: np.random.Generator, kind: str, push: float) -> Case:
    """A robot near a moving reference, thrown off it by about `push` m/s."""
    dts = np.full(STEPS, 0.025 if kind == "leap" else 0.04)
    times = np.cumsum(dts)
    yaw, rate = rng.uniform(-3, 3), rng.uniform(-1, 1)
    c, s = np.cos(yaw), np.sin(yaw)
    ahead, aside = rng.uniform(-1, 1, 2) * (0.0 if kind == "stand" else 1.0)
    velocity = np.array([c * ahead - s * aside, s * ahead + c * aside, 0.0])
    reference = np.zeros((STEPS, 12))
    reference[:, 2], reference[:, 8] = yaw + rate * times, rate
    reference[:, 3:6] = [0.0, 0.0, HEIGHT] + times[:, None] * velocity
    reference[:, 9:] = velocity
    state = np.concatenate([[0, 0, yaw, 0, 0, HEIGHT, 0, 0, rate], velocity])
    state += rng.normal(0, 1, 12) * np.repeat([0.03, 0.01, 0.2, 0.1], 3)
    state[6:] += push * rng.normal(0, 1, 6) * np.repeat([3.0, 1.0], 3)
    yaws = yaw + rate * (times - dts / 2)
    feet = np.column_stack([HIPS + rng.normal(0, 0.03, (4, 2)), np.full(4, -HEIGHT)])
    turned = np.stack([np.cos(yaws), np.sin(yaws)], axis=1)
    levers = np.empty((STEPS, 4, 3))
    levers[..., 0] = np.outer(turned[:, 0], feet[:, 0]) - np.outer(turned[:, 1], feet[:, 1])
    levers[..., 1] = np.outer(turned[:, 1], feet[:, 0]) + np.outer(turned[:, 0], feet[:, 1])
    levers[..., 2] = feet[:, 2]
    contacts = schedule(rng, kind)
    n = 3 * int(contacts.sum())
    hessian, gradient = np.zeros((n, n)), np.empty(n)
    motion = state, reference, contacts, levers, yaws, dts
    problem = MpcProblem(*motion, INERTIA, MASS, WEIGHTS, 1e-5, MU, MOST)
    build_qp(problem, hessian, gradient)
    hessian = np.triu(hessian) + np.triu(hessian, 1).T
    # DAQP is fastest with normal forces as simple bounds, one for every unknown.
    sides = np.array([[1, 0, -MU], [-1, 0, -MU], [0, 1, -MU], [0, -1, -MU]])
    upper = np.concatenate([np.tile([1e30, 1e30, MOST], n // 3), np.zeros(4 * n // 3)])
    lower = np.concatenate([np.tile([-1e30, -1e30, 0.0], n // 3), np.full(4 * n // 3, -1e30)])
    return Case(problem, hessian, gradient, np.kron(np.eye(n // 3), sides), upper, lower)


@njit
def _solve_often(count, problem, plan):
    for _ in range(count):
        solve(problem, plan, MANY)


def seconds(call: Callable[[], Any]) -> float:
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


def compare(case: Case, turns: int) -> tuple[float, float, float, float, float, int]:
    """Microseconds of ours, DAQP, DAQP by its own clock, a whole call; error in N; changes."""
    forces, plan = np.empty(len(case.gradient)), np.empty((STEPS, 4, 3))

    def ours() -> int:
        return solve_qp(case.hessian, case.gradient, MU, MOST, forces, MANY)

    def theirs() -> Any:
        return daqp.solve(case.hessian, case.gradient, case.rows, case.upper, case.lower)

    own, best, other, clock, whole = [], theirs(), [], [], []
    if best[2] != 1:
        raise RuntimeError(f"DAQP ends with {best[2]}")
    changes = ours()
    for _ in range(turns):
        own.append(seconds(ours))
        other.append(seconds(theirs))
        info = theirs()[3]
        clock.append(info["setup_time"] + info["solve_time"])
        whole.append(seconds(lambda: _solve_often(20, case.problem, plan)) / 20)
    error = float(np.abs(forces - best[0]).max())
    return 1e6 * min(own), 1e6 * min(other), 1e6 * min(clock), 1e6 * min(whole), error, changes


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--problems", type=int, default=200, help="of each kind")
    parser.add_argument("--turns", type=int, default=7, help="of both solvers on a problem")
    options = parser.parse_args()
    print(f"Horizon {STEPS}, {options.problems} problems each; median (90th percentile), µs")
    print(
        f"{'':14s} {'ours':>14s} {'DAQP':>14s} {'its clock':>14s} {'ratio':>13s} {'most':>5s}"
        f" {'whole call':>14s} {'changes':>8s} {'error, N':>9s}"
    )
    for kind in ("trot", "stand", "leap"):
        for name, push in PUSHES.items():
            rng = np.random.default_rng(7)
            cases = [draw(rng, kind, push) for _ in range(options.problems)]
            own, other, clock, whole, error, changes = np.array(
                [compare(case, options.turns) for case in cases]
            ).T
            line = f"{kind + ', ' + name:14s}"
            for values in (own, other, clock):
                line += f" {np.median(values):6.1f} ({np.quantile(values, 0.9):5.1f})"
            ratios = own / other
            line += f" {np.median(ratios):5.2f} ({np.quantile(ratios, 0.9):4.2f})"
            line += f"  {ratios.max():4.2f}"
            line += f" {np.median(whole):6.1f} ({np.quantile(whole, 0.9):5.1f})"
            print(f"{line} {np.median(changes):8.0f} {error.max():9.1e}", flush=True)


if __name__ == "__main__":
    main()
