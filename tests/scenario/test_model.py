"""The schema: what is accepted, what is filled in, what is refused and how that is said."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from cavalcade.errors import ScenarioError
from cavalcade.scenario import Scenario, parse_scenario

Data = dict[str, Any]


def test_defaults_are_those_of_the_contract(data: Data) -> None:
    scenario = parse_scenario(data)
    assert scenario.world.resolution == 0.05
    assert scenario.world.unknown == "occupied"
    assert scenario.planner.method == "formation"
    assert scenario.planner.variant == "cavalcade"
    assert scenario.planner.budget.seconds is None
    assert scenario.execution.backend == "ideal"
    assert (scenario.execution.rate, scenario.execution.timeout) == (20.0, 180.0)
    assert scenario.execution.delay.drop == 0.0
    assert scenario.seed == 0
    assert scenario.file is None
    assert scenario.robots[0].start == (1.5, 2.5, 0.0)


def test_the_contracts_own_example_is_read() -> None:
    scenario = parse_scenario(
        {
            "version": 1,
            "name": "square-through-clutter",
            "world": {
                "generate": {"kind": "clutter", "size": [14, 10], "obstacles": 25, "seed": 3}
            },
            "robots": [{"model": "go1", "start": [1.4, float(y), 0.0]} for y in range(2, 6)],
            "task": {
                "formation": {"shape": "square", "side": 1.0},
                "goals": [[12.6, 5.0, 0.0]],
            },
            "planner": {
                "method": "formation",
                "variant": "cavalcade",
                "lookahead": 5.0,
                "budget": {"iterations": None, "seconds": None},
            },
            "execution": {
                "backend": "ideal",
                "rate": 20,
                "timeout": 180,
                "noise": {"position": 0.0, "heading": 0.0},
                "delay": {"mean": 0.0, "jitter": 0.0, "drop": 0.0},
                "events": [
                    {"at": 12.0, "add": {"circle": {"center": [7, 5], "radius": 0.3}}},
                    {
                        "at": 14.0,
                        "move": {
                            "circle": {"center": [7, 5], "radius": 0.3},
                            "to": [8, 5],
                            "speed": 1.0,
                        },
                    },
                    {"at": 20.0, "goals": [[2.0, 2.0, 1.57]]},
                    {"at": 25.0, "formation": {"shape": "column", "spacing": 0.9}},
                    {"at": 30.0, "lose": 2},
                    {"at": 40.0, "rejoin": 2},
                ],
                "seed": 0,
            },
        }
    )
    kinds = [event.kind for event in scenario.execution.events]
    assert kinds == ["add", "move", "goals", "formation", "lose", "rejoin"]
    assert scenario.execution.events[3].value.spacing == 0.9


def test_events_come_in_order_of_time(events: Callable[..., Data]) -> None:
    scenario = parse_scenario(events({"at": 9, "lose": 0}, {"at": 3, "goals": [[1, 1, 0]]}))
    assert [event.at for event in scenario.execution.events] == [3.0, 9.0]


@pytest.mark.parametrize(
    ("given", "size"),
    [
        ({"shape": "line"}, {"spacing": 1.0}),
        ({"shape": "line", "side": 0.8}, {"spacing": 0.8}),
        ({"shape": "column", "spacing": 0.8}, {"spacing": 0.8}),
        ({"shape": "wedge", "spacing": 0.8}, {"spacing": 0.8}),
        ({"shape": "circle", "radius": 2}, {"radius": 2.0}),
        ({"shape": "custom", "slots": [[0.5, 0], [-0.5, 0]]}, {"slots": ((0.5, 0.0), (-0.5, 0.0))}),
    ],
)
def test_a_formation_ends_with_the_one_size_it_needs(data: Data, given: Data, size: Data) -> None:
    data["task"]["formation"] = given
    formation = parse_scenario(data).task.formation
    for key in ("side", "spacing", "radius", "slots"):
        assert getattr(formation, key) == size.get(key)


def test_a_triangle_has_the_papers_size_by_default(data: Data) -> None:
    data["robots"].append({"start": [1.0, 1.0, 0.0]})
    data["task"]["formation"] = {"shape": "triangle"}
    assert parse_scenario(data).task.formation.side == 1.15


@pytest.mark.parametrize("text", ["1e-1", "1E-1", "+1e-1"])
def test_yaml_numbers_without_a_dot_are_numbers(data: Data, text: str) -> None:
    data["world"]["resolution"] = text
    assert parse_scenario(data).world.resolution == 0.1


def test_a_scenario_cannot_be_changed_and_is_equal_by_content(data: Data) -> None:
    scenario = parse_scenario(data)
    with pytest.raises(ValueError, match="frozen"):
        scenario.name = "other"  # type: ignore[misc]
    assert scenario == parse_scenario(data, "anywhere.yaml")
    assert hash(scenario) == hash(parse_scenario(data))
    assert scenario != parse_scenario({**data, "name": "other"})
    assert scenario != "small"


def _changed(data: Data, key: str, value: object) -> Data:
    """The data with one dotted key set, or removed where the value is `...`."""
    here: Any = data
    *path, last = [int(step) if step.isdecimal() else step for step in key.split(".")]
    for step in path:
        here = here.setdefault(step, {}) if isinstance(here, dict) else here[step]
    if value is ...:
        del here[last]
    else:
        here[last] = value
    return data


_CIRCLE = {"circle": {"center": [1, 1], "radius": 0.1}}
_TWO = {**_CIRCLE, "box": {"center": [1, 1], "size": [1, 1]}}


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("version", 2, "version: expected 1, got 2"),
        ("version", ..., "version: missing"),
        ("name", "", "name: expected some text"),
        ("name", 12, "name: expected text, got 12"),
        ("name", "a\nb", "name: expected one line of text"),
        ("wrold", {}, "wrold: unknown key; did you mean world?"),
        ("world", ..., "world: missing; expected a mapping with map, terrain"),
        ("world", 3, "world: expected a mapping with map, terrain"),
        ("world.map", "lab.yaml", "world: expected exactly one source (one of: map,"),
        ("world.terrain", "hills.yaml", "world: expected exactly one source (one of: map, terrain"),
        ("world.empty.size", [8], "world.empty.size: expected [width, height]: 2 numbers"),
        ("world.empty.size", [8, -5], "world.empty.size[1]: expected greater than 0"),
        ("world.empty.size", [8, math.nan], "world.empty.size[1]: expected a finite number"),
        ("world.resolution", "fine", "world.resolution: expected a number, got 'fine'"),
        ("world.resolution", 1e-9, "world.resolution: expected greater than or equal to 0.001"),
        ("world.resolution", True, "world.resolution: expected a number, got True"),
        ("world.unknown", "maybe", "world.unknown: unknown value 'maybe' (one of: occupied, free)"),
        ("world.obstacles.0", _TWO, "world.obstacles[0]: expected exactly one shape"),
        ("world.obstacles.0", {}, "world.obstacles[0]: expected exactly one shape"),
        ("world.obstacles.0", {"cone": {}}, "world.obstacles[0].cone: unknown key"),
        ("world.obstacles.1.circle.radius", 0, "obstacles[1].circle.radius: expected greater than"),
        ("world.obstacles.2.polygon.points", [[0, 0]], "points: expected at least 3, got 1"),
        ("robots", [], "robots: expected at least 1, got 0"),
        ("robots.0.model", "go9", "robots[0].model: unknown robot model 'go9' (one of: go1"),
        ("robots.0.start", [1, 2], "robots[0].start: expected [x, y, yaw]: 3 numbers"),
        ("robots.0.start", [1, "2", 0], "robots[0].start[1]: expected a number, got '2'"),
        ("robots.0.start", [1, 2, math.inf], "robots[0].start[2]: expected a finite number"),
        ("robots.0.start", [1, 10**400, 0], "robots[0].start[1]: expected a finite number"),
        ("robots.0.start", [1, 2e6, 0], "robots[0].start[1]: expected less than or equal to"),
        ("robots.0.stat", [1, 2, 0], "robots[0].stat: unknown key; did you mean start?"),
        ("robots.0.goal", [1, 2, 0], "robots[0].goal: the formation has the goals; expected none"),
        ("robots.0.model", "unicycle", "robots[0].model: a unicycle has no place in a formation"),
        ("task.goals", "individual", "task.formation: individual goals take no formation"),
        ("task.goals", "single", "task.goals: expected poses [x, y, yaw] of the formation, or ind"),
        ("task.formation", None, "task.formation: missing; expected a mapping with shape, side"),
        ("task.goals", [], "task.goals: expected at least 1, got 0"),
        ("task.goals", [[1, 2]], "task.goals[0]: expected [x, y, yaw]: 3 numbers"),
        ("task.formation.shape", "blob", "task.formation.shape: unknown value 'blob' (one of: sq"),
        ("task.formation.shape", "colum", "did you mean column?"),
        (
            "task.formation",
            {"shape": "square", "side": 1},
            "task.formation: the square has 4 slots,",
        ),
        (
            "task.formation",
            {"shape": "line", "radius": 1},
            "formation.radius: a line takes no radius",
        ),
        ("task.formation", {"shape": "custom"}, "task.formation.slots: expected a list of points"),
        (
            "task.formation",
            {"shape": "custom", "slots": [[0, 0], [0.1, 0]]},
            "task.formation: slots closer than a robot's width (0.28 m)",
        ),
        ("task.formation.spacing", 0.1, "task.formation: slots closer than a robot's width"),
        (
            "task.formation.connections",
            [{"a": 0, "b": 2}],
            "task.formation.connections[0]: expected slots 0 to 1",
        ),
        (
            "task.formation.connections",
            [{"a": 0, "b": 1}, {"a": 1, "b": 0}],
            "task.formation.connections[1]: expected two different slots, each pair once",
        ),
        (
            "planner.method",
            "cbs",
            "planner.method: method cbs is for individual goals; exp",
        ),
        ("planner.method", "rrt", "planner.method: unknown value 'rrt' (one of: formation, sequen"),
        ("planner.leaps", True, "planner.leaps: is for individual goals; the task is a formation"),
        ("planner.improve", 1.5, "planner.improve: expected a whole number, got 1.5"),
        ("planner.budget.iterations", 0, "planner.budget.iterations: expected greater than 0"),
        ("planner.budget.seconds", 0, "planner.budget.seconds: expected greater than 0"),
        ("planner.variant", "publish", "variant: unknown value 'publish'; did you mean published?"),
        ("planner.w_min_partial", 1.5, "planner.w_min_partial: expected less than or equal to 1"),
        ("planner.lookahead", 0, "planner.lookahead: expected greater than 0"),
        ("planner.budget.iterations", 1.5, "planner.budget.iterations: expected a whole number"),
        (
            "execution.backend",
            "gazebo",
            "execution.backend: unknown value 'gazebo' (one of: ideal, mujoco, ros2, unitree)",
        ),
        (
            "execution.backend",
            "mujoco-mjx",
            "execution.backend: unknown value 'mujoco-mjx'; did you mean mujoco? (one of: ideal,",
        ),
        ("execution.physics", [], "execution.physics: expected a mapping"),
        (
            "execution.physics.mass",
            1.0,
            "execution.physics.mass: unknown key (one of: friction, variation, motor_limits, stat",
        ),
        ("execution.physics.friction", 0, "execution.physics.friction: expected greater than 0"),
        ("execution.physics.variation", 1, "execution.physics.variation: expected less than 1"),
        (
            "execution.physics.motor_limits",
            "none",
            "execution.physics.motor_limits: unknown value 'none' (one of: torque, torque-speed)",
        ),
        (
            "execution.physics.state_noise.positon",
            0.1,
            "state_noise.positon: unknown key; did you mean position? (one of: position, velocity",
        ),
        ("execution.physics.state_delay", -1, "state_delay: expected greater than or equal to 0"),
        ("execution.rate", 0, "execution.rate: expected greater than or equal to 1"),
        ("execution.delay.drop", 1.1, "execution.delay.drop: expected less than or equal to 1"),
        ("execution.seed", -1, "execution.seed: expected greater than or equal to 0"),
        ("execution.seed", 1.0, "execution.seed: expected a whole number, got 1.0"),
        ("execution.seed", True, "execution.seed: expected a whole number, got True"),
        ("execution.seed", 2**80, "execution.seed: expected less than"),
        ("execution.events", [{"at": 1}], "execution.events[0]: expected `at` and exactly one"),
        ("execution.events", [{"lose": 1}], "execution.events[0].at: missing"),
        ("execution.events", [{"at": -1, "lose": 1}], "execution.events[0].at: expected greater"),
        ("execution.events", [{"at": 1, "lose": 2}], "events[0].lose: there is no robot 2"),
        ("execution.events", [{"at": 1, "rejoin": 1}], "events[0].rejoin: robot 1 is not lost"),
        (
            "execution.events",
            [{"at": 1, "lose": 1}, {"at": 2, "lose": 1}],
            "execution.events[1].lose: robot 1 is lost already at 2 s",
        ),
        (
            "execution.events",
            [{"at": 1, "lose": 1}, {"at": 2, "lose": 0}],
            "execution.events[1].lose: no robot would be left",
        ),
        (
            "execution.events",
            [{"at": 1, "formation": {"shape": "triangle", "side": 1}}],
            "execution.events[0].formation: the triangle has 3 slots, the team 2 robots",
        ),
        (
            "execution.events",
            [{"at": 1, "move": {**_CIRCLE, "to": [2, 2]}}],
            "execution.events[0].move.speed: missing",
        ),
    ],
)
def test_one_line_says_file_key_and_what_was_expected(
    data: Data, key: str, value: object, message: str
) -> None:
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(_changed(data, key, value), "a.yaml")
    text = str(caught.value)
    assert message in text
    assert text.startswith("a.yaml: ")
    assert "\n" not in text


def test_options_of_generated_worlds_are_those_of_their_kind(data: Data) -> None:
    data["world"] = {"generate": {"kind": "maze", "size": [8, 5], "obstacles": 3}}
    with pytest.raises(ScenarioError, match=r"generate.obstacles: a maze has no such option"):
        parse_scenario(data)


def test_generator_options_match_the_generators() -> None:
    from cavalcade.scenario.ground import KIND_OPTIONS, GenerateSource

    for names in KIND_OPTIONS.values():
        assert set(names) <= set(GenerateSource.model_fields)


def test_a_lost_robot_makes_room_for_a_smaller_shape(data: Data) -> None:
    data["robots"].append({"start": [1.0, 1.0, 0.0]})
    data["robots"].append({"start": [1.0, 4.0, 0.0]})
    triangle = {"shape": "triangle", "side": 1}
    data["execution"] = {"events": [{"at": 1, "lose": 3}, {"at": 2, "formation": triangle}]}
    assert parse_scenario(data).execution.events[1].formation is not None


def test_paths_are_relative_to_the_file(data: Data, tmp_path: Any) -> None:
    data["world"] = {"map": "maps/lab.yaml"}
    assert parse_scenario(data, tmp_path / "s.yaml").world.map == tmp_path / "maps/lab.yaml"
    data["world"] = {"movingai": {"file": "/x/y.map"}}
    scenario = parse_scenario(data, tmp_path / "s.yaml")
    assert scenario.world.movingai is not None
    assert str(scenario.world.movingai.file) == "/x/y.map"


@pytest.mark.parametrize("name", ["", " ", "a\x00b", 3])
def test_bad_file_names_are_refused(data: Data, name: object) -> None:
    data["world"] = {"map": name}
    with pytest.raises(ScenarioError, match=r"world.map: expected a file name"):
        parse_scenario(data)


def test_models_and_starts(data: Data) -> None:
    scenario = parse_scenario(data)
    assert isinstance(scenario, Scenario)
    assert [model.name for model in scenario.models] == ["go1", "go1"]
    assert scenario.starts[1] == (0.7, 2.5, 0.0)
