"""What a scenario says in all form, but probably does not mean, is warned about."""

from __future__ import annotations

import copy
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from cavalcade.formation.settings import VARIANTS
from cavalcade.scenario import ScenarioWarning, load_scenario, parse_scenario, scenario_names
from cavalcade.scenario.advice import IDLE
from cavalcade.world import MapWarning, OccupancyMap, load_map, load_terrain, save_map

Data = dict[str, Any]

_TEAM: Data = {
    "version": 1,
    "name": "t",
    "world": {"empty": {"size": [10, 8]}},
    "robots": [{"start": [1.0, 2.0, 0.0]}, {"start": [1.0, 4.0, 0.0]}],
    "task": {"formation": {"shape": "line", "spacing": 1.0}, "goals": [[6.0, 3.0, 0.0]]},
}
_SINGLES: Data = {
    **_TEAM,
    "robots": [
        {"start": [1.0, 2.0, 0.0], "goal": [6.0, 2.0, 0.0]},
        {"start": [1.0, 4.0, 0.0], "goal": [6.0, 4.0, 0.0]},
    ],
    "task": {"goals": "individual"},
}


def _warned(data: Data, changes: Data) -> list[str]:
    """What is said of the scenario with values at dotted keys."""
    data = copy.deepcopy(data)
    for key, value in changes.items():
        here: Any = data
        *path, last = key.split(".")
        for part in path:
            here = here[int(part)] if isinstance(here, list) else here.setdefault(part, {})
        here[int(last) if isinstance(here, list) else last] = value
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        parse_scenario(data)
    assert all(one.category is ScenarioWarning for one in caught)
    return [str(one.message) for one in caught]


@pytest.mark.parametrize("yaw", [90, -90.0, 180, 360, 45, 7, -6.4])
def test_a_yaw_of_90_was_taken_for_radians(yaw: float) -> None:
    box = {"center": [5, 5], "size": [1, 1], "yaw": yaw}
    cases: list[tuple[Data, str, Any]] = [
        (_TEAM, "robots.1.start", [1.0, 4.0, yaw]),
        (_TEAM, "task.goals", [[6.0, 3.0, 0.0], [6.0, 4.0, yaw]]),
        (_TEAM, "world.obstacles", [{"box": box}]),
        (_TEAM, "execution.events", [{"at": 1.0, "goals": [[6.0, 4.0, yaw]]}]),
        (_TEAM, "execution.events", [{"at": 1.0, "add": {"box": box}}]),
        (_TEAM, "execution.events", [{"at": 1.0, "move": {"box": box, "to": [5, 6], "speed": 1}}]),
        (_SINGLES, "robots.0.goal", [6.0, 2.0, yaw]),
    ]
    places = ["robots[1].start", "task.goals[1]", "world.obstacles[0].box.yaw"]
    places += ["execution.events[0].goals", "execution.events[0].add.box.yaw"]
    places += ["execution.events[0].move.box.yaw", "robots[0].goal"]
    for (data, key, value), place in zip(cases, places, strict=True):
        text = f"{place}: a yaw of {yaw:g} rad is more than a turn; expected radians, not degrees"
        assert _warned(data, {key: value}) == [text]


@pytest.mark.parametrize("yaw", [math.pi, -math.pi, 6.2832, -6.3, 2 * math.pi, 4.5, 0.0])
def test_a_turn_is_no_mistake(yaw: float) -> None:
    assert _warned(_TEAM, {"robots.1.start": [1.0, 4.0, yaw]}) == []


@pytest.mark.parametrize(("heading", "count"), [(0.02, 0), (1.0, 0), (1.01, 1), (5, 1)])
def test_a_heading_noise_of_degrees(heading: float, count: int) -> None:
    found = _warned(_TEAM, {"execution.noise": {"heading": heading}})
    assert ["execution.noise.heading" in one for one in found] == [True] * count


@pytest.mark.parametrize(("rate", "text"), [
    *((rate, None) for rate in (5, 10, 20, 50, 100)),
    (1000, "execution.rate: 1000 Hz leaves 1 ms for a cycle; planners are made for 5 to 100"),
    (101, "execution.rate: 101 Hz leaves 9.9 ms for a cycle; planners are made for 5 to 100"),
    (4.9, "execution.rate: 4.9 Hz leaves 204 ms for a cycle; planners are made for 5 to 100"),
])  # fmt: skip
def test_a_rate_of_1000_was_taken_in_silence(rate: float, text: str | None) -> None:
    assert _warned(_TEAM, {"execution.rate": rate}) == ([] if text is None else [text])


def _takes_no_part(key: str) -> set[str]:
    """Variants that by their own parts make nothing of a key."""
    parts = {
        "d_switch": lambda one: one.adaptive_roles and one.common_plan and not one.rigid,
        "w_min_avoid": lambda one: one.avoidance,
        "w_min_partial": lambda one: one.common_plan and not one.rigid,
        "expect": lambda one: one.filter,
    }
    return {name for name, variant in VARIANTS.items() if not parts[key](variant)}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("d_switch", 0.1),
        ("w_min_avoid", 0.3),
        ("w_min_partial", 0.5),
        ("expect", {"tracking_error": 0.02}),
    ],
)
def test_keys_without_effect_were_taken_in_silence(key: str, value: Any) -> None:
    assert set(IDLE[key]) == _takes_no_part(key)
    for variant in VARIANTS:
        found = _warned(_TEAM, {"planner": {"variant": variant, key: value}})
        text = f"planner.{key}: has no effect: the variant {variant} does not use it"
        assert found == ([text] if variant in IDLE[key] else [])


@pytest.mark.parametrize(("key", "own"), [("v_max_x", 0.5), ("v_max_y", 0.2)])
def test_speeds_that_no_robot_has(key: str, own: float) -> None:
    assert _warned(_TEAM, {f"planner.{key}": own}) == []
    assert _warned(_TEAM, {f"planner.{key}": own + 0.01}) == [
        f"planner.{key}: has no effect above {own:g}, the robots' own limit, m/s"
    ]


@pytest.mark.parametrize(("planner", "keys"), [
    ({"method": "joint"}, []),
    ({"method": "joint", "improve": 5}, ["improve"]),
    ({"method": "joint", "constraints": "static"}, ["constraints"]),
    ({"method": "joint", "conflict": "first", "improve": 1}, ["conflict", "improve"]),
    ({"method": "joint", "variant": "published"}, []),
    ({"method": "cbs", "variant": "published", "improve": 5}, ["improve"]),
    ({"method": "cbs", "constraints": "static", "conflict": "first", "improve": 5}, []),
    ({"method": "auto", "margin": 0.01, "improve": 5}, []),
])  # fmt: skip
def test_keys_that_a_method_does_not_use(planner: Data, keys: list[str]) -> None:
    found = _warned(_SINGLES, {"planner": planner})
    assert [one.partition(": has no effect")[0] for one in found] == [f"planner.{k}" for k in keys]


@pytest.mark.parametrize("name", scenario_names())
def test_the_shipped_scenarios_mean_what_they_say(name: str) -> None:
    load_scenario(name)  # a warning is an error here


def test_the_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(yaml.safe_dump({**_TEAM, "execution": {"rate": 1000}}), encoding="utf-8")
    with pytest.warns(ScenarioWarning, match=r"s\.yaml: execution\.rate: 1000 Hz"):
        load_scenario(path)


def test_origins_in_degrees(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    save_map(OccupancyMap.empty((2, 1)), path)
    path.write_text(path.read_text().replace("[0.0, 0.0, 0.0]", "[0.0, 0.0, 90]"))
    with pytest.warns(MapWarning, match=r"m\.yaml: origin: a yaw of 90 rad"):
        load_map(path)
    np.savez(tmp_path / "h.npz", height=np.zeros((9, 9)))
    path.write_text("{file: h.npz, resolution: 0.05, origin: [0, 0, 90]}")
    with pytest.warns(MapWarning, match=r"m\.yaml: origin: a yaw of 90 rad"):
        load_terrain(path)
