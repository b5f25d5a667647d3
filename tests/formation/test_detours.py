"""What narrow places cost: corridors that bodies fit through are not shunned for wider ones."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cavalcade as cv
from cavalcade.eikonal import TravelGrid, surface_distance
from cavalcade.formation import Formation, FormationPlanner, FormationSettings
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.formation.settings import IMPROVED
from cavalcade.world import Box, OccupancyMap

HALF = 0.14  # m, of a Go1's width
SPARE = 0.30  # m on each side, with which a way may cost 20 % at most
MIDDLE = 2.0  # m: y of the corridor
LONG = 8.0  # m


def corridor(width, cell=0.05, top=9.0):
    """A corridor along x from 6 to 14 m, and wide open ground above y = `top`."""
    low, high = MIDDLE - width / 2.0, MIDDLE + width / 2.0
    walls = [
        Box((10.0, low / 2.0), (LONG, low)),
        Box((10.0, (high + top) / 2.0), (LONG, top - high)),
    ]
    return OccupancyMap.empty((20.0, 13.0), cell).with_shapes(walls)


def way(map, **values):
    """Highest y of the leader's path from one side to the other, and its length, m."""
    chosen = replace(IMPROVED, **values)
    maps = PlanningMaps(map.occupied, map.resolution, chosen, half_width=HALF)
    points, _ = maps.leader.field((18.0, MIDDLE)).path((2.0, MIDDLE))
    return points[:, 1].max(), float(np.hypot(*np.diff(points, axis=0).T).sum())


@pytest.mark.parametrize(
    ("width", "cell"), [(0.88, 0.02), (0.9, 0.05), (1.0, 0.05), (1.0, 0.1), (1.0, 0.25)]
)
def test_a_corridor_that_bodies_fit_through_was_shunned_for_a_detour(width, cell):
    map = corridor(width, cell)
    assert way(map)[0] < MIDDLE + 0.5
    assert way(map, max_detour=math.inf)[0] > 9.0


@pytest.mark.parametrize("width", [0.64, 0.70])
def test_a_way_much_narrower_than_that_still_costs_more(width):
    assert way(corridor(width))[0] > 9.0


@pytest.mark.parametrize(
    ("most", "top", "through"),
    # Around it is 1.05, 1.4 and 1.8 times as far as through it.
    [(0.0, 3.0, True), (0.2, 3.0, False), (0.2, 6.5, True), (0.6, 9.0, True), (2.0, 9.0, False)],
)
def test_the_setting_says_how_far_around_is_too_far(most, top, through):
    highest, _ = way(corridor(0.9, top=top), max_detour=most)
    assert (highest < MIDDLE + 0.5) == through


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.05, 0.1, 0.25]))
def test_paths_cost_at_most_a_fifth_of_the_shortest_roomy_way(seed, cell):
    rng = np.random.default_rng(seed)
    rows, cols = round(8.0 / cell), round(12.0 / cell)
    centres = rng.uniform((1.0, 0.0), (11.0, 8.0), (14, 2))
    map = OccupancyMap.empty((12.0, 8.0), cell)
    map = map.with_shapes([Box(tuple(c), tuple(rng.uniform(0.3, 1.5, 2))) for c in centres])
    roomy = surface_distance(map.occupied, cell) >= HALF + SPARE
    maps = PlanningMaps(map.occupied, cell, IMPROVED, half_width=HALF)
    start = ((rows // 2 + 0.5) * cell, (cols // 8 + 0.5) * cell)[::-1]
    shortest, _ = TravelGrid(roomy.astype(float), cell).field((11.4, 4.0)).path(start)
    found, _ = maps.leader.field((11.4, 4.0)).path(start)
    if len(shortest) > 1:
        length = [np.hypot(*np.diff(path, axis=0).T).sum() for path in (found, shortest)]
        assert length[0] <= 1.2 * length[1] + cell


def test_the_papers_velocity_maps_stay_as_they_are():
    map = corridor(0.9)
    ours = PlanningMaps(map.occupied, 0.05, FormationSettings(), half_width=HALF)
    room = np.maximum(ours.distance - 0.30, 0.0)
    np.testing.assert_allclose(ours.leader.speed, np.minimum(room / 1.5, 1.0), atol=1e-12)
    np.testing.assert_allclose(ours.follower.speed, np.minimum(room / 0.5, 1.0), atol=1e-12)
    assert ours.slots is ours.follower
    planner = FormationPlanner(map, Formation.column(2, 0.8), variant="published")
    assert planner.settings.max_detour == math.inf


def test_speeds_never_fall_and_blocked_cells_stay_blocked():
    map = corridor(0.9)
    plain, priced = (
        PlanningMaps(map.occupied, 0.05, replace(IMPROVED, max_detour=most), half_width=HALF)
        for most in (math.inf, 0.2)
    )
    for name in ("leader", "follower"):
        before, after = getattr(plain, name).speed, getattr(priced, name).speed
        assert (after >= before - 1e-12).all()
        assert (after.max(), after.min()) == (1.0, 0.0)
        np.testing.assert_array_equal(before > 0.0, after > 0.0)


@pytest.mark.slow
def test_a_team_drives_through_it_and_not_around(tools):
    """The whole team, also where deadlocks are resolved one by one."""
    shape = Formation.square(1.0)
    planner = FormationPlanner(corridor(0.9), shape)
    planner.set_goal((17.0, MIDDLE, 0.0))
    drive = tools.drive(planner, tools.placed(shape, (3.0, MIDDLE, 0.0)), 90.0)
    assert drive.status[-1].arrived
    assert drive.poses[:, :, 1].max() < 4.0
    length = np.hypot(*np.diff(drive.poses[..., :2], axis=0).transpose(2, 0, 1)).sum(axis=0)
    assert length.max() < 1.2 * 14.0


@pytest.mark.parametrize(("said", "value"), [(".inf", math.inf), ("0", 0.0), ("0.35", 0.35)])
def test_scenarios_may_leave_the_price_without_a_bound(said, value, tmp_path):
    scenario = cv.load_scenario("cone", overrides=[f"planner.max_detour={said}"])
    cv.dump_scenario(scenario, tmp_path / "again.yaml")
    again = cv.load_scenario(tmp_path / "again.yaml")
    assert again.planner.max_detour == scenario.planner.max_detour == value
    for wrong in (".nan", "-1", "-.inf"):
        with pytest.raises(cv.ScenarioError, match=r"planner\.max_detour"):
            cv.load_scenario("cone", overrides=[f"planner.max_detour={wrong}"])
