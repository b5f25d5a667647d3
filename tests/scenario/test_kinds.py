"""Tasks of two kinds: what individual goals need, what goes together and what does not."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from cavalcade.errors import InputError, ScenarioError
from cavalcade.scenario import dump_scenario, load_scenario, parse_scenario, scenario_schema

Data = dict[str, Any]

_ONE: Data = {
    "version": 1,
    "name": "single",
    "world": {"empty": {"size": [8, 5]}},
    "robots": [
        {"model": "spirit", "start": [1.0, 2.5, 0.0], "goal": [7.0, 2.5, 0.0]},
        {"model": "go1", "start": [7.0, 1.0, 3.0], "goal": [1.0, 1.0, 3.0]},
    ],
    "task": {"goals": "individual"},
}


@pytest.fixture
def single() -> Data:
    return copy.deepcopy(_ONE)


def test_defaults_of_individual_goals_are_written_out(single: Data, tmp_path: Path) -> None:
    scenario = parse_scenario(single)
    assert scenario.task.kind == "individual"
    assert scenario.task.goals == ()
    assert scenario.goals == ((7.0, 2.5, 0.0), (1.0, 1.0, 3.0))
    dump_scenario(scenario, tmp_path / "s.yaml")
    written = yaml.safe_load((tmp_path / "s.yaml").read_text(encoding="utf-8"))
    assert written["task"] == {"goals": "individual"}
    assert written["planner"] == {
        "method": "auto",
        "variant": "cavalcade",
        "constraints": "timed",
        "conflict": "costly",
        "leaps": True,
        "improve": 0,
        "margin": None,  # the backend's own
        "despeckle": 0.0,
        "budget": {"iterations": None, "seconds": None},
    }
    assert load_scenario(tmp_path / "s.yaml") == scenario


def test_the_published_variant_means_the_papers_options(single: Data) -> None:
    single["planner"] = {"method": "cbs", "variant": "published"}
    planner = parse_scenario(single).planner
    assert (planner.constraints, planner.conflict) == ("static", "first")
    single["planner"]["constraints"] = "timed"
    planner = parse_scenario(single).planner
    assert (planner.constraints, planner.conflict) == ("timed", "first")


@pytest.mark.parametrize("method", ["sequential", "joint", "cbs", "auto"])
def test_overrides_choose_the_method(single: Data, tmp_path: Path, method: str) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(yaml.safe_dump(single), encoding="utf-8")
    said = [f"planner.method={method}", "planner.leaps=false", "planner.budget.iterations=10"]
    planner = load_scenario(path, said).planner
    assert (planner.method, planner.leaps, planner.budget.iterations) == (method, False, 10)


def test_formations_stay_what_they_were(data: Data, tmp_path: Path) -> None:
    scenario = parse_scenario(data)
    assert scenario.task.kind == "formation"
    assert scenario.planner.method == "formation"
    assert scenario.goals == ()
    dump_scenario(scenario, tmp_path / "s.yaml")
    written = yaml.safe_load((tmp_path / "s.yaml").read_text(encoding="utf-8"))
    assert "leaps" not in written["planner"]
    assert "lookahead" in written["planner"]


def test_individual_goals_have_no_formation_to_ask_for(single: Data) -> None:
    with pytest.raises(InputError, match=r"task\.formation: goals are individual"):
        _ = parse_scenario(single).task.the_formation


def test_the_schema_knows_both_kinds() -> None:
    schema = scenario_schema()
    goals = schema["$defs"]["TaskSection"]["properties"]["goals"]
    assert {"const": "individual", "type": "string"} in goals["anyOf"]
    assert goals["anyOf"][0]["minItems"] == 1


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        (
            "robots.1.goal",
            None,
            "robots[1].goal: missing; with individual goals each robot has one",
        ),
        ("robots.1.goal", [1, 2], "robots[1].goal: expected [x, y, yaw]: 3 numbers"),
        ("robots.0.model", "go9", "robots[0].model: unknown robot model 'go9' (one of: go1, go2"),
        ("task.formation", {"shape": "line"}, "task.formation: individual goals take no formation"),
        ("planner.method", "formation", "planner.method: method formation has no individual goals"),
        ("planner.variant", "no-springs", "planner.variant: method auto has no variant no-springs"),
        ("planner.lookahead", 5.0, "planner.lookahead: is for formations; goals are individual"),
        ("planner.preset", "laboratory", "planner.preset: is for formations; goals are individual"),
        ("planner.expect", {"delay": {"mean": 1}}, "planner.expect: is for formations"),
        ("planner.constraints", "hard", "planner.constraints: unknown value 'hard' (one of: timed"),
        ("planner.conflict", "last", "planner.conflict: unknown value 'last' (one of: costly"),
        ("planner.leaps", "yes", "planner.leaps: "),
        ("planner.improve", -1, "planner.improve: expected greater than or equal to 0"),
        ("planner.margin", -0.1, "planner.margin: expected greater than or equal to 0"),
        ("planner.budget.iterations", 0, "planner.budget.iterations: expected greater than 0"),
        ("planner.budget.seconds", 0, "planner.budget.seconds: expected greater than 0"),
        ("execution.noise.position", 0.1, "execution.noise: individual goals are planned ahead"),
        ("execution.delay.mean", 0.1, "execution.delay: individual goals are planned ahead"),
        ("execution.events", [{"at": 1, "lose": 1}], "execution.events: individual goals are plan"),
    ],
)
def test_what_does_not_go_with_individual_goals(
    single: Data, key: str, value: Any, message: str
) -> None:
    here: Any = single
    *path, last = key.split(".")
    for part in path:
        here = here[int(part)] if isinstance(here, list) else here.setdefault(part, {})
    here[last] = value
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(single, "a.yaml")
    text = str(caught.value)
    assert message in text
    assert text.startswith("a.yaml: ")
    assert "\n" not in text


@pytest.mark.parametrize(
    ("world", "key"),
    [
        ({"terrain": "hills.yaml"}, "world.terrain"),
        ({"generate": {"kind": "step", "size": [8, 5]}}, "world.generate.kind"),
    ],
)
def test_formations_and_wheels_need_level_ground(
    data: Data, single: Data, world: Data, key: str
) -> None:
    with pytest.raises(ScenarioError, match=f"{key}: formations need level ground"):
        parse_scenario({**data, "world": world})
    assert parse_scenario({**single, "world": world}).world.has_heights
    single["robots"][1]["model"] = "unicycle"
    assert not parse_scenario(single).world.has_heights
    with pytest.raises(ScenarioError, match=r"robots\[1\]\.model: a unicycle needs level ground"):
        parse_scenario({**single, "world": world})


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"kind": "gap", "trees": 3},
            "world.generate.trees: a gap has no such option (one of: wid",
        ),
        ({"kind": "gap", "radius": 0.5}, "world.generate.radius: a gap has no such option"),
        (
            {"kind": "gap", "require_feasible": False},
            "world.generate.require_feasible: a gap has no",
        ),
        ({"kind": "clutter", "depth": 3}, "world.generate.depth: a clutter has no such option"),
        ({"kind": "hill"}, "world.generate.kind: unknown value 'hill' (one of: clutter"),
    ],
)
def test_options_of_generated_terrain(single: Data, options: Data, message: str) -> None:
    single["world"] = {"generate": {"size": [8, 5], **options}}
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(single)
    assert message in str(caught.value)


def test_terrain_options_match_the_generators() -> None:
    from cavalcade.scenario.ground import TERRAIN_OPTIONS, GenerateSource
    from cavalcade.world import TERRAINS, terrain_options

    assert set(TERRAIN_OPTIONS) == set(TERRAINS)
    for kind, names in TERRAIN_OPTIONS.items():
        assert set(terrain_options(kind)) == set(names)
        assert set(names) <= set(GenerateSource.model_fields)
