"""Predictive control of a legged body as a part of its own: from a problem to forces on feet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.locomotion._mpc import solve
from cavalcade.locomotion.records import CHANGES
from cavalcade.values import instance_of, number_array, plain_number, real_array, whole_number


class MpcProblem(NamedTuple):
    """A robot, its state, and what it is to do over the next H steps; world frame, z up, SI.

    The model is one rigid body, linearised about its yaw, that the feet on the ground push. Legs
    may come in any order, the same throughout.

    Attributes:
        state: `(12,)` roll, pitch, yaw, position of the centre of mass, angular velocity, velocity.
        reference: `(H, 12)` states wanted at the ends of the steps.
        contacts: `(H, 4)` whether a foot stands in a step.
        levers: `(H, 4, 3)` from the centre of mass to the feet, m.
        yaws: `(H,)` the yaw about which a step is linearised, rad.
        dts: `(H,)` the steps' lengths, s.
        inertia: `(3, 3)` about the centre of mass, body frame, kg m².
        mass: Of the robot, kg.
        weights: `(12,)` of squared errors of the state, none negative.
        force_weight: Of squared forces, 1/N²; greater than 0.
        mu: Coefficient of friction, greater than 0: |f_x|, |f_y| ≤ mu f_z.
        max_force: Greatest normal force on a foot, N.
    """

    state: Array
    reference: Array
    contacts: NDArray[np.int64] | NDArray[np.bool_]
    levers: Array
    yaws: Array
    dts: Array
    inertia: Array
    mass: float
    weights: Array
    force_weight: float = 1e-5
    mu: float = 0.6
    max_force: float = math.inf


@dataclass(frozen=True)
class MpcSolution:
    """The forces that follow a reference best.

    Attributes:
        forces: `(H, 4, 3)` of the ground on the feet, world frame, N; zero where a foot swings.
            A controller applies those of the first step and solves again.
        changes: Of the set of limits that the solver held.
        exact: Whether this is the minimum. Otherwise the changes allowed were used up, and the
            forces obey all limits, but others may follow the reference better.
    """

    forces: Array
    changes: int
    exact: bool


def solve_mpc(problem: MpcProblem, changes: int = CHANGES) -> MpcSolution:
    """Find the forces on the feet that follow a reference best.

    They minimise the weighted squares of the state's errors at the ends of all H steps and of the
    forces' differences from an equal share of the weight, so that standing at the reference costs
    nothing. The answer depends on the problem alone, not on an earlier one. Model: Di Carlo,
    Wensing, Katz, Bledt, Kim, "Dynamic locomotion in the MIT Cheetah 3 through convex
    model-predictive control", IROS 2018; solver: Goldfarb, Idnani, "A numerically stable dual
    method for solving strictly convex quadratic programs", Mathematical Programming 27, 1983.

    Args:
        problem: Anything that numpy makes arrays of will do.
        changes: Of the solver's set of held limits, at most, for every standing foot; mostly none
            is needed.

    Raises:
        InputError: A field of another shape, not finite or out of range; the key is its name.
    """
    checked = _checked(problem)
    changes = whole_number(changes, "changes", 0, 1_000_000)
    plan = np.empty((len(checked.dts), 4, 3))
    done = solve(checked, plan, changes)
    if not np.isfinite(plan).all():
        raise InputError("the numbers are too far apart for a solution", key="problem")
    standing = int(np.count_nonzero(checked.contacts))
    return MpcSolution(plan, done, not standing or done < changes * standing)


def _checked(problem: MpcProblem) -> MpcProblem:
    """The problem with fields of the types that the kernel is compiled for."""
    instance_of(problem, MpcProblem, "problem")
    steps = len(number_array(problem.dts, "dts", (None,), "(H,) finite numbers"))
    shapes = {
        "state": (12,), "reference": (steps, 12), "contacts": (steps, 4), "levers": (steps, 4, 3),
        "yaws": (steps,), "dts": (steps,), "inertia": (3, 3), "weights": (12,),
    }  # fmt: skip
    fields: dict[str, Any] = {}
    for name, shape in shapes.items():
        value = getattr(problem, name)
        if name == "contacts":  # truth values, too
            value = real_array(value, name, f"numbers of shape {shape}")
        fields[name] = number_array(value, name, shape, f"finite numbers of shape {shape}")
    fields["contacts"] = (fields["contacts"] != 0.0).astype(np.int64)
    for name in ("mass", "force_weight", "mu", "max_force"):
        fields[name] = plain_number(getattr(problem, name), name)
        most = math.inf if name == "max_force" else np.finfo(float).max
        if not 0.0 < fields[name] <= most:
            raise InputError("expected a positive number", key=name)
    if (fields["dts"] <= 0.0).any():
        raise InputError("expected positive numbers", key="dts")
    if (fields["weights"] < 0.0).any():
        raise InputError("expected numbers, none of them negative", key="weights")
    inertia = fields["inertia"]
    if not np.allclose(inertia, inertia.T) or np.linalg.eigvalsh(inertia)[0] <= 0.0:
        raise InputError("expected a symmetric positive definite matrix", key="inertia")
    return MpcProblem(**fields)
