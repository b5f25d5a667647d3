"""Scenario files out: what is written says everything and is read back the same."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from cavalcade.errors import OutputError
from cavalcade.scenario import (
    build_world,
    dump_scenario,
    load_scenario,
    parse_scenario,
    resolve_scenario,
)
from cavalcade.world import OccupancyMap, save_map

Data = dict[str, Any]


def test_what_is_written_is_read_back(
    tmp_path: Path, data: Data, events: Callable[..., Data]
) -> None:
    circle = {"circle": {"center": [2, 1], "radius": 0.1}}
    full = events(
        {"at": 1, "add": circle},
        {"at": 2, "move": {**circle, "to": [3, 1], "speed": 0.25}},
        {"at": 9, "remove": circle},
        {"at": 10, "goals": [[1, 1, 0], [2, 2, 1]]},
        {"at": 11, "formation": {"shape": "column", "connections": []}},
        {"at": 12, "lose": 1},
        {"at": 13, "rejoin": 1},
    )
    full["description"] = "12:30, 'quoted': yes – ä"
    full["task"]["formation"]["connections"] = [{"a": 0, "b": 1, "k_rep": 4.5}]
    full["planner"] = {"variant": "published", "preset": "laboratory", "r_max": 0.31}
    scenario = parse_scenario(full)
    dump_scenario(scenario, tmp_path / "s.yaml")
    assert load_scenario(tmp_path / "s.yaml") == scenario
    assert os.listdir(tmp_path) == ["s.yaml"]


def test_every_default_is_written_out(tmp_path: Path, data: Data) -> None:
    dump_scenario(parse_scenario(data), tmp_path / "s.yaml")
    written = yaml.safe_load((tmp_path / "s.yaml").read_text(encoding="utf-8"))
    assert written["execution"] == {
        "backend": "ideal",
        "rate": 20.0,
        "timeout": 180.0,
        "noise": {"position": 0.0, "heading": 0.0},
        "delay": {"mean": 0.0, "jitter": 0.0, "drop": 0.0},
        "physics": {
            "friction": 0.8,
            "variation": 0.0,
            "motor_limits": "torque",
            "state_noise": {
                "position": 0.0,
                "velocity": 0.0,
                "angle": 0.0,
                "rate": 0.0,
                "joint": 0.0,
                "joint_rate": 0.0,
            },
            "state_delay": 0.0,
        },
        "unitree": {"robots": [], "lie_down": False},
        "events": [],
        "seed": 0,
    }
    assert written["planner"]["variant"] == "cavalcade"
    assert written["world"]["resolution"] == 0.05
    assert written["task"]["formation"] == {"shape": "line", "spacing": 0.9, "connections": None}
    assert written["robots"][0] == {"model": "go1", "start": [1.5, 2.5, 0.0]}


def test_a_generated_world_is_written_as_its_obstacles(tmp_path: Path, data: Data) -> None:
    data["world"] = {
        "generate": {"kind": "clutter", "size": [14, 10], "obstacles": 9},
        "obstacles": [{"circle": {"center": [3, 1], "radius": 0.1}}],
    }
    data["execution"] = {"seed": 5}
    scenario = parse_scenario(data)
    dump_scenario(scenario, tmp_path / "s.yaml")
    read = load_scenario(tmp_path / "s.yaml")
    assert read == resolve_scenario(scenario)
    assert read.world.generate is None
    assert read.world.empty is not None
    assert read.world.empty.size == (14.0, 10.0)
    assert len(read.world.obstacles) == 10
    assert read.world.obstacles[0] == scenario.world.obstacles[0]
    assert build_world(read).shapes == build_world(scenario).shapes
    assert build_world(read).map == build_world(scenario).map


def test_file_names_are_relative_to_the_new_file(tmp_path: Path, data: Data) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / "runs" / "a").mkdir(parents=True)
    save_map(OccupancyMap(np.zeros((100, 160), dtype=bool), 0.05), tmp_path / "maps" / "m.yaml")
    data["world"] = {"map": "maps/m.yaml"}
    scenario = parse_scenario(data, tmp_path / "s.yaml")
    target = tmp_path / "runs" / "a" / "scenario.yaml"
    dump_scenario(scenario, target)
    assert "map: ../../maps/m.yaml" in target.read_text(encoding="utf-8")
    assert build_world(load_scenario(target)).map == build_world(scenario).map
    assert (tmp_path / "runs" / "a").samefile(target.parent)


def test_nothing_half_written_where_it_cannot_be_written(tmp_path: Path, data: Data) -> None:
    scenario = parse_scenario(data)
    with pytest.raises(OutputError, match="cannot be written"):
        dump_scenario(scenario, tmp_path / "missing" / "s.yaml")
    (tmp_path / "s.yaml").mkdir()
    with pytest.raises(OutputError, match="cannot be written"):
        dump_scenario(scenario, tmp_path / "s.yaml")
    assert os.listdir(tmp_path) == ["s.yaml"]
