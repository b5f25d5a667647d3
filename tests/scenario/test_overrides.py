"""`--set`: dotted paths over the file."""

from __future__ import annotations

from typing import Any

import pytest

from cavalcade.errors import ScenarioError
from cavalcade.scenario import parse_scenario
from cavalcade.scenario.overrides import apply_overrides

Data = dict[str, Any]


def test_values_are_yaml_and_missing_sections_are_made(data: Data) -> None:
    said = [
        "planner.variant=published",
        "execution.noise.position=0.02",
        "world.empty.size=[9, 6]",
        "robots[1].start=[0.7, 1.5, 0]",
        "robots.0.model=spirit",
        "planner.lookahead=null",
    ]
    apply_overrides(data, said, "a.yaml")
    scenario = parse_scenario(data)
    assert scenario.planner.variant == "published"
    assert scenario.execution.noise.position == 0.02
    assert scenario.world.empty is not None
    assert scenario.world.empty.size == (9.0, 6.0)
    assert scenario.robots[1].start == (0.7, 1.5, 0.0)
    assert scenario.robots[0].model == "spirit"
    assert scenario.planner.lookahead is None


def test_a_mapping_gives_plain_values(data: Data) -> None:
    apply_overrides(data, {"execution.rate": 50, "task.goals": [[1, 1, 0]]}, None)
    scenario = parse_scenario(data)
    assert scenario.execution.rate == 50.0
    assert scenario.task.goals == ((1.0, 1.0, 0.0),)


def test_one_text_is_one_override(data: Data) -> None:
    apply_overrides(data, "execution.rate=50", None)
    assert data["execution"]["rate"] == 50


@pytest.mark.parametrize("key", ["robots.*.model", "robots[*].model"])
def test_a_star_is_every_element_of_a_list(data: Data, key: str) -> None:
    apply_overrides(data, [f"{key}=spirit"], None)
    assert len(data["robots"]) > 1
    assert [robot.model for robot in parse_scenario(data).robots] == ["spirit"] * len(
        data["robots"]
    )


def test_what_a_star_sets_is_one_value_for_each(data: Data) -> None:
    apply_overrides(data, ["robots.*.start=[1, 1, 0]", "robots[0].start[0]=2"], None)
    assert [robot["start"][0] for robot in data["robots"][:2]] == [2, 1]


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ("planner.variant", "--set: expected KEY=VALUE"),
        ("=3", "--set: expected KEY=VALUE"),
        ("a..b=3", "--set: expected a dotted path"),
        ("robots[x].start=3", "--set: expected a dotted path"),
        ("robots[7].start=3", "robots[7].start: expected an index below 2 or * for a list, got 7"),
        ("robots.first=3", "robots.first: expected an index below 2 or * for a list, got first"),
        ("world.*=3", "world.*: * stands for the elements of a list"),
        ("*=3", "*: * stands for the elements of a list"),
        ("robots.*x=3", "--set: expected a dotted path"),
        ("robots.*.model.x=3", "robots.*.model.x: there is nothing below model"),
        ("version.x=3", "version.x: there is nothing below version"),
        ("name=[1", "--set name: not valid YAML"),
    ],
)
def test_malformed_ones_are_named(data: Data, said: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        apply_overrides(data, [said], "a.yaml")
    assert message in str(caught.value)


def test_an_unknown_key_is_found_by_the_schema(data: Data) -> None:
    apply_overrides(data, ["planer.variant=published"], "a.yaml")
    with pytest.raises(ScenarioError, match="planer: unknown key; did you mean planner"):
        parse_scenario(data, "a.yaml")
