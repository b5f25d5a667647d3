"""Predictive control against explicit matrices, DAQP, and laws that forces obey."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.geometry import GRAVITY
from cavalcade.locomotion import MpcProblem, solve_mpc
from cavalcade.locomotion._mpc import build_qp, solve

STEPS = 10
HIPS = np.array([[0.19, 0.13], [0.19, -0.13], [-0.19, 0.13], [-0.19, -0.13]])
WEIGHTS = np.array([2.0, 2.0, 2.0, 4.0, 4.0, 50.0, 0.02, 0.02, 0.15, 0.6, 0.6, 0.2])
ROBOT = {"mass": 12.7, "weights": WEIGHTS, "force_weight": 1e-5, "mu": 0.5, "max_force": 180.0}
SIDES = [1, 0, 3, 2]  # the leg on the other side
KINDS = ["trot", "stand", "leap"]


def forces_of(problem):
    """`(H, 4, 3)`."""
    solution = solve_mpc(problem)
    assert solution.exact
    return solution.forces


def as_compiled(problem):
    """The problem as `solve_mpc` gives it to kernels, so that they are compiled once."""
    arrays = [np.ascontiguousarray(v) if isinstance(v, np.ndarray) else v for v in problem]
    return MpcProblem(*arrays)._replace(contacts=problem.contacts.astype(np.int64))


def overwritten(problem, before):
    """The same by the kernel, in an array that holds something else before."""
    plan = np.full((STEPS, 4, 3), before)
    solve(as_compiled(problem), plan, 30)
    return plan


def build(problem):
    """The programme's whole hessian, and its gradient."""
    n = 3 * int(problem.contacts.sum())
    hessian, gradient = np.zeros((n, n)), np.empty(n)
    build_qp(as_compiled(problem), hessian, gradient)
    return np.triu(hessian) + np.triu(hessian, 1).T, gradient


def turn(yaw):
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def schedule(rng, kind):
    contacts = np.ones((STEPS, 4), bool)
    if kind == "trot":
        first = (np.arange(STEPS) + rng.integers(12)) // 6 % 2 == 0
        contacts[first, 1:3] = False
        contacts[~first, 0], contacts[~first, 3] = False, False
    elif kind == "leap":
        off = rng.integers(1, 6)
        contacts[off : off + 4] = False
        contacts[off - 1, :2] = False
    return contacts


def drawn(rng, kind, push=0.0):
    """A robot near its reference, or thrown off it by `push` m/s and 3 `push` rad/s."""
    dts = rng.uniform(0.02, 0.05, STEPS) if kind == "leap" else np.full(STEPS, 0.04)
    time = np.cumsum(dts)
    yaw, rate = rng.uniform(-3, 3), rng.uniform(-1, 1)
    velocity = turn(yaw) @ np.array([*rng.uniform(-1, 1, 2), 0.0])
    reference = np.zeros((STEPS, 12))
    reference[:, 2], reference[:, 8] = yaw + rate * time, rate
    reference[:, 3:6] = [0.0, 0.0, 0.28] + time[:, None] * velocity
    reference[:, 9:] = velocity
    yaws = yaw + rate * (time - dts / 2)
    hips = np.column_stack([HIPS, np.full(4, -0.28)])
    levers = np.array([(hips + rng.normal(0, 0.03, (4, 3))) @ turn(angle).T for angle in yaws])
    state = np.concatenate([[0, 0, yaw, 0, 0, 0.28, 0, 0, rate], velocity])
    state += rng.normal(0, 1, 12) * np.repeat([0.05, 0.02, 0.3, 0.15], 3)
    state[6:] += push * rng.normal(0, 1, 6) * np.repeat([3.0, 1.0], 3)
    skew = rng.normal(0, 0.004, (3, 3))
    inertia = np.diag([0.08, 0.26, 0.28]) + skew + skew.T
    return MpcProblem(state, reference, schedule(rng, kind), levers, yaws, dts, inertia, **ROBOT)


def build_slowly(p):
    """Explicit matrices, step by step, of all states on all forces."""
    places = [(k, leg) for k in range(STEPS) for leg in range(4) if p.contacts[k, leg]]
    n = 3 * len(places)
    hessian, gradient = p.force_weight * np.eye(n), np.zeros(n)
    effect, drift = np.zeros((12, n)), p.state.copy()
    for k, dt in enumerate(p.dts):
        rotation = turn(p.yaws[k])
        a, b, constant = np.zeros((12, 12)), np.zeros((12, n)), np.zeros(12)
        a[:3, 6:9], a[3:6, 9:] = rotation.T, np.eye(3)
        constant[11] = -GRAVITY
        for m, (step, leg) in enumerate(places):
            if step == k:
                x, y, z = p.levers[k, leg]
                cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                b[6:9, 3 * m : 3 * m + 3] = np.linalg.inv(rotation @ p.inertia @ rotation.T) @ cross
                b[9:, 3 * m : 3 * m + 3] = np.eye(3) / p.mass
                gradient[3 * m + 2] -= p.force_weight * p.mass * GRAVITY / p.contacts[k].sum()
        onward, inward = np.eye(12) + a * dt, np.eye(12) * dt + a * dt**2 / 2  # exact: a a = 0
        effect, drift = onward @ effect + inward @ b, onward @ drift + inward @ constant
        hessian += effect.T @ np.diag(p.weights) @ effect
        gradient += effect.T @ (p.weights * (drift - p.reference[k]))
    return hessian, gradient


def standing():
    """At rest over the middle of four feet, as the reference wants it."""
    state = np.zeros(12)
    state[5] = 0.28
    levers = np.tile(np.column_stack([HIPS, np.full(4, -0.28)]), (STEPS, 1, 1))
    return MpcProblem(
        state,
        np.tile(state, (STEPS, 1)),
        np.ones((STEPS, 4), bool),
        levers,
        np.zeros(STEPS),
        np.full(STEPS, 0.04),
        np.diag([0.08, 0.26, 0.28]),
        **ROBOT,
    )


@pytest.mark.parametrize("kind", KINDS)
def test_the_programme_is_that_of_explicit_matrices(kind):
    rng = np.random.default_rng(0)
    for _ in range(20):
        problem = drawn(rng, kind, push=0.5)
        for built, slow in zip(build(problem), build_slowly(problem), strict=True):
            np.testing.assert_allclose(built, slow, atol=1e-13 * np.abs(slow).max(), rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("push", [0.0, 0.3, 1.0])
def test_daqp_finds_the_same_forces(kind, push):
    daqp = pytest.importorskip("daqp")
    rng = np.random.default_rng(1)
    for _ in range(40):
        p = drawn(rng, kind, push)
        hessian, gradient = build_slowly(p)
        feet = len(gradient) // 3
        one = [[1, 0, -p.mu], [-1, 0, -p.mu], [0, 1, -p.mu], [0, -1, -p.mu], [0, 0, 1.0]]
        limits = np.tile([0.0, 0.0, 0.0, 0.0, p.max_force], feet)
        exact, _, flag, _ = daqp.solve(hessian, gradient, np.kron(np.eye(feet), one), limits)
        assert flag == 1
        np.testing.assert_allclose(forces_of(p)[p.contacts].ravel(), exact, atol=1e-5)  # N


@pytest.mark.parametrize("kind", KINDS)
def test_forces_obey_their_limits_exactly(kind):
    rng = np.random.default_rng(2)
    slips = presses = 0
    for _ in range(50):
        p = drawn(rng, kind, push=1.0)
        forces = forces_of(p)
        x, y, z = np.moveaxis(forces, 2, 0)
        assert (np.abs(x) <= p.mu * z).all()
        assert (np.abs(y) <= p.mu * z).all()
        assert (z <= p.max_force).all()
        assert (forces[~p.contacts] == 0.0).all()
        slips += (np.abs(x) == p.mu * z)[p.contacts & (z > 0)].sum()
        presses += (z == p.max_force).sum()
    assert slips > 100
    assert presses > 10


def test_standing_feet_carry_the_weight_in_equal_shares():
    p = standing()
    shares = np.tile([0.0, 0.0, p.mass * GRAVITY / 4], (STEPS, 4, 1))
    np.testing.assert_allclose(forces_of(p), shares, atol=1e-6)


def test_feet_nearer_to_the_centre_of_mass_carry_more():
    p = standing()
    ahead = p.levers - [0.05, 0.0, 0.0]
    forces = forces_of(p._replace(levers=ahead))[..., 2]
    np.testing.assert_allclose(forces[0].sum(), p.mass * GRAVITY, rtol=0.02)
    assert (forces[0, :2] > forces[0, 2:] + 5.0).all()


def test_a_fall_is_met_and_a_push_is_braked():
    p = standing()
    sinking, pushed, tilted = (p.state.copy() for _ in range(3))
    sinking[11], pushed[9], tilted[0] = -0.3, 0.4, 0.1
    assert forces_of(p._replace(state=sinking))[0, :, 2].sum() > 1.1 * p.mass * GRAVITY
    assert forces_of(p._replace(state=pushed))[0, :, 0].sum() < -5.0
    forces = forces_of(p._replace(state=tilted))[0, :, 2]
    assert forces[1] + forces[3] > forces[0] + forces[2] + 5.0  # rolled to the right


def test_nothing_stands_and_nothing_pushes():
    p = standing()
    flying = p._replace(contacts=np.zeros((STEPS, 4), bool))
    np.testing.assert_array_equal(overwritten(flying, 7.0), 0.0)


@pytest.mark.parametrize("kind", KINDS)
def test_a_mirrored_robot_pushes_mirrored(kind):
    rng = np.random.default_rng(3)
    mirror = np.array([1.0, -1.0, 1.0])
    turned = np.array([-1.0, 1.0, -1.0])  # of angles and angular velocities
    both = np.concatenate([turned, mirror, turned, mirror])
    for _ in range(10):
        p = drawn(rng, kind, push=0.5)
        other = p._replace(
            state=p.state * both,
            reference=p.reference * both,
            contacts=p.contacts[:, SIDES],
            levers=p.levers[:, SIDES] * mirror,
            yaws=-p.yaws,
            inertia=p.inertia * np.outer(mirror, mirror),
        )
        np.testing.assert_allclose(forces_of(other), forces_of(p)[:, SIDES] * mirror, atol=1e-6)


def test_a_robot_turned_by_a_quarter_pushes_turned():
    """A symmetry of the pyramid, and of weights that are alike along x and y."""
    rng = np.random.default_rng(4)
    quarter = turn(np.pi / 2)
    for kind in KINDS:
        p = drawn(rng, kind, push=0.5)
        state, reference = p.state.copy(), p.reference.copy()
        for part in (3, 6, 9):
            state[part : part + 3] = quarter @ state[part : part + 3]
            reference[:, part : part + 3] = reference[:, part : part + 3] @ quarter.T
        state[2] += np.pi / 2
        reference[:, 2] += np.pi / 2
        other = p._replace(
            state=state,
            reference=reference,
            levers=p.levers @ quarter.T,
            yaws=p.yaws + np.pi / 2,
        )
        np.testing.assert_allclose(forces_of(other), forces_of(p) @ quarter.T, atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_the_answer_depends_on_the_question_alone(kind):
    p = drawn(np.random.default_rng(5), kind, push=1.0)
    first = forces_of(p)
    np.testing.assert_array_equal(overwritten(p, 1e3), first)
    np.testing.assert_array_equal(
        forces_of(p._replace(contacts=p.contacts.astype(np.uint8))), first
    )


def test_forces_within_the_limits_come_also_when_changes_run_out():
    p = drawn(np.random.default_rng(6), "stand", push=1.0)
    rough, exact = solve_mpc(p, changes=0), solve_mpc(p)
    assert (rough.exact, exact.exact) == (False, True)
    assert exact.changes > 0
    assert (np.abs(rough.forces[..., :2]) <= p.mu * rough.forces[..., 2:]).all()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("state", np.zeros(11)),
        ("reference", np.zeros((STEPS - 1, 12))),
        ("levers", np.full((STEPS, 4, 3), np.nan)),
        ("dts", np.zeros(STEPS)),
        ("inertia", np.diag([0.1, 0.1, -0.1])),
        ("mass", 0.0),
        ("weights", -WEIGHTS),
        ("mu", np.nan),
        ("max_force", -1.0),
    ],
)
def test_a_malformed_problem_is_refused_by_the_fields_name(name, value):
    with pytest.raises(InputError, match=f"{name}: expected"):
        solve_mpc(standing()._replace(**{name: value}))
