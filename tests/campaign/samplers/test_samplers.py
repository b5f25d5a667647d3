from __future__ import annotations

import json
import math
from itertools import combinations

import numpy as np
import pytest
from pydantic import ValidationError

from cavalcade.campaign.samplers import SAMPLERS, DataFolder
from cavalcade.campaign.samplers.feasibility import RADIUS
from cavalcade.campaign.samplers.generated import GeneratedSampler
from cavalcade.errors import InputError
from cavalcade.scenario import build_world, parse_scenario, resolve_scenario
from cavalcade.world import is_connected

SQUARE = {"shape": "square", "side": 1.0}
TRIANGLE = {"shape": "triangle", "side": 1.0}
GENERATED = {
    "clutter": {"kind": "clutter", "size": [10, 8], "obstacles": [10, 25]},
    "forest": {"kind": "forest", "size": [10, 8], "trees": [5, 20], "poses": "anywhere"},
    "rooms": {
        "kind": "rooms",
        "size": [12, 8],
        "door": [1.0, 1.6],
        "poses": "anywhere",
    },
    "corridor": {
        "kind": "corridor",
        "size": [12, 8],
        "width": [0.9, 1.5],
        "bends": [2, 3],
        "poses": "anywhere",
    },
}
WORLDS = {
    **{name: {"sampler": "generated", "team": SQUARE, **said} for name, said in GENERATED.items()},
    "crowd": {"sampler": "crowd", "robots": [2, 5]},
    "events": {"sampler": "events", "obstacles": 12},
    "shipped": {"sampler": "shipped", "scenario": "square-clutter"},
    "barn": {"sampler": "barn", "teams": [{"shape": "line", "robots": 1}, TRIANGLE]},
    "maps": {"sampler": "maps", "maps": [{"file": "halls.yaml"}], "teams": [SQUARE, TRIANGLE]},
}


def section(said):
    return SAMPLERS.get(said["sampler"], GeneratedSampler).model_validate(said)


@pytest.mark.parametrize("name", WORLDS)
def test_laws_of_every_draw(name, data):
    sampler = section(WORLDS[name])
    assert sampler.missing(data) is None
    seen = []
    for seed in range(4):
        instance = sampler.sample(seed, data)
        assert instance == sampler.sample(seed, data)
        assert isinstance(instance.feasible, bool)
        assert (instance.level is None) == (sampler.level_name is None)
        assert ("planner" in instance.scenario) == (name == "shipped")
        assert instance.scenario["execution"]["seed"] == seed
        assert instance.scenario["execution"]["timeout"] > 0
        plain = json.loads(json.dumps(instance.scenario))
        assert plain == instance.scenario
        scenario = resolve_scenario(parse_scenario(plain))
        build_world(scenario)  # refuses starts in an obstacle
        seen.append(json.dumps({**plain, "name": "", "execution": {}}))
    if name != "shipped":
        assert len(set(seen)) == len(seen)


@pytest.mark.parametrize("name", WORLDS)
def test_what_a_section_writes_it_reads(name, data):
    sampler = section(WORLDS[name])
    again = section(json.loads(json.dumps(sampler.model_dump(mode="json"))))
    assert again == sampler
    assert again.sample(1, data) == sampler.sample(1, data)


@pytest.mark.parametrize("name", ["clutter", "forest", "rooms", "corridor", "crowd"])
def test_feasible_as_the_generators_test_says(name, data):
    sampler = section(WORLDS[name])
    for seed in range(4):
        instance = sampler.sample(seed, data)
        scenario = resolve_scenario(parse_scenario(instance.scenario))
        world = build_world(scenario)
        start, goal = scenario.starts[0], scenario.task.goals[0]
        if is_connected(world.shapes, world.base.size, start, goal, RADIUS + 0.02):
            assert instance.feasible
        if instance.feasible:
            assert is_connected(world.shapes, world.base.size, start, goal, RADIUS - 0.04)


def test_generated_values_come_from_their_ranges(data):
    obstacles, widths = set(), []
    for seed in range(12):
        world = section(WORLDS["clutter"]).sample(seed, data)
        obstacles.add(world.level)
        assert world.scenario["world"]["generate"]["obstacles"] == world.level
        widths.append(section(WORLDS["corridor"]).sample(seed, data).level)
    assert len(obstacles) > 4
    assert min(obstacles) >= 10
    assert max(obstacles) <= 25
    assert 0.9 <= min(widths) < 1.1 < 1.3 < max(widths) <= 1.5


def test_clutter_starts_and_ends_in_the_middle(data):
    sampler = section({"sampler": "generated", "kind": "clutter", "size": [14, 10], "team": SQUARE})
    instance = sampler.sample(0, data)
    starts = np.array([robot["start"] for robot in instance.scenario["robots"]])
    assert starts.mean(axis=0) == pytest.approx([1.4, 5.0, 0.0])
    assert instance.scenario["task"]["goals"] == [[12.6, 5.0, 0.0]]


def test_rooms_lie_apart(data):
    sampler = section(WORLDS["rooms"] | {"apart": 3})
    for seed in range(6):
        instance = sampler.sample(seed, data)
        start = np.mean([robot["start"] for robot in instance.scenario["robots"]], axis=0)
        rooms = [np.floor(np.array(pose[:2]) / 4.0) for pose in (start, *_goals(instance))]
        assert np.abs(rooms[0] - rooms[1]).sum() >= 3


def _goals(instance):
    return instance.scenario["task"]["goals"]


@pytest.mark.parametrize(
    ("said", "key"),
    [
        ({"apart": 9}, "apart"),
        ({"door": 3.9}, "door"),
        ({"team": {"shape": "line", "robots": 9}}, "team"),
    ],
)
def test_generated_worlds_that_cannot_be(said, key, data):
    sampler = section(WORLDS["rooms"] | said)
    with pytest.raises(InputError) as caught:
        sampler.sample(0, data)
    assert caught.value.key == key


@pytest.mark.parametrize(
    "said",
    [
        {"trees": 3},  # not of clutter
        {"obstacles": [9, 3]},
        {"obstacles": [1, 2, 3]},
        {"obstacles": 2.5},
        {"kind": "maze"},
        {"team": {"shape": "line"}},
        {"team": {"shape": "square", "robots": 3}},
        {"team": {"shape": "circle", "side": 1.0, "robots": 3}},
        {"team": {"shape": "line", "spacing": 0.1, "robots": 3}},
        {"poses": "somewhere"},
        {"colour": "red"},
        {"sampler": "lots"},
    ],
)
def test_bad_sections(said):
    with pytest.raises(ValidationError):
        section(WORLDS["clutter"] | said)


def test_crowds_take_turns(data):
    sampler = section(WORLDS["crowd"])
    found = []
    for seed in range(18):
        instance = sampler.sample(seed, data)
        team = instance.scenario["task"]["formation"]["shape"], len(instance.scenario["robots"])
        assert instance.level == team[1]
        found.append(team)
    assert len(set(found)) == 18  # four shapes of two to five robots, a square and a triangle
    again = sampler.sample(18, data).scenario["task"]["formation"]["shape"]
    assert again == found[0][0]


def test_crowds_of_a_custom_shape(data):
    slots = [[0.5, 0.0], [0.0, 0.25], [-0.5, -0.25]]
    said = {"sampler": "crowd", "shapes": ["custom"], "slots": slots, "spacing": [0.9, 1.0]}
    instance = section(said).sample(0, data)
    formation = instance.scenario["task"]["formation"]
    assert formation["shape"] == "custom"
    closest = min(math.dist(p, q) for p, q in combinations(formation["slots"], 2))
    assert 0.898 <= closest <= 1.002
    assert instance.level == 3


@pytest.mark.parametrize(
    "said",
    [
        {"shapes": ["custom"]},
        {"slots": [[0.0, 0.0], [1.0, 0.0]]},
        {"shapes": ["custom"], "slots": [[0.0, 0.0], [0.0, 0.0]]},
        {"shapes": ["custom"], "slots": [[0.0, 0.0]]},
        {"shapes": ["custom"], "slots": []},
    ],
)
def test_bad_custom_shapes(said):
    with pytest.raises(ValidationError):
        section({"sampler": "crowd", **said})


def test_events_hold_all_that_happens(data):
    sampler = section(WORLDS["events"])
    for seed in range(3):
        events = sampler.sample(seed, data).scenario["execution"]["events"]
        kinds = [next(key for key in event if key != "at") for event in events]
        assert 1 <= kinds.count("add") <= 3
        assert kinds.count("move") <= 2
        assert [kinds.count(kind) for kind in ("formation", "lose", "goals")] == [1, 1, 1]
        times = [event["at"] for event in events]
        assert times == sorted(set(times))


def test_shipped_ones_keep_what_they_say(data):
    instance = section(WORLDS["shipped"]).sample(7, data)
    assert instance.feasible
    assert instance.scenario["name"] == "square-clutter"
    blocked = section({"sampler": "shipped", "scenario": "infeasible"}).sample(0, data)
    assert not blocked.feasible
    with pytest.raises(ValidationError, match="expected a shipped scenario"):
        section({"sampler": "shipped", "scenario": "square-cluter"})


def test_no_data_needed():
    nothing = DataFolder(None)
    for name in ("clutter", "crowd", "events", "shipped"):
        sampler = section(WORLDS[name])
        assert sampler.missing(nothing) is None
        assert sampler.limit(nothing) is None


def test_a_scenario_keeps_what_it_says_of_the_planner(data):
    instance = section({"sampler": "shipped", "scenario": "triangle-lab"}).sample(3, data)
    assert instance.scenario["planner"]["preset"] == "laboratory"
    assert instance.scenario["planner"]["lookahead"] == 2.5
