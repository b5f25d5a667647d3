"""What physics can carry out, and how it is said of what it cannot."""

from __future__ import annotations

from typing import Any

import pytest

from cavalcade.errors import ScenarioError
from cavalcade.robots import MODELS
from cavalcade.scenario import load_scenario, parse_scenario, scenario_schema

Data = dict[str, Any]


@pytest.mark.parametrize("name", sorted(MODELS))
def test_robots_need_a_description_for_physics_and_for_nothing_else(name: str) -> None:
    model = MODELS[name]
    single: Data = {
        "version": 1,
        "name": "one",
        "world": {"empty": {"size": [8, 5]}},
        "robots": [{"model": name, "start": [2, 2, 0], "goal": [5, 2, 0]}],
        "task": {"goals": "individual"},
    }
    assert parse_scenario(single).execution.backend == "ideal"
    single["execution"] = {"backend": "mujoco"}
    if model.description is not None:
        assert parse_scenario(single).execution.backend == "mujoco"
        return
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(single, "a.yaml")
    line = str(caught.value)
    assert line.startswith(f"a.yaml: robots[0].model: physics has no masses and joints of a {name}")
    assert line.endswith("(one of: go1, go2)")
    assert "\n" not in line


@pytest.mark.filterwarnings("ignore::cavalcade.scenario.ScenarioWarning")
@pytest.mark.parametrize("rate", [2.5, 500])
def test_planners_are_asked_before_robots_stop_and_once_per_step_of_physics_at_most(
    data: Data, rate: float
) -> None:
    data["execution"] = {"backend": "mujoco", "rate": rate}
    parse_scenario(data)
    data["execution"]["rate"] = 2.0 * rate if rate > 100 else 0.5 * rate
    with pytest.raises(ScenarioError, match=r"execution\.rate: expected 2\.5 to 500 in physics"):
        parse_scenario(data)
    data["execution"]["backend"] = "ideal"
    parse_scenario(data)


def test_the_schema_tells_of_physics() -> None:
    found = scenario_schema()["$defs"]
    assert found["ExecutionSection"]["properties"]["backend"]["enum"] == [
        "ideal",
        "mujoco",
        "ros2",
        "unitree",
    ]
    physics = found["PhysicsSection"]
    assert physics["additionalProperties"] is False
    assert "required" not in physics
    assert set(physics["properties"]) == {
        "friction",
        "variation",
        "motor_limits",
        "state_noise",
        "state_delay",
    }
    assert found["StateNoise"]["additionalProperties"] is False


@pytest.mark.parametrize(("rate", "accepted"), [(2.4, False), (5.0, True), (20.0, True)])
def test_robots_on_a_graph_are_commanded_before_they_stop(rate: float, accepted: bool) -> None:
    said = ["execution.backend=ros2", f"execution.rate={rate}"]
    if accepted:
        assert load_scenario("square-clutter", overrides=said).execution.rate == rate
    else:
        with pytest.raises(ScenarioError, match=r"rate: expected 2.5 to 500 with backend ros2"):
            load_scenario("square-clutter", overrides=said)
