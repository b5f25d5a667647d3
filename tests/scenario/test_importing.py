"""Problem files of db-CBS as scenarios."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cavalcade.errors import InputError, ScenarioError
from cavalcade.geometry import rectangle_corners
from cavalcade.scenario import Scenario, build_world, dump_scenario, import_problem, load_scenario

Data = dict[str, Any]

_PROBLEM: Data = {
    "environment": {
        "min": [-2, 0],
        "max": [3, 5.01],
        "obstacles": [{"type": "box", "center": [0.5, 2.5], "size": [0.5, 1.0]}],
    },
    "robots": [
        {"type": "unicycle_first_order_0", "start": [-1, 2.5, 0], "goal": [2, 2.5, 1.5]},
        {"type": "unicycle_first_order_0_sphere", "start": [2, 1, 0], "goal": [-1.8, 1, 3]},
        {"type": "unicycle_second_order_0", "start": [2, 4, 0, 0, 0], "goal": [-1, 4, 0, 0, 0]},
        {"type": "double_integrator_0", "start": [0, 4, 0, 0], "goal": [2.9, 4, 0, 0]},
        {"type": "single_integrator_0", "start": [0, 0.5], "goal": [2.5, 0.5]},
    ],
}
_FEW = settings(
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@pytest.fixture
def write(tmp_path: Path) -> Callable[[Any], Path]:
    def written(problem: Any) -> Path:
        path = tmp_path / "p.yaml"
        path.write_text(yaml.safe_dump(problem), encoding="utf-8", errors="replace")
        return path

    return written


@pytest.fixture
def problem() -> Data:
    return copy.deepcopy(_PROBLEM)


def test_places_states_and_types(write: Callable[[Any], Path], problem: Data) -> None:
    scenario = import_problem(write(problem))
    assert scenario.name == "p"
    assert [model.name for model in scenario.models] == [
        "unicycle",
        "unicycle-sphere",
        "unicycle-2",
        "double-integrator",
        "single-integrator",
    ]
    assert scenario.starts[0] == (-1.0, 2.5, 0.0)
    assert scenario.goals[0] == (2.0, 2.5, 1.5)
    assert scenario.goals[3] == (2.9, 4.0, 0.0)
    assert scenario.world.obstacles[0].to_dict() == {
        "box": {"center": [0.5, 2.5], "size": [0.5, 1.0], "yaw": 0.0}
    }
    assert (scenario.planner.method, scenario.world.resolution) == ("auto", 0.025)
    assert scenario.execution.timeout >= 180.0
    # Centres may be where they may be there: 0.4 m, the largest body, and a whole cell.
    world = build_world(scenario)
    low = np.array(world.map.origin[:2])
    high = low + world.map.size
    assert low == pytest.approx([-2.425, -0.425])
    assert high == pytest.approx([3.425, 5.425])
    assert "centres there within x -2 to 3, y 0 to 5.01 m" in scenario.description


@pytest.mark.parametrize("bound", [1.0, 1.01, 1.0125, 1.024999999, 1.025, 1.3])
@pytest.mark.parametrize(
    ("kind", "rest", "radius"),
    [
        ("double_integrator_0", (0, 0), 0.15),
        ("unicycle_first_order_0_sphere", (0.3,), 0.4),
        ("unicycle_first_order_0", (0.46,), 0.2796),  # turned so that a corner points outwards
    ],
)
def test_the_border_does_not_lie_on_bodies_whose_centres_are_on_the_published_bounds(
    write: Callable[[Any], Path], bound: float, kind: str, rest: tuple[float, ...], radius: float
) -> None:
    ends = {"start": [bound, 0.0, *rest], "goal": [-bound, 0.0, *rest]}
    problem = {
        "environment": {"min": [-bound, -bound], "max": [bound, bound], "obstacles": []},
        "robots": [{"type": kind, **ends}],
    }
    scenario = import_problem(write(problem))
    world = build_world(scenario)  # which refuses starts that touch the border
    low = np.array(world.map.origin[:2])
    for side in (-low, low + world.map.size):
        beside = side - bound - radius
        assert (beside >= 0.0009).all()
        assert (beside <= 0.0261).all()


def test_centres_beyond_the_published_bounds_are_refused(
    write: Callable[[Any], Path], problem: Data
) -> None:
    problem["robots"][4]["goal"] = [3.0, 0.5]
    import_problem(write(problem))
    problem["robots"][4]["goal"] = [3.001, 0.5]
    with pytest.raises(ScenarioError, match=r"robots\[4\].goal: expected a centre within"):
        import_problem(write(problem))


def test_names_of_db_lacam(write: Callable[[Any], Path], problem: Data) -> None:
    before = import_problem(write(problem))
    for robot, name in zip(
        problem["robots"],
        ("unicycle1_v0", "unicycle1_sphere_v0", "unicycle2_v0", "integrator2_2d_v0"),
        strict=False,
    ):
        robot["type"] = name
    assert import_problem(write(problem)) == before


def test_what_is_imported_can_be_written_and_read(
    write: Callable[[Any], Path], problem: Data, tmp_path: Path
) -> None:
    scenario = import_problem(write(problem))
    dump_scenario(scenario, tmp_path / "s.yaml")
    assert load_scenario(tmp_path / "s.yaml") == scenario


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        (
            "robots.0.type",
            "car_first_order_with_1_trailers_0",
            "has a trailer; robots with trailers",
        ),
        ("robots.0.type", "quad3d_v0", "robots[0].type: there is no model for 'quad3d_v0' (one of"),
        ("robots.0.type", 3, "robots[0]: expected a mapping with type, start and goal"),
        ("robots.0.start", [1, 2], "robots[0].start: expected [x, y, yaw]: 3 numbers"),
        ("robots.0.start", None, "robots[0].start: expected a list of numbers"),
        ("robots.0.start", [1, "2", 0], "robots[0].start: expected numbers within ±1e6, got '2'"),
        ("robots.0.start", [1, float("nan"), 0], "robots[0].start: expected numbers within ±1e6"),
        ("robots.3.start", [0, 4, 0.1, 0], "robots[3].start: expected a robot that stands still"),
        ("robots.2.goal", [0, 4, 0, 0, 0.1], "robots[2].goal: expected a robot that stands still"),
        ("robots", [], "robots: expected a list of robots"),
        ("robots", {}, "robots: expected a list of robots"),
        ("environment", [], "environment: expected a mapping with min, max and obstacles"),
        ("environment.min", [0, 0, 0], "environment.min: problems in three dimensions"),
        ("environment.min", [0], "environment.min: expected [x, y]: 2 numbers"),
        ("environment.obstacles", 3, "environment.obstacles: expected a list of boxes"),
        (
            "environment.obstacles.0.type",
            "octomap",
            "obstacles[0].type: expected box, got 'octomap'",
        ),
        ("environment.obstacles.0.size", [1], "obstacles[0]: expected center [x, y] and size"),
        ("environment.obstacles.0.size", [1, 0], "obstacles[0].box.size[1]: expected greater than"),
    ],
)
def test_what_cannot_be_imported_is_one_line(
    write: Callable[[Any], Path], problem: Data, key: str, value: Any, message: str
) -> None:
    here: Any = problem
    *path, last = key.split(".")
    for part in path:
        here = here[int(part)] if isinstance(here, list) else here[part]
    here[last] = value
    file = write(problem)
    with pytest.raises(ScenarioError) as caught:
        import_problem(file)
    said = str(caught.value)
    assert message in said
    assert said.startswith(f"{file}: ")
    assert "\n" not in said


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({}, "unknown format; known are db-CBS problems"),
        ([1, 2], "unknown format; known are db-CBS problems"),
        (None, "unknown format; known are db-CBS problems"),
        ({"version": 1, "world": {}, "robots": []}, "is a scenario already"),
    ],
)
def test_other_formats(write: Callable[[Any], Path], content: Any, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        import_problem(write(content))


_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=6),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["type", "start", "goal", "min", "center"]), inner, max_size=3
        )
    ),
    max_leaves=8,
)


@given(st.data())
@_FEW
def test_whatever_stands_there_it_is_a_scenario_or_one_line(
    write: Callable[[Any], Path], data: st.DataObject
) -> None:
    changed = copy.deepcopy(_PROBLEM)
    for _ in range(data.draw(st.integers(1, 3))):
        here: Any = changed
        while True:
            keys = sorted(here) if isinstance(here, dict) else list(range(len(here)))
            if not keys:
                break
            key = data.draw(st.sampled_from(keys))
            if isinstance(here[key], dict | list) and data.draw(st.integers(0, 3)):
                here = here[key]
                continue
            here[key] = data.draw(_VALUES)
            break
    try:
        said = import_problem(write(changed)).description
    except InputError as error:
        said = str(error)
    assert "\n" not in said


def _problems(folder: Path) -> list[Path]:
    return sorted(path for path in folder.glob("*.yaml"))


def _inside(scenario: Scenario) -> bool:
    world = build_world(scenario)
    for model, poses in zip(
        scenario.models, zip(scenario.starts, scenario.goals, strict=True), strict=True
    ):
        for pose in poses:
            turned = (pose[0], pose[1], 0.0) if model.round else pose
            corners = rectangle_corners(turned, model.length, model.width)
            if not world.map.contains(corners).all():
                return False
    return True


def test_all_problems_of_others_but_those_with_trailers(shared_data: Callable[[str], Path]) -> None:
    found, left_out = 0, 0
    for path in _problems(shared_data("db_cbs")):
        if "trailer" in path.read_text(encoding="utf-8"):
            with pytest.raises(ScenarioError, match="has a trailer"):
                import_problem(path)
            left_out += 1
            continue
        scenario = import_problem(path)
        assert _inside(scenario)
        assert 1 <= len(scenario.robots) <= 4
        found += 1
    assert (found, left_out) == (31, 11)
