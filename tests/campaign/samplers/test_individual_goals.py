"""Draws of robots with goals of their own."""

from __future__ import annotations

import json
import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from cavalcade.campaign.samplers import SAMPLERS, DataFolder, unplanned
from cavalcade.campaign.samplers.feasibility import DiscRegions
from cavalcade.campaign.samplers.individual_goals import bodies_meet, keeps_apart
from cavalcade.geometry import rectangle_corners, transform_points
from cavalcade.jobs import plan
from cavalcade.robots import MODELS
from cavalcade.scenario import build_world, parse_scenario
from cavalcade.world import OccupancyMap

DATA = DataFolder(None)
HOPELESS = (
    "goals-overlap",
    "goals-equal",
    "goal-off-the-map",
    "goal-in-an-obstacle",
    "goal-in-a-hole",
    "goal-walled-in",
)
WORLDS = {
    "pairs": {"sampler": "pairs"},
    "side-by-side": {"sampler": "pairs", "starts": "side-by-side", "size": [20, 20]},
    "alcove": {"sampler": "passing", "kind": "alcove", "models": ["spirit", "go1"]},
    "wide": {"sampler": "passing", "kind": "wide", "room": [0.3, 1.2]},
    "narrow": {"sampler": "passing", "kind": "narrow", "budget": {"seconds": 5}},
    "boxes": {"sampler": "boxes", "robots": [2, 6], "models": ["spirit", "go1"]},
    "flat": {"sampler": "terrain", "kind": "flat"},
    "gap": {"sampler": "terrain", "kind": "gap", "value": 0.4, "robots": 3},
    "step": {"sampler": "terrain", "kind": "step", "value": [0.1, 0.25]},
    "rough": {"sampler": "terrain", "kind": "rough", "value": 0.25, "size": [10, 8]},
    **{kind: {"sampler": "infeasible", "kind": kind} for kind in HOPELESS},
}


def section(said):
    return SAMPLERS[said["sampler"]].model_validate(said)


@pytest.mark.parametrize("name", WORLDS)
def test_laws_of_every_draw(name):
    sampler = section(WORLDS[name])
    assert sampler.individual_goals
    assert sampler.missing(DATA) is None
    assert sampler.limit(DATA) is None
    seen = []
    for seed in range(4):
        instance = sampler.sample(seed, DATA)
        assert instance == sampler.sample(seed, DATA)
        assert (instance.level is None) == (sampler.level_name is None)
        assert instance.feasible == (instance.expected == "solved")
        plain = json.loads(json.dumps(instance.scenario))
        assert plain == instance.scenario
        scenario = parse_scenario(plain)
        assert scenario.task.kind == "individual"
        assert scenario.seed == seed
        build_world(scenario)  # refuses starts in an obstacle or in each other
        seen.append(json.dumps({**plain, "name": "", "execution": {}}))
    assert len(set(seen)) == len(seen)


@pytest.mark.parametrize("name", WORLDS)
def test_what_a_section_writes_it_reads(name):
    sampler = section(WORLDS[name])
    again = section(json.loads(json.dumps(sampler.model_dump(mode="json"))))
    assert again == sampler
    assert again.sample(1, DATA) == sampler.sample(1, DATA)


@pytest.mark.parametrize("name", ["pairs", "boxes", "gap"])
def test_footprints_keep_apart_on_the_map(name):
    sampler = section(WORLDS[name])
    for seed in range(6):
        scenario = parse_scenario(sampler.sample(seed, DATA).scenario)
        base = build_world(scenario).base
        for poses in (scenario.starts, scenario.goals):
            bodies = [_outline(m, p) for m, p in zip(scenario.models, poses, strict=True)]
            assert all(base.contains(body).all() for body in bodies)
            for one, other in combinations(bodies, 2):
                gaps = np.linalg.norm(one[:, None] - other[None], axis=2)
                assert gaps.min() >= 0.05 - 1e-9


def _outline(model, pose, count=40):
    """Points along a footprint's sides."""
    corners = rectangle_corners(pose, model.length, model.width)
    share = np.arange(count)[:, None] / count
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return np.concatenate([a + share * (b - a) for a, b in sides])


number = st.floats(-1.0, 1.0)
angle = st.floats(-math.pi, math.pi)
places = st.tuples(number, number, angle)


@settings(deadline=None, max_examples=300)
@given(places, places)
def test_bodies_meet_as_points_inside_say(first, second):
    """Slowly: they meet if a point of one, on a fine grid, lies well inside of the other."""
    one, other = MODELS["spirit"], MODELS["go1"]
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 81), np.linspace(-0.5, 0.5, 81))
    grid = np.column_stack([x.ravel() * one.length, y.ravel() * one.width])
    points = transform_points(first, grid)
    off = points - np.array(second[:2])
    c, s = math.cos(second[2]), math.sin(second[2])
    along = np.abs(c * off[:, 0] + s * off[:, 1]) - other.length / 2.0
    across = np.abs(c * off[:, 1] - s * off[:, 0]) - other.width / 2.0
    depth = np.maximum(along, across).min()
    meet = bool(bodies_meet(one, np.array([first]), other, np.array([second]))[0])
    if depth < 0.0:
        assert meet
    if depth > 0.01:  # between the grid's points a corner may reach in
        assert not meet
    swapped = bool(bodies_meet(other, np.array([second]), one, np.array([first]))[0])
    assert swapped == meet
    if keeps_apart("spirit", first, [("go1", second)], 0.05):
        assert not meet
        assert depth >= 0.03


@settings(deadline=None, max_examples=100)
@given(places, places, st.sampled_from([0.0, 0.05, 0.4]))
def test_bodies_keep_apart_if_they_do_along_a_side(first, second, gap):
    """As their corners say: apart along one of the four sides, at whatever distance."""
    one, other = MODELS["spirit"], MODELS["go1"]
    bodies = [rectangle_corners(first, one.length, one.width),
              rectangle_corners(second, other.length, other.width)]  # fmt: skip
    widest = -np.inf
    for yaw in (first[2], first[2] + math.pi / 2, second[2], second[2] + math.pi / 2):
        a, b = (body @ (math.cos(yaw), math.sin(yaw)) for body in bodies)
        widest = max(widest, b.min() - a.max(), a.min() - b.max())
    assume(abs(widest - gap) > 1e-9)
    assert keeps_apart("spirit", first, [("go1", second)], gap) == (widest > gap)
    far = ("go1", (9.0, 9.0, 0.0))
    assert keeps_apart("spirit", first, [far, ("go1", second)], gap) == (widest > gap)


@pytest.mark.parametrize("keep", ["colliding", "free"])
def test_straight_plans_collide_or_do_not(keep):
    sampler = section({"sampler": "pairs", "keep": keep})
    for seed in range(4):
        said = sampler.sample(seed, DATA).scenario
        paths, models = [], []
        for robot in said["robots"]:
            alone = plan(parse_scenario({**said, "robots": [robot]}))
            paths.append(alone.trajectories[0])
            models.append(MODELS[robot["model"]])
        times = np.arange(0.0, max(path.duration for path in paths), 0.01)
        poses = [path.poses_at(times) for path in paths]
        outlines = [
            np.array([_outline(model, pose, 12) for pose in track])
            for model, track in zip(models, poses, strict=True)
        ]
        inside = False
        for mine, his, model in ((0, 1, models[1]), (1, 0, models[0])):
            off = outlines[mine] - poses[his][:, None, :2]
            c, s = np.cos(poses[his][:, 2])[:, None], np.sin(poses[his][:, 2])[:, None]
            along = np.abs(c * off[..., 0] + s * off[..., 1]) < model.length / 2.0 - 0.01
            across = np.abs(c * off[..., 1] - s * off[..., 0]) < model.width / 2.0 - 0.01
            inside |= bool((along & across).any())
        if keep == "free":
            assert not inside
        deep = bodies_meet(models[0], poses[0], models[1], poses[1]).any()
        assert deep == (keep == "colliding")


def test_a_quick_look_needs_no_planner():
    sampler = section({"sampler": "pairs", "keep": "colliding"})
    assert unplanned(sampler).keep == "any"
    other = section(WORLDS["boxes"])
    assert unplanned(other) is other


def test_the_papers_straight_lines_sum_to_about_fifteen_metres():
    sampler = section(WORLDS["side-by-side"])
    sums = []
    for seed in range(300):
        robots = sampler.sample(seed, DATA).scenario["robots"]
        assert [robot["start"] for robot in robots] == [[10.0, 9.5, 0.0], [10.0, 10.5, 0.0]]
        sums.append(sum(math.dist(robot["start"][:2], robot["goal"][:2]) for robot in robots))
    assert 14.2 < np.mean(sums) < 15.4


def test_corridors_are_as_wide_as_they_should_be():
    for seed in range(8):
        for name, room in (("alcove", False), ("narrow", False), ("wide", True)):
            instance = section(WORLDS[name]).sample(seed, DATA)
            widths = [MODELS[robot["model"]].width for robot in instance.scenario["robots"]]
            assert (sum(widths) < instance.level) == room
            assert max(widths) < instance.level


def test_teams_grow_in_turn():
    sampler = section(WORLDS["boxes"])
    counts = [len(sampler.sample(seed, DATA).scenario["robots"]) for seed in range(4)]
    assert counts == [2, 6, 2, 6]


@pytest.mark.parametrize("kind", HOPELESS)
def test_hopeless_goals_cannot_be_reached(kind):
    sampler = section({"sampler": "infeasible", "kind": kind})
    for seed in range(5):
        instance = sampler.sample(seed, DATA)
        assert instance.expected == "infeasible"
        scenario = parse_scenario(instance.scenario)
        world = build_world(scenario)
        goals = [np.array([goal]) for goal in scenario.goals]
        overlap = any(
            bodies_meet(scenario.models[i], goals[i], scenario.models[j], goals[j])[0]
            for i, j in combinations(range(3), 2)
        )
        assert overlap == (kind in ("goals-overlap", "goals-equal"))
        ground = DiscRegions(OccupancyMap.empty((12.0, 8.0)), world.shapes, radius=0.17, step=0.05)
        reached = [
            ground.connect([start[:2]], [goal[:2]])
            for start, goal in zip(scenario.starts, scenario.goals, strict=True)
        ]
        if kind == "goal-in-a-hole":
            feet = [[x, y] for goal in scenario.goals for x, y in [goal[:2]]]
            assert world.terrain is not None
            assert world.terrain.in_hole(np.array(feet)).sum() == 1
        elif not overlap:
            assert reached.count(False) == 1


def test_overlapping_starts_are_bad_input():
    from cavalcade.errors import ScenarioError

    sampler = section({"sampler": "infeasible", "kind": "starts-overlap"})
    for seed in range(5):
        instance = sampler.sample(seed, DATA)
        assert instance.expected == "refused"
        with pytest.raises(ScenarioError, match="overlaps robot"):
            build_world(parse_scenario(instance.scenario))


@pytest.mark.parametrize(
    "said",
    [
        {"sampler": "pairs", "keep": "some"},
        {"sampler": "passing"},
        {"sampler": "boxes", "robots": [0]},
        {"sampler": "boxes", "robots": []},
        {"sampler": "terrain", "kind": "gap", "models": ["unicycle"]},
        {"sampler": "infeasible", "kind": "other"},
        {"sampler": "pairs", "budget": {"seconds": 0}},
    ],
)
def test_bad_values_are_refused(said):
    with pytest.raises(ValidationError):
        section(said)


def test_ground_without_room_is_bad_input():
    from cavalcade.errors import InputError

    for said in (
        {"sampler": "pairs", "size": [1, 1]},
        {"sampler": "boxes", "robots": [20], "size": [3, 3], "boxes": 0},
        {"sampler": "terrain", "kind": "flat", "zone": 0.9, "robots": 16, "size": [9, 2]},
    ):
        with pytest.raises(InputError):
            section(said).sample(0, DATA)
