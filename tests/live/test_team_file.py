"""Team files: what is taken, and what is said of what is not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cavalcade.cli import main
from cavalcade.errors import InputError
from cavalcade.live.team_file import load_team, parse_team, team_schema
from cavalcade.world import OccupancyMap, save_map

GOOD = {
    "version": 1,
    "robots": [{"name": "anna"}, {"name": "bert", "model": "go2"}],
    "formation": {"shape": "line"},
    "map": "lab.yaml",
}
UNITREE = [{"name": "anna", "interface": "eth0"}, {"name": "bert", "domain": 1}]


def test_file_names_are_relative_to_the_file_and_topics_to_the_robot(tmp_path):
    save_map(OccupancyMap.empty((4.0, 3.0), 0.05), tmp_path / "lab.yaml")
    (tmp_path / "team.yaml").write_text(json.dumps(GOOD))
    team = load_team(tmp_path / "team.yaml")
    assert team.first_map().size == (4.0, 3.0)
    anna, bert = team.ros2_robots()
    assert anna.topic(anna.velocity_topic) == "/anna/cmd_vel"
    assert bert.pose_source == "/bert/pose"
    assert [model.name for model in team.models] == ["go1", "go2"]
    assert team.expected.tracking_error > 0.0


def test_scenario_is_a_team_too():
    team = load_team("square-clutter")
    assert team.names == ("robot_0", "robot_1", "robot_2", "robot_3")
    assert team.formation.shape == "square"
    assert team.first_map().size == (14.0, 10.0)
    assert load_team("hexagon-swap").formation is None
    with pytest.raises(InputError, match="level ground"):
        load_team("gap")


def test_limits_and_supervision_become_the_supervisors():
    said = {"limits": {"max_speed": 0.3}, "supervision": {"max_age": 0.3, "unresponsive": "stop"}}
    allowed = parse_team(GOOD | said).what_is_allowed(dry_run=True)
    assert (allowed.max_speed, allowed.max_age, allowed.unresponsive) == (0.3, 0.3, "stop")
    assert allowed.dry_run
    assert not parse_team(GOOD).what_is_allowed().dry_run


@pytest.mark.parametrize(
    ("said", "text"),
    [
        ({"robot": 1}, "robot: unknown key; did you mean robots?"),
        ({"robots": []}, "robots: expected at least 1"),
        ({"robots": [{"name": "a"}, {"name": "a"}]}, "robots[1].name: a is there twice"),
        ({"robots": [{"name": "a b"}]}, "robots[0].name: expected a name"),
        ({"robots": [{"name": "1a"}]}, "robots[0].name: expected a name"),
        ({"robots": [{"name": "a", "pose": {"type": "Pose"}}]}, "robots[0].pose.type: unknown"),
        ({"robots": [{"name": "a", "pose": {"topic": "a b"}}]}, "robots[0].pose.topic: expected"),
        ({"robots": [{"name": "a", "model": "gol"}]}, "robots[0].model: unknown robot model"),
        ({"robots": [{"name": "a", "domain": 3}, {"name": "b"}]}, "robots[0].domain: is for"),
        (
            {"robots": [{"name": n, "pose": {"topic": "/pose"}} for n in ("a", "b")]},
            "robots[1]: /pose is robot 0's topic, too",
        ),
        ({"formation": {"shape": "square"}}, "formation: the square has 4 slots, the team 2"),
        ({"formation": {"shape": "sqare"}}, "formation.shape: unknown value 'sqare'; did you mean"),
        ({"limits": {"geofence": [[0, 0], [1, 1], [1, 0], [0, 1]]}}, "limits.geofence: edges"),
        ({"limits": {"max_speed": 0}}, "limits.max_speed: expected greater than 0"),
        ({"limits": {"max_speed": float("nan")}}, "limits.max_speed: expected a finite number"),
        ({"supervision": {"max_speed": 1}}, "supervision.max_speed: stands below limits"),
        ({"supervision": {"max_age": -1}}, "supervision.max_age: expected greater than 0"),
        ({"map": {"topic": None}}, "map: expected a file, a topic or both"),
        ({"map": 3}, "map: expected a mapping with file, topic, unknown"),
        ({"frame": "a b"}, "frame: expected a frame's name"),
        ({"rate": 1}, "rate: expected greater than or equal to 2.5"),
        ({"planner": {"method": "commands"}}, "planner.method: follows no goals"),
        ({"planner": {"lookahed": 3}}, "planner.lookahed: unknown key; did you mean lookahead"),
        ({"fleet": "unitree"}, "robots[0]: expected its network interface"),
        (
            {"fleet": "unitree", "robots": [UNITREE[0], UNITREE[0] | {"name": "b"}]},
            "robots[1]: is where robot 0 is",
        ),
        (
            # As it is delivered a Go2 is in domain 0, and so is one of which no domain is said.
            {"fleet": "unitree", "robots": [UNITREE[0], UNITREE[0] | {"name": "b", "domain": 0}]},
            "robots[1]: is where robot 0 is",
        ),
        (
            {"fleet": "unitree", "robots": [UNITREE[0] | {"velocity": {"topic": "v"}}, UNITREE[1]]},
            "robots[0].velocity: is for fleet: ros2",
        ),
    ],
)
def test_what_is_wrong_is_said_with_file_and_key(said, text):
    with pytest.raises(InputError) as caught:
        parse_team(GOOD | said, "lab/team.yaml")
    assert f"lab/team.yaml: {text}" in str(caught.value)


@pytest.mark.parametrize("data", [[], "team", None, 3])
def test_data_that_are_no_mapping_are_refused(data):
    with pytest.raises(InputError, match="expected a mapping"):
        parse_team(data)


@pytest.mark.parametrize(
    ("said", "topic"),
    [
        ({}, "/map"),
        ({"map": {}}, "/map"),
        ({"map": {"unknown": "free"}}, "/map"),
        ({"map": {"file": None}}, "/map"),
        ({"map": {"topic": "/lab/map"}}, "/lab/map"),
        ({"map": "lab.yaml"}, None),
        ({"map": {"file": "lab.yaml"}}, None),
        ({"map": {"file": "lab.yaml", "topic": None}}, None),
        ({"map": {"file": "lab.yaml", "topic": "/map"}}, "/map"),
    ],
)
def test_a_map_that_was_heard_replaced_a_named_file(said, topic):
    """Only where the file names a topic, too, maps are heard beside it."""
    rest = {key: value for key, value in GOOD.items() if key != "map"}
    assert parse_team(rest | said).map.topic == topic


def test_unitree_robots_need_a_place_of_their_own():
    team = parse_team(GOOD | {"fleet": "unitree", "robots": UNITREE})
    assert team.robots[1].domain == 1
    assert parse_team(GOOD).go2s is None
    robots = [UNITREE[0], UNITREE[0] | {"name": "bert", "domain": 1, "battery_min": 0}]
    said = parse_team(GOOD | {"fleet": "unitree", "robots": robots, "lie_down": True}).go2s
    assert said is not None
    assert [(one.domain, one.interface) for one in said.robots] == [(0, "eth0"), (1, "eth0")]
    assert [one.battery_min for one in said.robots] == [20.0, 0.0]
    assert said.lie_down


def test_schema_is_printed_and_says_units(capsys):
    assert main(["schema", "--team"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads(json.dumps(team_schema()))
    parts = printed["$defs"]
    assert parts["LimitsSection"]["properties"]["max_speed"]["unit"] == "m/s"
    assert {"type": "string"} in printed["properties"]["map"]["anyOf"]


def test_files_for_rviz_and_foxglove_are_found(capsys):
    assert main(["ros2", "config"]) == 0
    names = capsys.readouterr().out.split()
    assert [name.rpartition("/")[2] for name in names] == ["team.foxglove.json", "team.rviz"]
    json.loads(Path(names[0]).read_text())
