"""Scenarios on terrain: the world has heights on the map's grid, and files say which."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from cavalcade.errors import MapError, ScenarioError
from cavalcade.scenario import (
    build_world,
    dump_scenario,
    load_scenario,
    parse_scenario,
    resolve_scenario,
)
from cavalcade.world import generate_terrain, load_terrain

Data = dict[str, Any]


def _data(world: Data, *robots: Data) -> Data:
    one = {"model": "spirit", "start": [2.0, 2.0, 0.0], "goal": [7.0, 2.0, 0.0]}
    return {
        "version": 1,
        "name": "hills",
        "world": world,
        "robots": list(robots or (one,)),
        "task": {"goals": "individual"},
    }


def _start(x: float, y: float, yaw: float = 0.0, model: str = "spirit") -> Data:
    return {"model": model, "start": [x, y, yaw], "goal": [7.0, 2.0, 0.0]}


@pytest.fixture
def heights(tmp_path: Path) -> Path:
    """A terrain file with a hole at (4.525, 2.025) m."""
    table = np.random.default_rng(0).uniform(0.0, 0.1, (80, 180))
    table[40, 90] = np.nan
    (tmp_path / "data").mkdir()
    np.savetxt(tmp_path / "data" / "h.csv", table, delimiter=",")
    text = yaml.safe_dump({"file": "h.csv", "resolution": 0.05, "origin": [1.0, 0.5, 0.2]})
    (tmp_path / "data" / "hills.yaml").write_text(text, encoding="utf-8")
    return tmp_path / "data" / "hills.yaml"


def test_map_and_terrain_share_one_grid(heights: Path, tmp_path: Path) -> None:
    box = {"box": {"center": [6.0, 4.0], "size": [1.0, 0.5]}}
    data = _data({"terrain": "data/hills.yaml", "obstacles": [box]}, _start(3.0, 2.5))
    world = build_world(parse_scenario(data, tmp_path / "s.yaml"))
    assert world.terrain == load_terrain(heights)
    assert world.map.origin == world.terrain.origin == (1.0, 0.5, 0.2)
    assert world.map.grid.shape == world.terrain.height.shape
    assert world.map.resolution == world.terrain.resolution
    assert not world.base.occupied.any()
    assert world.map.occupied.sum() == pytest.approx(0.5 / 0.05**2, rel=0.25)


def test_level_worlds_have_no_terrain() -> None:
    assert build_world(parse_scenario(_data({"empty": {"size": [9, 4]}}))).terrain is None


def test_terrain_comes_in_the_worlds_resolution(heights: Path) -> None:
    data = _data({"terrain": str(heights), "resolution": 0.1}, _start(3.0, 2.5))
    terrain = build_world(parse_scenario(data)).terrain
    assert terrain is not None
    assert terrain.height.shape == (40, 90)
    data["world"]["resolution"] = 0.01
    with pytest.raises(MapError, match=r"resolution: expected cells of 0\.02 to 0\.2 m"):
        build_world(parse_scenario(data))


def test_generated_terrain_is_that_of_the_generator(tmp_path: Path) -> None:
    data = _data({"generate": {"kind": "rough", "size": [9, 4], "height": 0.2}}, _start(0.6, 2.0))
    data["execution"] = {"seed": 5}
    scenario = parse_scenario(data)
    assert build_world(scenario).terrain == generate_terrain("rough", (9, 4), 5, height=0.2)
    dump_scenario(scenario, tmp_path / "s.yaml")
    written = yaml.safe_load((tmp_path / "s.yaml").read_text(encoding="utf-8"))
    assert written["world"]["generate"] == {
        "kind": "rough",
        "size": [9.0, 4.0],
        "seed": 5,
        "height": 0.2,
        "spacing": 0.4,
        "zone": 1.0,
    }
    read = load_scenario(tmp_path / "s.yaml", seed=7)
    assert build_world(read).terrain == build_world(scenario).terrain
    assert load_scenario(tmp_path / "s.yaml") == resolve_scenario(scenario)


def test_names_of_terrain_files_are_relative_to_the_new_file(heights: Path, tmp_path: Path) -> None:
    data = _data({"terrain": "data/hills.yaml"}, _start(3.0, 2.5))
    (tmp_path / "runs").mkdir()
    dump_scenario(parse_scenario(data, tmp_path / "s.yaml"), tmp_path / "runs" / "s.yaml")
    assert "terrain: ../data/hills.yaml" in (tmp_path / "runs" / "s.yaml").read_text("utf-8")
    again = build_world(load_scenario(tmp_path / "runs" / "s.yaml"))
    assert again.terrain == load_terrain(heights)


def test_what_the_generator_refuses_is_one_line_with_the_key() -> None:
    for options, message in (
        ({"width": 1.5}, "a.yaml: world.generate.width: expected a number of at least 0 and at mo"),
        ({"size": [500, 500]}, "a.yaml: world.generate.size: 10000 x 10000 cells are too many"),
    ):
        source = {"kind": "gap", "size": [9, 4], **options}
        with pytest.raises(ScenarioError) as caught:
            build_world(parse_scenario(_data({"generate": source}), "a.yaml"))
        assert message in str(caught.value)
    fine = _data({"generate": {"kind": "gap", "size": [9, 4]}, "resolution": 0.005})
    with pytest.raises(ScenarioError, match=r"world\.resolution: expected cells of 0\.02"):
        build_world(parse_scenario(fine))


@pytest.mark.parametrize(
    ("world", "robot", "problem"),
    [
        ({"generate": {"kind": "gap", "size": [9, 4]}}, _start(4.5, 2.0), "stands in a hole"),
        ({"generate": {"kind": "gap", "size": [9, 4]}}, _start(4.2, 2.0), "stands in a hole"),
        ({"generate": {"kind": "gap", "size": [9, 4]}}, _start(0.2, 2.0), "reaches beyond the map"),
        (
            {
                "generate": {"kind": "step", "size": [9, 4]},
                "obstacles": [{"circle": {"center": [2, 2], "radius": 0.3}}],
            },
            _start(2.2, 2.0),
            "stands in world.obstacles[0]",
        ),
    ],
)
def test_starts_where_no_robot_can_stand(world: Data, robot: Data, problem: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        build_world(parse_scenario(_data(world, robot)))
    assert problem in str(caught.value)
    assert str(caught.value).startswith("robots[0].start: ")


def test_a_body_over_a_gap_may_stand_if_its_feet_do() -> None:
    data = _data({"generate": {"kind": "gap", "size": [9, 4], "width": 0.2}}, _start(4.5, 2.0))
    build_world(parse_scenario(data))


def test_goals_are_the_planners_business() -> None:
    robot = {**_start(2.0, 2.0), "goal": [4.5, 99.0, 0.0]}
    build_world(parse_scenario(_data({"generate": {"kind": "gap", "size": [9, 4]}}, robot)))


class TestRoundRobots:
    """Discs are discs: their corners are free."""

    def _world(self, *robots: Data, **world: Any) -> None:
        source = {"empty": {"size": [6, 4]}, **world}
        build_world(parse_scenario(_data(source, *robots)))

    def test_discs_may_stand_where_squares_would_not(self) -> None:
        disc = {"model": "unicycle-sphere", "goal": [1.0, 1.0, 0.0]}
        one = {**disc, "start": [1.0, 1.0, 0.8]}
        self._world(one, {**disc, "start": [1.6, 1.6, 0.0]})
        self._world({**disc, "start": [0.401, 3.599, 0.3]})
        box = {"box": {"center": [1.45, 1.45], "size": [0.3, 0.3]}}
        self._world(one, obstacles=[box])
        with pytest.raises(ScenarioError, match=r"robots\[1\]\.start: .* overlaps robot 0"):
            self._world(one, {**disc, "start": [1.55, 1.55, 0.0]})
        with pytest.raises(ScenarioError, match="reaches beyond the map"):
            self._world({**disc, "start": [0.39, 3.0, 0.3]})
        box["box"]["center"] = [1.4, 1.4]
        with pytest.raises(ScenarioError, match=r"stands in world\.obstacles\[0\]"):
            self._world(one, obstacles=[box])

    def test_discs_and_boxes_meet(self) -> None:
        box = {"model": "unicycle", "goal": [1.0, 1.0, 0.0], "start": [2.0, 1.0, 0.0]}
        disc = {"model": "double-integrator", "goal": [1.0, 1.0, 0.0]}
        self._world(box, {**disc, "start": [2.41, 1.0, 0.0]})
        for robots in (
            (box, {**disc, "start": [2.39, 1.0, 0.0]}),
            ({**disc, "start": [2.39, 1.0, 0.0]}, box),
        ):
            with pytest.raises(ScenarioError, match="overlaps robot 0"):
                self._world(*robots)


def test_free_ground_may_lie_anywhere(tmp_path: Path) -> None:
    data = _data({"empty": {"size": [3, 2], "origin": [-1.0, -0.5]}}, _start(-0.5, 0.0))
    scenario = parse_scenario(data)
    world = build_world(scenario)
    assert world.map.origin == (-1.0, -0.5, 0.0)
    assert world.map.contains([(-1.0, -0.5), (2.0, 1.5)]).all()
    dump_scenario(scenario, tmp_path / "s.yaml")
    assert build_world(load_scenario(tmp_path / "s.yaml")).map == world.map
