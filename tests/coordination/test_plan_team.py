"""Every method on problems of every kind: plans are judged by brute force, at 10 ms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.coordination import METHODS, TeamProblem, plan_team, problem_of
from cavalcade.scenario import build_world, import_problem, load_scenario

HEAD_ON = [
    ("spirit", (2.0, 2.0, 0.0), (7.0, 2.0, 0.0)),
    ("spirit", (7.0, 2.0, math.pi), (2.0, 2.0, math.pi)),
]


@pytest.mark.parametrize("method", METHODS)
def test_head_on(make_team, judged, straight, method):
    problem = make_team(HEAD_ON)
    plan = plan_team(problem, method, seed=1)
    figures = judged(problem, plan)
    assert figures["length"] <= 1.10 * straight(problem)
    assert plan.method in {"auto": ("prioritised", "cbs", "joint")}.get(method, (method,))


@pytest.mark.parametrize("method", METHODS)
def test_corner_swap(judged, straight, method):
    scenario = load_scenario("corner-swap")
    problem = problem_of(scenario, build_world(scenario))
    figures = judged(problem, plan_team(problem, method, seed=2))
    assert figures["length"] <= (1.08 if method == "auto" else 1.25) * straight(problem)


def _two_at_random(make_team, seed: int) -> TeamProblem:
    """Spirits on 10 x 10 m whose straight lines cross."""
    rng = np.random.default_rng(seed)
    while True:
        poses = rng.uniform((0.7, 0.7, -math.pi), (9.3, 9.3, math.pi), (4, 3))
        a, b, c, d = (complex(*pose[:2]) for pose in poses)
        if min(abs(a - b), abs(c - d)) < 1.0:
            continue

        def side(p: complex, q: complex, r: complex) -> float:
            return ((q - p).conjugate() * (r - p)).imag

        if side(a, c, b) * side(a, c, d) < 0 and side(b, d, a) * side(b, d, c) < 0:
            starts, goals = poses[:2].tolist(), poses[2:].tolist()
            robots = [("spirit", tuple(s), tuple(g)) for s, g in zip(starts, goals, strict=True)]
            return make_team(robots, (10.0, 10.0))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(20))
def test_two_robots_whose_lines_cross(make_team, judged, straight, method, seed):
    problem = _two_at_random(make_team, seed)
    figures = judged(problem, plan_team(problem, method, seed=seed))
    assert figures["length"] <= 1.6 * straight(problem)


def test_where_nobody_is_in_the_way_each_goes_straight(make_team, judged, straight):
    robots = [("go1", (1.0, 1.0 + k, 0.0), (8.0, 1.0 + k, 0.0)) for k in range(3)]
    problem = make_team(robots)
    for method in METHODS:
        plan = plan_team(problem, method)
        figures = judged(problem, plan)
        assert figures["length"] == pytest.approx(straight(problem))


def _importable(shared_data) -> list:
    names = sorted(path.name for path in shared_data("db_cbs").glob("*.yaml"))
    assert names
    files = [shared_data(f"db_cbs/{name}") for name in names]
    return [import_problem(file) for file in files if "trailer" not in file.read_text()]


def test_problems_of_db_cbs(shared_data, judged):
    scenarios = _importable(shared_data)
    assert len(scenarios) >= 25
    for scenario in scenarios:
        problem = problem_of(scenario, build_world(scenario))
        plan = plan_team(problem, "auto")
        if scenario.name.startswith("infeasible"):
            assert plan.reason == "infeasible", scenario.name
            assert plan.detail == "the goals of robots 0 and 1 overlap or touch"
            continue
        assert plan.solved, (scenario.name, plan.detail)
        judged(problem, plan)


def test_unequal_robots(make_team, judged, straight):
    robots = [
        ("go1", (1.0, 4.0, 0.0), (7.0, 4.0, 1.0)),
        ("spirit", (7.0, 4.0, math.pi), (1.0, 4.0, math.pi)),
        ("unicycle", (4.0, 1.0, math.pi / 2), (4.0, 7.0, 0.0)),
        ("double-integrator", (4.0, 7.0, 0.0), (4.0, 1.0, 2.0)),
        ("unicycle-2", (1.0, 1.0, 0.8), (7.0, 7.0, 0.8)),
        ("single-integrator", (7.0, 7.0, 0.0), (1.0, 1.0, 0.0)),
    ]
    problem = make_team(robots, (8.0, 8.0), ((2.5, 2.0, 2.9, 2.5), (5.2, 5.0, 5.6, 6.0)))
    for method in ("auto", "sequential", "cbs"):
        figures = judged(problem, plan_team(problem, method))
        assert figures["length"] <= 1.3 * straight(problem)
    pair = make_team(robots[:4:3], (8.0, 8.0))
    judged(pair, plan_team(pair, "joint"))


def test_one_robot_is_a_team(make_team, judged, straight):
    problem = make_team(HEAD_ON[:1])
    for method in METHODS:
        plan = plan_team(problem, method)
        assert judged(problem, plan)["length"] == pytest.approx(straight(problem))


@pytest.mark.parametrize("method", METHODS)
def test_robots_that_are_there_already_stay(make_team, judged, method):
    robots = [(name, pose, pose) for name, pose, _ in HEAD_ON]
    problem = make_team(robots)
    plan = plan_team(problem, method)
    assert judged(problem, plan) == {"length": 0.0, "makespan": 0.0}


def _crowd(make_team, count: int, seed: int) -> TeamProblem:
    """Robots at random in 20 x 20 m with boxes, a metre and a half between places."""
    rng = np.random.default_rng(seed)
    boxes = []
    for x, y in rng.uniform(2.0, 17.0, (8, 2)).round(1):
        boxes.append((x, y, x + 1.0, y + 1.0))
    centres = np.array(boxes)[:, :2] + 0.5
    sides: tuple[list, list] = ([], [])
    for side in sides:
        while len(side) < count:
            pose = rng.uniform((1.0, 1.0, -math.pi), (19.0, 19.0, math.pi))
            near = [math.dist(pose[:2], other[:2]) for other in side]
            if min(near, default=9.0) > 1.5 and np.hypot(*(centres - pose[:2]).T).min() > 1.4:
                side.append(tuple(pose))
    robots = [("spirit", a, b) for a, b in zip(*sides, strict=True)]
    return make_team(robots, (20.0, 20.0), boxes)


@pytest.mark.slow
def test_a_crowd_of_twenty(make_team, judged, straight):
    problem = _crowd(make_team, 20, 0)
    figures = judged(problem, plan_team(problem, "auto"))
    assert figures["length"] <= 1.15 * straight(problem)
