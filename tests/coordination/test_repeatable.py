"""The same problem, seen again, mirrored, turned or with its robots in another order."""

from __future__ import annotations

import hashlib
import math
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import yaml

from cavalcade.coordination import METHODS, PlanSettings, TeamProblem, plan_team, problem_of
from cavalcade.lattice.ground import make_ground
from cavalcade.scenario import build_world, load_scenario, parse_scenario
from cavalcade.world import OccupancyMap

BOXES = ((4.0, 1.0, 4.4, 2.0), (5.0, 3.0, 5.4, 3.6))
ROBOTS = [
    ("spirit", (1.5, 2.0, 0.0), (7.5, 2.0, 0.0)),
    ("go1", (7.5, 2.5, math.pi), (1.5, 2.2, math.pi)),
    ("go1", (4.5, 0.6, 0.0), (4.6, 2.6, 1.0)),
]

_SCRIPT = """
import hashlib, sys
from cavalcade.coordination import PlanSettings, plan_team, problem_of
from cavalcade.scenario import build_world, load_scenario
for name, method, variant in (
    ("corner-swap", "auto", "cavalcade"),
    ("head-on", "joint", "cavalcade"),
    ("head-on", "sequential", "published"),
):
    scenario = load_scenario(name)
    problem = problem_of(scenario, build_world(scenario))
    settings = PlanSettings(variant=variant, iterations=100_000)
    plan = plan_team(problem, method, settings, seed=5)
    digest = hashlib.sha256()
    for t in plan.trajectories:
        for part in (t.time, t.position, t.velocity, t.yaw, t.phase):
            digest.update(part.tobytes())
    print(plan.reason, plan.iterations, digest.hexdigest())
"""


def _digests(hash_seed: str) -> str:
    return subprocess.run(
        [sys.executable, "-c", _SCRIPT],
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    ).stdout


def test_the_same_seed_gives_the_same_bytes_in_every_process():
    first = _digests("1")
    assert first.count("\n") == 3
    assert _digests("2") == first


@pytest.mark.parametrize("method", METHODS)
def test_the_same_seed_gives_the_same_bytes_again(make_team, bytes_of, method):
    problem = make_team(ROBOTS, (9.0, 4.0), BOXES)
    plans = [plan_team(problem, method, seed=3) for _ in range(2)]
    assert plans[0].solved
    digests = [hashlib.sha256(bytes_of(plan)).hexdigest() for plan in plans]
    assert digests[0] == digests[1]
    assert plans[0].iterations == plans[1].iterations
    # Nor does it matter what was planned in between, or that a limit of time is there.
    limited = plan_team(problem, method, PlanSettings(seconds=500.0), seed=3)
    assert bytes_of(limited) == bytes_of(plans[0])


def test_another_seed_gives_another_joint_plan(make_team, bytes_of):
    problem = make_team(ROBOTS[:2], (9.0, 4.0), BOXES)
    assert len({bytes_of(plan_team(problem, "joint", seed=seed)) for seed in range(3)}) > 1


def _mirrored(problem: TeamProblem, height: float) -> TeamProblem:
    def image(poses: tuple) -> tuple:
        return tuple((x, height - y, -yaw) for x, y, yaw in poses)

    solid = OccupancyMap(problem.ground.solid[::-1].copy(), problem.ground.cell)
    return replace(
        problem,
        ground=make_ground(solid),
        starts=image(problem.starts),
        goals=image(problem.goals),
    )


def _reordered(problem: TeamProblem, order: list[int]) -> TeamProblem:
    return replace(
        problem,
        models=tuple(problem.models[k] for k in order),
        starts=tuple(problem.starts[k] for k in order),
        goals=tuple(problem.goals[k] for k in order),
    )


@pytest.mark.parametrize("method", METHODS)
def test_the_mirror_image_is_solved_alike(make_team, judged, method):
    problem = make_team(ROBOTS, (9.0, 4.0), BOXES)
    image = _mirrored(problem, 4.0)
    one = judged(problem, plan_team(problem, method))
    other = judged(image, plan_team(image, method))
    # Ties are not broken symmetrically; the product space is sampled at random.
    assert other["length"] == pytest.approx(one["length"], rel=0.3 if method == "joint" else 0.1)


@pytest.mark.parametrize("order", [[1, 0, 2], [2, 1, 0], [1, 2, 0]])
def test_auto_does_not_depend_on_the_order_of_the_robots(make_team, judged, order):
    problem = make_team(ROBOTS, (9.0, 4.0), BOXES)
    other = _reordered(problem, order)
    one = judged(problem, plan_team(problem))
    two = judged(other, plan_team(other))
    assert two["length"] == pytest.approx(one["length"], rel=0.05)


@pytest.mark.parametrize("order", [[1, 0, 2], [2, 1, 0]])
@pytest.mark.parametrize("method", ["sequential", "cbs"])
def test_in_every_order_there_is_a_plan(make_team, judged, method, order):
    problem = _reordered(make_team(ROBOTS, (9.0, 4.0), BOXES), order)
    judged(problem, plan_team(problem, method))


NOWHERE = (0.0, 0.0, 0.0)


def _on_map(
    tmp_path, origin: tuple[float, float, float], robots: list, boxes: tuple = BOXES
) -> TeamProblem:
    """The world as a ROS map with an origin; poses are given in the map's own grid."""
    grid = np.full((80, 180), 254, dtype=np.uint8)
    for x0, y0, x1, y1 in np.round(np.array(boxes).reshape(-1, 4) / 0.05).astype(int):
        grid[80 - y1 : 80 - y0, x0:x1] = 0
    folder = tmp_path / f"{origin} {len(boxes)}"
    folder.mkdir()
    (folder / "m.pgm").write_bytes(b"P5 180 80 255\n" + grid.tobytes())
    words = {"image": "m.pgm", "resolution": 0.05, "origin": list(origin), "negate": 0}
    words |= {"occupied_thresh": 0.65, "free_thresh": 0.196}
    (folder / "m.yaml").write_text(yaml.safe_dump(words))
    c, s = math.cos(origin[2]), math.sin(origin[2])

    def placed(pose: tuple) -> list[float]:
        x, y, yaw = pose
        return [origin[0] + c * x - s * y, origin[1] + s * x + c * y, yaw + origin[2]]

    scenario = parse_scenario(
        {
            "version": 1,
            "name": "on-a-map",
            "world": {"map": str(folder / "m.yaml")},
            "robots": [
                {"model": model, "start": placed(start), "goal": placed(goal)}
                for model, start, goal in robots
            ],
            "task": {"goals": "individual"},
        }
    )
    return problem_of(scenario, build_world(scenario))


@pytest.mark.parametrize("origin", [(3.0, -2.0, 0.0), (-1.0, 4.0, 0.7), (0.0, 0.0, -2.5)])
def test_where_the_map_lies_does_not_matter(tmp_path, judged, origin):
    plain = _on_map(tmp_path, NOWHERE, ROBOTS)
    problem = _on_map(tmp_path, origin, ROBOTS)
    assert problem.origin == pytest.approx(origin)
    assert (problem.ground.solid == plain.ground.solid).all()
    assert np.array(problem.starts) == pytest.approx(np.array(plain.starts))
    # Judged where the map lies; rounding may decide between ways that are as good.
    figures = judged(problem, plan_team(problem))
    expected = judged(plain, plan_team(plain))
    assert figures["length"] == pytest.approx(expected["length"], rel=0.03)
    # One robot's straight way is the same motion, turned.
    alone = [
        plan_team(replace(p, models=p.models[:1], starts=p.starts[:1], goals=p.goals[:1]))
        for p in (_on_map(tmp_path, origin, ROBOTS, ()), _on_map(tmp_path, NOWHERE, ROBOTS, ()))
    ]
    there, here = (plan.trajectories[0] for plan in alone)
    x, y, yaw = origin
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    assert there.time == pytest.approx(here.time, abs=1e-9)
    assert there.position[:, :2] == pytest.approx(here.position[:, :2] @ turn.T + (x, y), abs=1e-9)
    assert there.velocity[:, :2] == pytest.approx(here.velocity[:, :2] @ turn.T, abs=1e-9)
    assert there.yaw == pytest.approx(here.yaw + yaw, abs=1e-9)


def test_shipped_swaps_are_solved_with_every_seed(judged, straight):
    for name, bar in (("hexagon-swap", 1.08), ("octagon-swap", 1.08), ("head-on", 1.08)):
        scenario = load_scenario(name)
        problem = problem_of(scenario, build_world(scenario))
        for seed in range(3):
            figures = judged(problem, plan_team(problem, "auto", seed=seed))
            assert figures["length"] <= bar * straight(problem)


def test_improvement_never_makes_a_plan_dearer(make_team, judged):
    problem = make_team(ROBOTS, (9.0, 4.0), BOXES)
    one = plan_team(problem, "sequential")
    better = plan_team(problem, "sequential", PlanSettings(improve=50_000))
    judged(problem, better)
    costs = [cost for _, cost in better.history]
    assert costs == sorted(costs, reverse=True)
    used = [iterations for iterations, _ in better.history]
    assert used == sorted(used)
    assert used[0] == one.iterations
    assert better.iterations >= used[-1]
