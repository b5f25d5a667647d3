"""Changes of several parts of a draft at once, and what the page says of it."""

from __future__ import annotations

import math
from contextlib import nullcontext, suppress
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cavalcade.errors import InputError
from cavalcade.scenario import scenario_names
from cavalcade.studio.build.draft import Draft
from cavalcade.studio.build.edits import (
    with_formation,
    with_individual_goals,
    with_robot,
    with_team,
    with_world,
    without_robot,
)
from cavalcade.studio.build.guide import advice, ground, notes
from cavalcade.studio.build.obstacles import (
    at_pose,
    box_between,
    circle_between,
    obstacles_of,
    pose_of,
    wall_between,
    with_obstacle,
    with_one_more,
)
from cavalcade.studio.build.poses import moved, removed


@pytest.fixture
def draft() -> Draft:
    """Four robots in a square in an empty world."""
    made = Draft()
    made.replace(with_team(made.state, "go1", 4))
    return made


def test_a_team_gets_a_place_a_shape_and_a_goal(draft: Draft) -> None:
    assert draft.error is None
    assert draft.data["task"]["formation"] == {"shape": "square"}
    starts = np.array([pose[:2] for _, pose in draft.state.robots])
    assert min(math.dist(a, b) for a, b in combinations(starts.tolist(), 2)) > 0.9
    (goal,) = draft.state.goals
    assert goal[0] - starts[:, 0].max() > 8.0
    assert advice(draft.state).tone == "ready"
    assert notes(draft.state) == []


@pytest.mark.parametrize("count", [1, 2, 3, 5, 12])
@pytest.mark.parametrize("name", ["office", "triangle-corridor", "maze-solo", "tour-ten"])
def test_a_team_finds_room_or_is_refused_in_words(name: str, count: int) -> None:
    draft = Draft()
    draft.load(name)
    with suppress(InputError) if count > 10 else nullcontext():
        draft.replace(with_team(draft.state, "go1", count))
        assert len(draft.state.robots) == count
    assert draft.error is None


def test_goals_are_made_individual_and_back(draft: Draft) -> None:
    draft.set("planner.lookahead", 4.0)
    draft.set("execution.events", [{"at": 3.0, "lose": 1}])
    draft.replace(with_individual_goals(draft.state))
    assert draft.error is None
    assert len(draft.state.goals) == 4
    assert "events" not in draft.data["execution"]
    draft.set("planner.method", "cbs")
    draft.replace(with_formation(draft.state))
    assert draft.error is None
    assert draft.state.goals == ((12.4, 5.0, 0.0),)


@pytest.mark.parametrize(
    "world",
    [
        {"empty": {"size": [7, 20]}},
        {"generate": {"kind": "maze", "size": [16, 10], "seed": 1}},
        {"generate": {"kind": "rough", "size": [16, 10], "seed": 1}},
        {"empty": {"size": [14, 10]}, "obstacles": [{"box": {"center": [2, 5], "size": [4, 4]}}]},
    ],
)
def test_a_team_that_cannot_stand_on_new_ground_is_placed_anew(
    draft: Draft, world: dict[str, Any]
) -> None:
    draft.replace(with_world(draft, world))
    assert draft.error is None
    assert len(draft.state.robots) == 4
    assert "maze" in str(world) or notes(draft.state) == []
    assert "rough" not in str(world) or "individual" in str(draft.data["task"])


def test_a_team_that_can_stay_stays(draft: Draft) -> None:
    starts = draft.data["robots"]
    draft.replace(with_world(draft, {"empty": {"size": [20, 12]}}))
    assert draft.data["robots"] == starts


def test_ground_without_room_is_refused_and_nothing_is_lost(draft: Draft) -> None:
    before = draft.data
    for size in ([1.0, 1.0], [0.0, 3.0]):
        with pytest.raises(InputError):
            draft.replace(with_world(draft, {"empty": {"size": size}}))
    assert draft.data is before


def test_the_shape_follows_the_number_of_robots(draft: Draft) -> None:
    draft.replace(with_robot(draft.state, "go1", (7.0, 7.0, 0.0)))
    assert draft.data["task"]["formation"] == {"shape": "wedge"}
    for _ in range(2):
        draft.replace(without_robot(draft.state, 0))
    assert draft.data["task"]["formation"] == {"shape": "wedge"}
    for count in (2, 1, 0):
        draft.replace(without_robot(draft.state, 0))
        assert len(draft.state.robots) == count
    assert draft.error is not None


def test_clicks_become_obstacles() -> None:
    assert box_between((2.0, 3.0), (1.0, 5.0)) == {"box": {"center": [1.5, 4.0], "size": [1, 2]}}
    assert box_between((2.0, 3.0), (2.0, 3.01))["box"]["size"] == [0.6, 0.6]
    assert circle_between((1.0, 1.0), (1.0, 3.0))["circle"] == {"center": [1.0, 1.0], "radius": 2.0}
    assert circle_between((1.0, 1.0), (1.0, 1.0))["circle"]["radius"] == 0.3
    wall = wall_between((1.0, 1.0), (1.0, 3.0), 0.2)["box"]
    assert wall == {"center": [1.0, 2.0], "size": [2.0, 0.2], "yaw": 1.571}


@pytest.mark.parametrize("name", ["square-clutter", "tour-ten"])
def test_obstacles_are_moved_and_taken_away_one_by_one(name: str) -> None:
    draft = Draft()
    draft.load(name)
    count = len(obstacles_of(draft.state))
    index = count - 1
    there = pose_of(obstacles_of(draft.state)[index])
    draft.replace(moved(draft.state, "obstacle", index, (there[0] + 0.1, there[1], there[2])))
    others = obstacles_of(draft.state)
    assert len(others) == count
    assert pose_of(others[index])[0] == pytest.approx(there[0] + 0.1, abs=2e-3)
    draft.replace(removed(draft.state, "obstacle", index))
    assert obstacles_of(draft.state) == others[:index]
    draft.replace(with_one_more(draft.state, others[index]))
    assert len(obstacles_of(draft.state)) == count
    assert draft.error is None


def test_a_generated_world_is_listed_from_its_first_change_on(draft: Draft) -> None:
    world = {"generate": {"kind": "forest", "size": [14, 10], "seed": 2}}
    draft.replace(with_world(draft, world))
    assert draft.data["world"] == world
    assert ground(draft.state).startswith("generated forest, 14 × 10 m")
    before = obstacles_of(draft.state)
    draft.replace(with_obstacle(draft.state, None, 3))
    assert "generate" not in draft.data["world"]
    assert obstacles_of(draft.state) == before[:3] + before[4:]


@settings(deadline=None, max_examples=50)
@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3))
def test_an_obstacle_that_is_put_somewhere_is_there(x: float, y: float, yaw: float) -> None:
    for obstacle in (
        {"box": {"center": [1.0, 2.0], "size": [0.4, 0.6]}},
        {"circle": {"center": [1.0, 2.0], "radius": 0.3}},
        {"polygon": {"points": [[0, 0], [1, 0], [0, 1]]}},
    ):
        assert pose_of(at_pose(obstacle, (x, y, yaw)))[:2] == pytest.approx((x, y), abs=2e-3)


def test_what_probably_is_not_meant_is_said(draft: Draft) -> None:
    draft.replace(moved(draft.state, "goal", 0, (13.9, 5.0, 0.0)))
    assert notes(draft.state) == ["Goal 0: the team does not fit; it will go to the nearest place."]
    draft.set("execution.rate", 2.0)
    assert any("execution.rate" in note for note in notes(draft.state))


def test_every_shipped_scenario_is_ready_and_said_in_words() -> None:
    draft = Draft()
    for name in scenario_names():
        draft.load(name)
        said = advice(draft.state)
        assert said.tone == "ready"
        assert len(said.text) < 160
        assert " m, cells of " in ground(draft.state)
