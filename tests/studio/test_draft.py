"""The scenario that is being built, without a page."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cavalcade.errors import InputError, ScenarioError
from cavalcade.scenario import (
    build_world,
    load_scenario,
    parse_scenario,
    resolve_scenario,
    scenario_names,
)
from cavalcade.studio.build.draft import Draft
from cavalcade.world import OccupancyMap, save_map


@pytest.fixture
def draft() -> Draft:
    """A team of two that is ready to go."""
    made = Draft()
    made.set("robots", [{"start": [1.0, 2.0, 0.0]}, {"start": [1.0, 3.0, 0.0]}])
    made.set("task", {"formation": {"shape": "line"}, "goals": [[12.0, 5.0, 0.0]]})
    return made


def test_a_new_draft_lacks_what_can_be_added_and_says_so() -> None:
    draft = Draft()
    assert draft.scenario is None
    assert draft.error is not None
    assert draft.error.startswith("robots: ")
    draft.set("robots", [{"start": [1.0, 1.0, 0.0]}])
    assert draft.error is not None
    assert draft.error.startswith("task: ")
    draft.set("task", {"formation": {"shape": "column"}})
    assert draft.error == "task.goals: missing"
    draft.set("task.goals", [[5.0, 5.0, 0.0]])
    assert draft.error is None
    assert draft.scenario is not None
    build_world(draft.scenario)


def test_robots_of_a_square_may_come_one_by_one(draft: Draft) -> None:
    draft.set("task.formation", {"shape": "square"})
    assert draft.error == "task.formation: the square has 4 slots, the team 2 robots"
    assert len(draft.state.robots) == 2
    draft.set("robots", [*draft.data["robots"], {"start": [3, 2, 0]}, {"start": [3, 3, 0]}])
    assert draft.error is None


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("planner.lookahead", -1, "expected greater than 0, got -1"),
        ("planner.lookahead", "soon", "expected a number, got 'soon'"),
        ("planner.lookahaed", 3, "unknown key; did you mean lookahead?"),
        ("robots[0].start", [1.0, 3.0, 0.0], "overlaps robot"),
        ("robots[0].start", [0.1, 3.0, 0.0], "reaches beyond the map"),
        ("robots[7].start", [1.0, 3.0, 0.0], "expected an index below 2"),
        ("robots[0].model", "horse", "unknown robot model 'horse'"),
        ("task.formation.side", -1.0, "expected greater than 0"),
        ("execution.events", [{"at": 3.0, "lose": 5}], "there is no robot 5"),
        ("world.map", "nowhere.yaml", "expected exactly one source"),
        ("world.empty.size", [0, 5], "expected greater than 0"),
        ("version", 2, "expected 1"),
        ("execution.backend", "warp", "unknown value 'warp'"),
    ],
)
def test_what_is_refused_leaves_the_draft_as_it_was(
    draft: Draft, path: str, value: Any, words: str
) -> None:
    before, scenario = copy.deepcopy(draft.data), draft.scenario
    with pytest.raises(InputError) as caught:
        draft.set(path, value)
    assert words in str(caught.value)
    assert draft.data == before
    assert draft.scenario is scenario


def test_a_change_is_refused_in_the_words_that_a_file_is(draft: Draft) -> None:
    data = copy.deepcopy(draft.data)
    data["planner"] = {"r_max": 0}
    with pytest.raises(ScenarioError) as of_file:
        parse_scenario(data)
    with pytest.raises(ScenarioError) as of_draft:
        draft.set("planner.r_max", 0)
    assert str(of_draft.value) == str(of_file.value)


def test_undo_and_redo_go_through_every_step(draft: Draft) -> None:
    said: list[None] = []
    draft.changed.append(lambda: said.append(None))
    states = [draft.data]
    for rate in (10.0, 15.0, 30.0):
        draft.set("execution.rate", rate)
        states.append(draft.data)
    for state in reversed(states[:-1]):
        assert draft.undo()
        assert draft.data == state
    for state in states[1:]:
        assert draft.redo()
        assert draft.data == state
    assert not draft.redo()
    assert len(said) == 9
    draft.undo()
    draft.set("execution.rate", 40.0)
    assert not draft.can_redo


def test_none_takes_a_value_away_and_what_then_says_nothing(draft: Draft) -> None:
    draft.set("planner.expect.noise.position", 0.1)
    draft.set("planner.expect.noise.position", None)
    assert draft.scenario is not None
    assert draft.scenario.planner.expect.noise is None
    assert draft.data.get("planner", {}) == {}


def test_what_is_the_same_is_no_step(draft: Draft) -> None:
    draft.set("execution.seed", 3)
    draft.set("execution.seed", 3)
    draft.undo()
    assert "execution" not in draft.data


def test_values_of_numpy_are_taken(draft: Draft, tmp_path: Path) -> None:
    draft.set("robots[0].start", np.array([2.0, 2.0, 0.0]))
    file = tmp_path / "a.yaml"
    file.write_text(draft.export(), "utf-8")
    assert load_scenario(file) == draft.scenario


@pytest.mark.parametrize("name", scenario_names())
def test_a_shipped_scenario_is_loaded_and_exported_unchanged(name: str, tmp_path: Path) -> None:
    draft = Draft()
    draft.load(name)
    assert draft.scenario == load_scenario(name)
    file = tmp_path / "deep" / "er" / "exported.yaml"
    file.parent.mkdir(parents=True)
    for folder in (None, file.parent):
        file.write_text(draft.export(folder), "utf-8")
        if folder is None:
            assert load_scenario(file) == draft.scenario
        again = Draft()
        again.load(file)
        assert again.data == draft.data


def test_a_broken_file_is_refused_by_its_name(draft: Draft, tmp_path: Path) -> None:
    before = draft.data
    file = tmp_path / "broken.yaml"
    for text in ("version: 1\nworld: {", "[]", "", "version: 1\nname: x\n", "\x00"):
        file.write_text(text, "utf-8")
        with pytest.raises(ScenarioError, match=r"broken\.yaml"):
            draft.load(file)
    with pytest.raises(ScenarioError, match="no such file"):
        draft.load(tmp_path / "none.yaml")
    assert draft.data is before


def test_an_unfinished_draft_is_not_exported() -> None:
    with pytest.raises(ScenarioError, match="robots"):
        Draft().export()


def test_the_ground_is_made_again_only_when_it_changes() -> None:
    draft = Draft()
    draft.load("tour-ten")
    world = draft.state.world
    draft.set("planner.lookahead", 4.0)
    draft.set("robots[0].start", list(draft.data["robots"][0]["start"]))
    assert draft.state.world is world
    draft.set("world.obstacles", [])
    assert draft.state.world is not world


def test_a_generated_world_is_that_of_its_file() -> None:
    draft = Draft()
    draft.replace(
        {**draft.data, "world": {"generate": {"kind": "clutter", "size": [14, 10], "seed": 4}}}
    )
    draft.set("robots", [{"start": [1.0, 5.0, 0.0]}])
    draft.set("task", {"formation": {"shape": "line"}, "goals": [[13.0, 5.0, 0.0]]})
    assert draft.scenario is not None
    assert draft.state.shown == resolve_scenario(draft.scenario)


VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 30),
    st.floats(-5.0, 15.0),
    st.sampled_from([float("inf"), float("nan"), "published", "individual", "", "mujoco"]),
    st.lists(st.floats(-1.0, 15.0), max_size=4),
    st.just({}),
    st.just([{"start": [4.0, 4.0, 0.0]}]),
    st.just([[5.0, 5.0, 0.0]]),
    st.just([{"circle": {"center": [6.0, 5.0], "radius": 0.3}}]),
    st.just([{"at": 3.0, "lose": 0}, {"at": 6.0, "rejoin": 0}]),
    st.sampled_from([{"shape": "line"}, {"shape": "square", "side": 1.2}, {"shape": "custom"}]),
)
PATHS = st.sampled_from(
    [
        "name",
        "version",
        "world",
        "world.empty.size",
        "world.resolution",
        "world.obstacles",
        "robots",
        "robots[0].start",
        "robots[1].goal",
        "robots[0].model",
        "task",
        "task.goals",
        "task.formation",
        "task.formation.spacing",
        "planner",
        "planner.variant",
        "planner.lookahead",
        "planner.leaps",
        "planner.expect.noise",
        "execution.rate",
        "execution.events",
        "execution.backend",
        "nonsense",
        "",
        "a..b",
    ]
)
STEPS = st.lists(
    st.one_of(st.sampled_from(["undo", "redo"]), st.tuples(PATHS, VALUES)), max_size=12
)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(STEPS)
def test_any_sequence_of_changes_leaves_a_valid_scenario_or_the_same_one(
    tmp_path: Path, steps: list[Any]
) -> None:
    draft = Draft()
    draft.load("triangle-lab")
    for step in steps:
        before, state = copy.deepcopy(draft.data), draft.state
        try:
            if isinstance(step, str):
                getattr(draft, step)()
            else:
                draft.set(*step)
        except InputError:
            assert draft.data == before
            assert draft.state is state
        if draft.scenario is None:
            assert draft.error
            with pytest.raises(ScenarioError):
                parse_scenario(draft.data)
            continue
        assert draft.error is None
        build_world(parse_scenario(draft.data))
        file = tmp_path / "exported.yaml"
        file.write_text(draft.export(), "utf-8")
        assert load_scenario(file) == draft.scenario


def test_undo_to_a_map_that_is_gone_is_refused_and_nothing_is_lost(tmp_path: Path) -> None:
    save_map(OccupancyMap(np.zeros((60, 80), dtype=bool), 0.1), tmp_path / "lab.yaml")
    draft = Draft()
    draft.set("world", {"map": str(tmp_path / "lab.yaml")})
    draft.set("world", {"empty": {"size": [8.0, 6.0]}})
    for file in tmp_path.iterdir():
        file.unlink()
    before = draft.data
    with pytest.raises(InputError, match="no such file"):
        draft.undo()
    assert draft.data is before
    assert draft.can_undo
