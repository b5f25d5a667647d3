from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import cavalcade as cv
from cavalcade.drawing.figures import make_figures
from cavalcade.drawing.plans.motion import activities, leaps
from cavalcade.drawing.plans.timing import team_gaps
from cavalcade.drawing.plans.top_view import waits
from cavalcade.drawing.scene import PlanScene, runs

RED, BLUE = (215, 25, 28), (31, 95, 224)


@pytest.fixture
def drawn(make_scenario, straight_team, tmp_path):
    def make(leaping=(), team=None, **options):
        scenario = make_scenario(**options)
        world = cv.build_world(scenario)
        made = cv.plan(scenario, coordinator=team or straight_team(leaping=leaping))
        return make_figures(scenario, world, tmp_path / "figures", plan=made)

    return make


def share(file, colour) -> float:
    """Of the picture's points that are nearly of a colour."""
    picture = np.asarray(Image.open(file).convert("RGB")).astype(int)
    return float((np.abs(picture - colour).max(axis=2) < 12).mean())


def test_walking_is_red_and_flight_blue(drawn):
    files = {file.name: file for file in drawn()}
    assert sorted(files) == ["footholds.png", "plan.png", "timing.png"]
    for name in ("plan.png", "timing.png"):
        assert share(files[name], RED) > 1e-3
        assert share(files[name], BLUE) == 0.0


def test_a_flight_is_drawn(drawn):
    files = {file.name: file for file in drawn(leaping=(0,))}
    assert share(files["plan.png"], BLUE) > 1e-4
    assert share(files["timing.png"], BLUE) > 1e-4


def test_terrain_has_a_profile(drawn, straight_team):
    files = drawn(
        team=straight_team(waits=(0.0,)),
        robots=[((1.0, 2.0, 0.0), (8.0, 2.0, 0.0))],
        world={"generate": {"kind": "step", "size": [9, 4], "seed": 0}},
    )
    assert "profile.png" in {file.name for file in files}


@pytest.mark.parametrize("late", [-0.5, 0.0, 0.499, 0.5, 0.501, 20.0])
def test_steps_after_the_end_of_a_plan_are_drawn(make_scenario, straight_team, tmp_path, late):
    scenario = make_scenario(
        robots=[((1.0, 2.0, 0.0), (8.0, 2.0, 0.0))],
        world={"generate": {"kind": "step", "size": [9, 4], "seed": 0}},
    )
    made = cv.plan(scenario, coordinator=straight_team(waits=(0.0,)))
    down = made.trajectories[0].duration + late
    step = [[down, down + 0.3, 2.0, 8.0, 2.1, 0.0]]
    driven = replace(made.planned, footholds=(np.vstack([made.footholds[0], step]),))
    files = make_figures(scenario, made.world, tmp_path / "figures", plan=driven)
    assert "profile.png" in {file.name for file in files}


def test_robots_without_legs_have_no_footholds(drawn):
    names = {file.name for file in drawn(model="unicycle")}
    assert names == {"plan.png", "timing.png"}


def test_without_any_path_the_problem_is_drawn(drawn, no_plan):
    assert [file.name for file in drawn(team=no_plan)] == ["plan.png"]


def test_twenty_robots_are_drawn(drawn, straight_team):
    ways = [((1.0, 0.6 + 0.6 * k, 0.0), (9.0, 0.6 + 0.6 * k, 0.0)) for k in range(20)]
    team = straight_team(waits=[0.2 * k for k in range(20)])
    files = drawn(team=team, robots=ways, world={"empty": {"size": [10, 13]}})
    assert len(files) == 3


def test_waits_and_leaps_are_found(make_scenario, straight_team):
    scenario = make_scenario()
    world = cv.build_world(scenario)
    walking, waiting = straight_team(waits=(0.0, 3.0), leaping=(0,))(scenario, world).trajectories
    assert waits(walking) == []
    assert waits(waiting) == [(4.0, 1.0, pytest.approx(3.0))]
    ((first, last),) = leaps(walking)
    assert walking.time[last] - walking.time[first] == pytest.approx(0.6, abs=0.06)
    assert [kind for kind, *_ in runs(activities(walking))] == [1, 2, 1]


def test_gaps_over_time_are_those_of_the_summary(make_scenario, straight_team):
    for model in ("spirit", "single-integrator"):
        scenario = make_scenario(model=model)
        world = cv.build_world(scenario)
        made = cv.plan(scenario, coordinator=straight_team(waits=(0.0, 3.0)))
        times, gaps = team_gaps(PlanScene(scenario, world, made))
        assert times[-1] == pytest.approx(made.summary["makespan_s"], abs=1e-6)
        np.testing.assert_array_equal(gaps[:, 0], gaps[:, 1])
        # The obstacles are farther away than the robots come to each other.
        assert gaps.min() == pytest.approx(made.summary["min_footprint_gap_m"], abs=0.01)
