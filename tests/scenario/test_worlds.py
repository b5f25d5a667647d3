"""From a scenario to its ground."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.errors import MapError, ScenarioError
from cavalcade.scenario import build_world, parse_scenario
from cavalcade.world import Box, Circle, OccupancyMap, Polygon, save_map

Data = dict[str, Any]


def test_shapes_are_exact_and_rasterised_on_the_base(data: Data) -> None:
    world = build_world(parse_scenario(data))
    assert world.shapes == (
        Box((4.0, 2.0), (1.0, 0.4), 0.3),
        Circle((6.0, 4.0), 0.2),
        Polygon(((3.0, 4.0), (4.0, 4.0), (3.0, 5.0))),
    )
    assert world.base == OccupancyMap.empty((8.0, 5.0), 0.05)
    assert world.map == world.base.with_shapes(world.shapes)
    assert [span.obstacle for span in world.spans] == list(parse_scenario(data).world.obstacles)


def test_a_map_file_with_its_place_and_its_unknown_cells(tmp_path: Path, data: Data) -> None:
    grid = np.zeros((100, 160), dtype=np.int8)
    grid[:, :10] = -1
    save_map(OccupancyMap(grid, 0.05, origin=(-0.5, 0.0, 0.0)), tmp_path / "m.yaml")
    data["world"] = {"map": "m.yaml"}
    data["robots"][1]["start"] = [0.7, 1.0, 0.0]
    scenario = parse_scenario(data, tmp_path / "s.yaml")
    world = build_world(scenario)
    assert world.map.occupied[:, :10].all()
    data["world"]["unknown"] = "free"
    assert not build_world(parse_scenario(data, tmp_path / "s.yaml")).map.occupied.any()


def test_a_missing_map_is_the_maps_error(tmp_path: Path, data: Data) -> None:
    data["world"] = {"map": "missing.yaml"}
    with pytest.raises(MapError, match=r"missing\.yaml"):
        build_world(parse_scenario(data, tmp_path / "s.yaml"))


def test_generated_worlds_follow_the_seed(data: Data) -> None:
    data["world"] = {"generate": {"kind": "clutter", "size": [14, 10]}}
    first, again, other = (
        build_world(parse_scenario({**data, "execution": {"seed": seed}})) for seed in (1, 1, 2)
    )
    assert first.shapes == again.shapes
    assert first.shapes != other.shapes
    assert len(first.shapes) == 25
    data["world"]["generate"]["seed"] = 7
    fixed = [build_world(parse_scenario({**data, "execution": {"seed": s}})) for s in (1, 2)]
    assert fixed[0].shapes == fixed[1].shapes


def test_a_generators_refusal_names_the_key(data: Data) -> None:
    data["world"] = {"generate": {"kind": "clutter", "size": [3, 3]}}
    with pytest.raises(ScenarioError, match=r"world\.generate\.size: "):
        build_world(parse_scenario(data))


def test_a_movingai_map(tmp_path: Path, data: Data) -> None:
    rows = ["@" + "." * 31] + ["." * 32] * 19
    text = "type octile\nheight 20\nwidth 32\nmap\n" + "\n".join(rows) + "\n"
    (tmp_path / "m.map").write_text(text, encoding="ascii")
    data["world"] = {"movingai": {"file": "m.map"}}
    world = build_world(parse_scenario(data, tmp_path / "s.yaml"))
    assert world.map.size == (8.0, 5.0)
    assert world.map.occupied[19, 0]
    assert world.map.occupied.sum() == 1


def test_a_barn_world(tmp_path: Path, data: Data) -> None:
    text = "x_m,y_m,radius_m\n-4,-1,0.1\n4,3.9,0.1\n"
    (tmp_path / "w.csv").write_text(text, encoding="ascii")
    data["world"] = {"barn": {"file": "w.csv"}}
    world = build_world(parse_scenario(data, tmp_path / "s.yaml"))
    assert world.shapes[0] == Circle((0.1, 0.1), 0.1)
    assert world.map.size == pytest.approx((8.2, 5.1), abs=0.051)


def test_a_hundred_million_cells_are_refused_at_once(data: Data) -> None:
    data["world"] = {"empty": {"size": [500, 500]}}
    with pytest.raises(ScenarioError, match=r"world\.empty\.size: .*cells"):
        build_world(parse_scenario(data))


def test_a_polygon_that_crosses_itself_names_its_place(data: Data) -> None:
    bow = {"polygon": {"points": [[1, 0.2], [2, 1.2], [2, 0.2], [1, 1.2]]}}
    data["world"]["obstacles"].append(bow)
    with pytest.raises(ScenarioError, match=r"^a.yaml: world\.obstacles\[3\]: edges 0 and 2"):
        build_world(parse_scenario(data, "a.yaml"))
    data["world"]["obstacles"].pop()
    data["execution"] = {"events": [{"at": 3, "add": bow}]}
    with pytest.raises(ScenarioError, match=r"execution\.events\[0\]\.add: edges 0 and 2"):
        build_world(parse_scenario(data))


def test_events_bring_spans_but_not_shapes(events: Callable[..., Data]) -> None:
    data = events({"at": 3, "add": {"circle": {"center": [2, 1], "radius": 0.2}}})
    world = build_world(parse_scenario(data))
    assert len(world.shapes) == 3
    assert len(world.spans) == 4
