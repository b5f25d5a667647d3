"""Tasks of commands: what they are, what goes together, and one line where it does not."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from cavalcade.errors import ScenarioError
from cavalcade.scenario import dump_scenario, load_scenario, parse_scenario, scenario_schema

Data = dict[str, Any]

_WALK: Data = {
    "version": 1,
    "name": "walk",
    "world": {"empty": {"size": [8, 5]}},
    "robots": [{"start": [1.0, 1.5, 0.0]}, {"start": [1.0, 3.5, 0.0]}],
    "task": {
        "commands": [
            {"at": 4, "robot": 1, "to": [6, 4]},
            {"at": 0.5, "velocity": [0.4, 0, 0]},
        ]
    },
}


@pytest.fixture
def walk() -> Data:
    return copy.deepcopy(_WALK)


def test_commands_are_in_order_of_time_and_last_two_seconds_more(walk: Data) -> None:
    task = parse_scenario(walk).task
    assert task.commands is not None
    assert [command.at for command in task.commands] == [0.5, 4.0]
    assert (task.kind, task.formation, task.goals) == ("commands", None, ())
    assert task.length == 6.0
    assert task.commands[1].pace == 0.4
    walk["task"]["duration"] = 3
    assert parse_scenario(walk).task.length == 3.0


def test_what_is_written_is_read_back(walk: Data, tmp_path: Path) -> None:
    walk["execution"] = {
        "backend": "mujoco",
        "events": [{"at": 1, "push": {"robot": 0, "impulse": [3, -4]}}],
    }
    scenario = parse_scenario(walk)
    dump_scenario(scenario, tmp_path / "s.yaml")
    written = yaml.safe_load((tmp_path / "s.yaml").read_text(encoding="utf-8"))
    assert written["task"] == {
        "commands": [
            {"at": 0.5, "velocity": [0.4, 0.0, 0.0]},
            {"at": 4.0, "robot": 1, "to": [6.0, 4.0]},
        ],
        "duration": None,
    }
    assert written["planner"]["method"] == "commands"
    assert load_scenario(tmp_path / "s.yaml") == scenario


@pytest.mark.parametrize(
    ("change", "key", "said"),
    [
        ({"task": {"commands": []}}, "task.commands", "at least 1"),
        ({"task": {"commands": [{"at": 1}]}}, "task.commands[0]", "velocity, to, leap"),
        (
            {"task": {"commands": [{"at": 1, "to": [1, 1], "velocity": [0, 0, 0]}]}},
            "task.commands[0]",
            "exactly one of",
        ),
        (
            {"task": {"commands": [{"at": 1, "velocity": [0.1, 0]}]}},
            "task.commands[0].velocity",
            "yaw rate",
        ),
        (
            {"task": {"commands": [{"at": 1, "velocity": [0, 0, 0], "speed": 1}]}},
            "task.commands[0].speed",
            "is for `to` alone",
        ),
        (
            {"task": {"commands": [{"at": 1, "to": [1, 1], "robot": 2}]}},
            "task.commands[0].robot",
            "no robot 2",
        ),
        ({"task": {**_WALK["task"], "goals": [[1, 1, 0]]}}, "task.goals", "take the place"),
        (
            {"task": {**_WALK["task"], "formation": {"shape": "line"}}},
            "task.formation",
            "take the place",
        ),
        ({"task": {"goals": "individual", "duration": 3}}, "task.duration", "is for commands"),
        ({"planner": {"method": "cbs"}}, "planner.method", "follows no commands"),
        ({"planner": {"variant": "published"}}, "planner.variant", "expected cavalcade"),
        ({"planner": {"lookahead": 3}}, "planner.lookahead", "is for planners"),
        ({"execution": {"timeout": 5}}, "execution.timeout", "lasts 6 s"),
        (
            {"execution": {"events": [{"at": 1, "lose": 0}]}},
            "execution.events[0].lose",
            "is for formations",
        ),
        (
            {"execution": {"events": [{"at": 1, "push": {"robot": 0, "impulse": [1, 1]}}]}},
            "execution.events[0].push",
            "ideal robots cannot be pushed",
        ),
        (
            {
                "execution": {
                    "backend": "mujoco",
                    "events": [{"at": 1, "push": {"robot": 2, "impulse": [1, 1]}}],
                }
            },
            "execution.events[0].push.robot",
            "no robot 2",
        ),
    ],
)
def test_what_is_refused(walk: Data, change: Data, key: str, said: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(walk | change)
    assert caught.value.key == key
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_goal_of_its_own_is_refused(walk: Data) -> None:
    walk["robots"][1]["goal"] = [4, 4, 0]
    with pytest.raises(ScenarioError, match="commands say where it goes"):
        parse_scenario(walk)


def test_robots_with_pushes_do_not_become_ideal(walk: Data) -> None:
    walk["execution"] = {
        "backend": "mujoco",
        "events": [{"at": 1, "push": {"robot": 0, "impulse": [3, -4]}}],
    }
    with pytest.raises(ScenarioError, match="expected backend mujoco"):
        parse_scenario(walk).with_backend("ideal")


def test_the_schema_takes_goals_or_commands() -> None:
    task = scenario_schema()["$defs"]["TaskSection"]
    assert task["anyOf"] == [{"required": ["goals"]}, {"required": ["commands"]}]
    assert "required" not in task
