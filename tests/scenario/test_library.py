"""The shipped scenarios are what their descriptions and the contract say."""

from __future__ import annotations

import math
import runpy
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import label

from cavalcade.geometry import Array
from cavalcade.scenario import (
    build_world,
    load_scenario,
    scenario_descriptions,
    scenario_names,
)
from cavalcade.world import Box, Circle, Shape, distance_to_shapes, load_map

STEP = 0.05


def _clearance(name: str) -> tuple[Array, Array]:
    """Points x `(W,)` and exact distances `(H, W)` to obstacles and border, `STEP` apart."""
    world = build_world(load_scenario(name))
    width, height = world.map.size
    x, y = np.arange(0, width + STEP / 2, STEP), np.arange(0, height + STEP / 2, STEP)
    points = np.stack(np.meshgrid(x, y), axis=-1)
    distance = distance_to_shapes(world.shapes, points.reshape(-1, 2)).reshape(len(y), len(x))
    border = np.minimum(np.minimum(x, width - x)[None, :], np.minimum(y, height - y)[:, None])
    return x, np.minimum(distance, border)


def _joined(name: str, radius: float) -> bool:
    """Whether a disc gets from the team's middle to every goal."""
    scenario = load_scenario(name)
    _, clearance = _clearance(name)
    areas, _ = label(clearance >= radius)
    middle = np.mean([start[:2] for start in scenario.starts], axis=0)
    ends = [middle, *(goal[:2] for goal in scenario.task.goals)]
    found = {areas[round(y / STEP), round(x / STEP)] for x, y in ends}
    return len(found) == 1 and 0 not in found


def _outline(shape: Shape) -> Array:
    """Points `(N, 2)` along the shape's edge, about 1 cm apart."""
    if isinstance(shape, Circle):
        angle = np.linspace(0.0, 2.0 * np.pi, 300)
        return np.array(shape.center) + shape.radius * np.c_[np.cos(angle), np.sin(angle)]
    corners = shape.corners if isinstance(shape, Box) else shape.vertices
    ends = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return np.concatenate([np.linspace(a, b, 150) for a, b in ends])


@pytest.mark.parametrize("name", scenario_names())
def test_each_one_says_what_it_is_and_can_be_built(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.name == name
    assert scenario_descriptions()[name] == scenario.description != ""
    world = build_world(scenario)
    for goal in (*scenario.task.goals, *scenario.goals):
        assert world.map.contains([goal[:2]]).all()


@pytest.mark.parametrize(
    "name", ["square-clutter", "cone", "triangle-lab", "triangle-corridor", "tour-ten", "maze-solo"]
)
def test_a_robot_has_room_on_the_way(name: str) -> None:
    assert _joined(name, 0.40)


def test_the_infeasible_one_is() -> None:
    assert not _joined("infeasible", 0.05)


def test_every_way_through_the_arena_has_two_narrow_gaps() -> None:
    x, clearance = _clearance("square-clutter")
    for low, high in ((3.2, 6.0), (7.9, 10.4)):
        band = (clearance >= 0.70 - STEP / 2)[:, (x >= low) & (x <= high)]
        areas, _ = label(band, structure=np.ones((3, 3)))
        assert not (set(areas[:, 0]) & set(areas[:, -1])) - {0}


@pytest.mark.parametrize("name", ["square-clutter", "triangle-lab"])
def test_no_gap_is_too_narrow_for_one_robot_and_yet_open(name: str) -> None:
    world = build_world(load_scenario(name))
    outlines = [_outline(shape) for shape in world.shapes]
    for k, points in enumerate(outlines):
        gaps = [float(other.distance(points).min()) for other in world.shapes[:k]]
        gaps.append(float(np.minimum(points, np.array(world.map.size) - points).min()))
        assert all(gap <= 1e-6 or gap > 0.79 for gap in gaps)


def test_the_corridor_is_one_metre_wide_with_two_bends() -> None:
    scenario = load_scenario("triangle-corridor")
    world = build_world(scenario)
    legs = [((3.1, 4.6), (4.1, 4.6)), ((4.1, 4.6), (5.4, 2.0)), ((5.4, 2.0), (6.4, 2.0))]
    angles = []
    for (x0, y0), (x1, y1) in legs:
        along = np.linspace(0.0, 1.0, 21)[1:-1, None]
        points = np.array([x0, y0]) + along * np.array([x1 - x0, y1 - y0])
        for shape in world.shapes:
            distance = shape.distance(points)
            assert distance.min() == pytest.approx(0.5, abs=1e-3)
            assert distance[len(points) // 2] == pytest.approx(0.5, abs=1e-3)
        angles.append(math.degrees(math.atan2(y1 - y0, x1 - x0)))
    assert [abs(b - a) for a, b in pairwise(angles)] == pytest.approx([63.43, 63.43], abs=0.01)


@pytest.mark.parametrize(
    ("name", "shape", "side", "preset", "lookahead"),
    [
        ("square-clutter", "square", 1.0, "simulation", 5.0),
        ("cone", "square", 1.0, "simulation", 5.0),
        ("triangle-lab", "triangle", 1.15, "laboratory", 2.5),
        ("triangle-corridor", "triangle", 1.15, "laboratory", 2.5),
    ],
)
def test_the_papers_parameters(
    name: str, shape: str, side: float, preset: str, lookahead: float
) -> None:
    scenario = load_scenario(name)
    formation = scenario.task.formation
    assert (formation.shape, formation.side) == (shape, side)
    assert (scenario.planner.preset, scenario.planner.lookahead) == (preset, lookahead)
    starts = np.array(scenario.starts)[:, :2]
    away = np.hypot(*(starts[:, None] - starts[None]).transpose(2, 0, 1))
    assert np.sort(away[away > 0])[0] == pytest.approx(side, abs=1e-3)


def test_sizes_of_the_papers_arenas() -> None:
    assert build_world(load_scenario("square-clutter")).map.size == pytest.approx((14.0, 10.0))
    for name in ("triangle-lab", "triangle-corridor"):
        assert build_world(load_scenario(name)).map.size == pytest.approx((9.5, 6.5))


def test_the_tour_has_ten_robots_and_waypoints() -> None:
    scenario = load_scenario("tour-ten")
    assert len(scenario.robots) == 10
    assert len(scenario.task.goals) >= 3


def test_the_office_map_is_what_its_script_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = Path(__file__).parents[2] / "tools" / "draw_office_map.py"
    drawing = runpy.run_path(str(script))
    monkeypatch.setitem(drawing["main"].__globals__, "LIBRARY", tmp_path)
    drawing["main"]()
    world = build_world(load_scenario("office"))
    assert load_map(tmp_path / "office.yaml") == world.map
    assert (world.map.grid == -1).any()


def test_every_room_of_the_office_can_be_reached() -> None:
    free, count = label(~build_world(load_scenario("office")).map.occupied)
    assert count == 1
    assert free.any()


SWAPS = {"head-on": 2, "corner-swap": 4, "hexagon-swap": 6, "octagon-swap": 8, "alcove": 2}
TERRAIN = ("gap", "step", "rough")


@pytest.mark.parametrize("name", [*SWAPS, *TERRAIN])
def test_robots_with_goals_of_their_own_face_them(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.task.kind == "individual"
    assert scenario.planner.method == "auto"
    for start, goal in zip(scenario.starts, scenario.goals, strict=True):
        heading = math.atan2(goal[1] - start[1], goal[0] - start[0])
        assert start[2] == goal[2] == pytest.approx(heading, abs=1e-12)


@pytest.mark.parametrize("name", SWAPS)
def test_swaps_exchange_places(name: str) -> None:
    scenario = load_scenario(name)
    assert len(scenario.robots) == SWAPS[name]
    places = {start[:2] for start in scenario.starts}
    assert {goal[:2] for goal in scenario.goals} == places
    back = {
        start[:2]: goal[:2] for start, goal in zip(scenario.starts, scenario.goals, strict=True)
    }
    assert all(back[back[place]] == place != back[place] for place in places)


@pytest.mark.parametrize(("name", "length"), [("hexagon-swap", 14.0), ("octagon-swap", 16.0)])
def test_swaps_across_a_circle(name: str, length: float) -> None:
    scenario = load_scenario(name)
    assert {robot.model for robot in scenario.robots} == {"spirit"}
    for start, goal in zip(scenario.starts, scenario.goals, strict=True):
        assert math.dist(start[:2], goal[:2]) == pytest.approx(length, abs=1e-3)


def test_the_corner_swap_is_a_rectangle_of_5_by_2() -> None:
    scenario = load_scenario("corner-swap")
    x, y = (sorted({start[axis] for start in scenario.starts}) for axis in (0, 1))
    assert (x[1] - x[0], y[1] - y[0]) == (5.0, 2.0)


def test_the_alcove_is_the_only_place_to_pass() -> None:
    scenario = load_scenario("alcove")
    world = build_world(scenario)
    model = scenario.models[0]
    free = ~world.map.occupied
    widths = free.sum(axis=0) * world.map.resolution
    corridor = widths[widths < 1.0]
    assert 0 < len(corridor) < len(widths)
    assert corridor == pytest.approx(0.65)
    # One robot has room in the corridor, two side by side have not, nor can one turn about.
    assert model.width + 0.2 < 0.65 < 2.0 * model.width
    diagonal = math.hypot(model.length, model.width)
    assert diagonal > 0.65
    # In the alcove one turns about and leaves the corridor free for the other.
    alcove = free[13:]
    assert alcove.any(axis=0).sum() * world.map.resolution > diagonal
    assert alcove.any(axis=1).sum() * world.map.resolution > diagonal + 0.05
    assert all(0.0 < start[1] < 0.65 for start in scenario.starts)


@pytest.mark.parametrize("name", TERRAIN)
def test_terrain_has_to_be_crossed(name: str) -> None:
    scenario = load_scenario(name)
    terrain = build_world(scenario).terrain
    assert terrain is not None
    assert 1 <= len(scenario.robots) <= 3
    if name == "rough":
        assert np.ptp(terrain.height) == pytest.approx(0.25, abs=0.03)
        return
    middle = 4.5
    for start, goal in zip(scenario.starts, scenario.goals, strict=True):
        assert start[0] + 1.0 < middle < goal[0] - 1.0
    steps = np.diff(terrain.height, axis=1)
    if name == "gap":
        pit = terrain.height < -0.9
        assert pit.sum(axis=1) * terrain.resolution == pytest.approx(0.4)
    else:
        assert (steps.max(axis=1) == 0.25).all()
        assert ((steps > 0.0).sum(axis=1) == 1).all()
