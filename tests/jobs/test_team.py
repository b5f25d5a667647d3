from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cavalcade.execution.formation_policy import formation_of, make_planner, settings_of
from cavalcade.formation.settings import LABORATORY, LABORATORY_SPRINGS, SIMULATION_SPRINGS
from cavalcade.jobs.reporter import JobReporter
from cavalcade.jobs.tasks import TASKS
from cavalcade.scenario import (
    FormationSection,
    PlannerSection,
    Scenario,
    build_world,
    resolve_scenario,
)


def planner_section(**values: Any) -> PlannerSection:
    return PlannerSection.model_validate(values)


def formation_from(preset: str | None = None, robots: int = 4, **values: Any) -> Any:
    section = FormationSection.model_validate(values)
    return formation_of(section, robots, planner_section(preset=preset))


@pytest.mark.parametrize(
    ("values", "robots"),
    [
        ({"shape": "square", "side": 1.2}, 4),
        ({"shape": "triangle", "side": 1.2}, 3),
        ({"shape": "line", "spacing": 1.2}, 5),
        ({"shape": "column", "spacing": 1.2}, 1),
        ({"shape": "wedge", "spacing": 1.2}, 6),
        ({"shape": "custom", "slots": [[0.0, 0.0], [1.2, 0.0]]}, 2),
    ],
)
def test_every_shape_with_its_size(values: dict[str, Any], robots: int) -> None:
    formation = formation_from(robots=robots, **values)
    assert formation.name == values["shape"]
    assert formation.size == robots
    if robots > 1:
        assert formation.spacing == pytest.approx(1.2)


def test_a_circle_has_its_radius() -> None:
    formation = formation_from(robots=7, shape="circle", radius=2.0)
    assert np.hypot(*formation.slots.T) == pytest.approx(np.full(7, 2.0))


@pytest.mark.parametrize(
    ("preset", "springs"),
    [(None, SIMULATION_SPRINGS), ("laboratory", LABORATORY_SPRINGS)],
)
def test_the_preset_says_what_the_springs_are_like(preset: str | None, springs: Any) -> None:
    formation = formation_from(preset, shape="square", side=1.0)
    laws = {c.law for c in formation.connections if c.rest_length < 1.1}
    assert laws == {springs.sides}


def test_connections_of_the_scenario_replace_those_of_the_shape() -> None:
    joints = [{"a": 0, "b": 1, "l0": 0.9, "k_rep": 7.0}, {"a": 0, "b": 2}]
    formation = formation_from(shape="square", side=1.0, connections=joints)
    side, diagonal = formation.connections
    assert (side.rest_length, side.law.k_rep) == (0.9, 7.0)
    assert side.law.k_att == SIMULATION_SPRINGS.sides.k_att
    assert diagonal.rest_length == pytest.approx(np.sqrt(2.0))
    assert diagonal.law == SIMULATION_SPRINGS.diagonals
    assert formation_from(shape="square", side=1.0, connections=[]).connections == ()


def test_settings_are_the_preset_s_unless_said_otherwise() -> None:
    section = planner_section(preset="laboratory", r_max=0.25, v_min=0.1)
    assert settings_of(section) == LABORATORY.with_values(r_max=0.25, v_min=0.1)
    assert settings_of(planner_section()).r_max == pytest.approx(0.30)


def test_the_fleet_fits_the_scenario(make_scenario: Callable[..., Scenario]) -> None:
    scenario = make_scenario(noise={"position": 0.1}, seed=4)
    resolved = resolve_scenario(scenario)
    fleet = TASKS["formation"](
        resolved, build_world(resolved), JobReporter("a", quiet=True)
    ).make_fleet()
    assert fleet.size == 4
    assert np.allclose(fleet.true_poses(), scenario.starts)
    assert not np.allclose(fleet.observe().poses, scenario.starts)


def test_the_planner_drives_to_the_scenario_s_goal(make_scenario: Callable[..., Scenario]) -> None:
    scenario = make_scenario(planner={"preset": "simulation", "lookahead": 4.0})
    planner = make_planner(scenario, build_world(scenario))
    commands = planner.step(np.array(scenario.starts), 0.0)
    assert commands.shape == (4, 3)
    assert np.isfinite(commands).all()
    assert planner.status.goal == pytest.approx(scenario.task.goals[0])
