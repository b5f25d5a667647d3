"""Bodies and feet over terrain: sound plans pass, planted faults are found."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cavalcade.checking.heights import Heights, floor_of
from cavalcade.scenario import build_world, parse_scenario


def terrain(kind, **options):
    return {"generate": {"kind": kind, "size": [9, 4], "seed": 3, **options}}


def kinds(report):
    return {violation.kind for violation in report.violations}


def first(report, kind):
    return next(v for v in report.violations if v.kind == kind)


def lifted(judged, height, slope):
    """The plan of level ground raised by `height(x)` with the derivative `slope(x)`."""
    arrays = judged.arrays
    x = arrays["position_0"][:, 0]
    arrays["position_0"][:, 2] += height(x)
    arrays["velocity_0"][:, 2] += slope(x) * arrays["velocity_0"][:, 0]
    arrays["footholds_0"][:, 5] += height(arrays["footholds_0"][:, 3])
    steps = np.diff(arrays["position_0"], axis=0)
    judged.summary["path_length_m"] = [float(np.sqrt((steps**2).sum(axis=1)).sum())]
    return judged


@pytest.mark.parametrize("angle", [0.2, -0.2])
def test_walking_on_a_slope(maker, team, angle):
    world = terrain("slope", angle=angle, length=7.0)
    judged = team(maker((3.0, 2.0, 0.0)).walk(3.0), world=world)
    lifted(judged, lambda x: math.tan(angle) * (x - 1.0), lambda x: math.tan(angle) + 0 * x)
    assert judged.report().violations == ()


def test_a_slope_too_steep(maker, team):
    world = terrain("slope", angle=0.75, length=7.0)
    judged = team(maker((3.0, 2.0, 0.0)).walk(3.0), world=world)
    lifted(judged, lambda x: math.tan(0.75) * (x - 1.0), lambda x: math.tan(0.75) + 0 * x)
    assert {"traversability", "foothold"} <= kinds(judged.report())


def test_walking_across_a_gap(maker, team):
    judged = team(maker((2.5, 2.0, 0.0)).walk(4.0), world=terrain("gap", width=0.4))
    report = judged.report()
    assert {"reach", "traversability", "foothold"} <= kinds(report)
    violation = first(report, "traversability")
    assert violation.robots == (0,)
    # The front hips come to the edge of the gap, give or take a foot's margin and two cells.
    hips = 4.5 - 0.2 - 0.1881 - 2.5
    assert violation.time == pytest.approx(hips / 0.75 + 0.375, abs=0.15 / 0.75)


def test_leaping_across_a_gap(maker, team):
    plan = maker((2.5, 2.0, 0.0)).ramp(0.0, 1.5).cruise(1.5, 0.1)
    plan.leap(speed=1.5)
    table = plan.arrays()
    middle = table["position_0"][table["phase_0"] == 2, 0].mean()
    world = terrain("gap", width=0.2, at=float(middle))
    judged = team(plan.cruise(1.5, 0.1).ramp(1.5, 0.0), world=world)
    assert judged.report().violations == ()


def test_walking_into_a_step(maker, team):
    report = team(maker((2.5, 2.0, 0.0)).walk(4.0), world=terrain("step", height=0.25)).report()
    violation = first(report, "belly")
    assert violation.limit == 0.075
    # When the front of the trunk comes to the edge.
    assert violation.time == pytest.approx((4.5 - 0.15 - 2.5) / 0.75 + 0.375, abs=0.3)


@pytest.mark.parametrize(
    ("height", "found"),
    [(0.095, {"belly"}), (0.105, set()), (0.38, set()), (0.42, {"reach"})],
)
@pytest.mark.parametrize("world", [None, terrain("step", height=0.0)])
def test_the_height_of_a_walking_body(maker, team, world, height, found):
    slack = {0.095: -0.011}.get(height, 0.0)
    plan = maker((3.0, 2.0, 0.0), height=height + slack).walk(2.0)
    assert kinds(team(plan, world=world).report()) == found


def test_a_foot_in_a_gap(maker, team):
    world = terrain("gap", width=0.4, at=7.5)
    judged = team(maker((2.5, 2.0, 0.0)).walk(4.0), world=world)
    assert judged.report().ok
    feet = judged.arrays["footholds_0"]
    k = int(np.argmax(feet[:, 3]))
    feet[k, 3:6] = (7.5, 2.0, -1.0)
    assert kinds(judged.report()) == {"foothold"}


def test_the_border_is_that_of_the_terrain(maker, team):
    judged = team(maker((6.0, 2.0, 0.0)).walk(2.8), world=terrain("step", height=0.0))
    (violation,) = judged.report().violations
    assert (violation.kind, violation.obstacle) == ("robot-map", "border")


@pytest.fixture(scope="module")
def rough():
    """The world's own terrain of a scenario, and the checker's layers of its heights."""
    content = {
        "version": 1,
        "name": "rough",
        "world": terrain("rough", height=0.25, spacing=0.8),
        "robots": [{"model": "go1", "start": [0.6, 2, 0], "goal": [8, 2, 0]}],
        "task": {"goals": "individual"},
    }
    world = build_world(parse_scenario(content)).terrain
    places = np.random.default_rng(1).uniform((0.6, 0.6), (8.4, 3.4), (400, 2))
    ground = floor_of(Heights(world.height, world.resolution, world.origin), places)
    return world, ground, places


def test_heights_between_cells_are_bilinear(rough):
    world, ground, places = rough
    cell = world.resolution
    for (x, y), found in zip(places, ground.heights_at(places), strict=True):
        u, v = x / cell - 0.5, y / cell - 0.5
        i, j = int(v), int(u)
        s, t = u - j, v - i
        h = world.height
        wanted = (1 - t) * ((1 - s) * h[i, j] + s * h[i, j + 1])
        wanted += t * ((1 - s) * h[i + 1, j] + s * h[i + 1, j + 1])
        assert found == pytest.approx(wanted, abs=1e-12)


def test_traversability_is_about_that_of_the_world_and_never_below(rough):
    world, ground, places = rough
    theirs = world.traversability_at(places)
    ours = ground.best_at(places)
    assert (ours > theirs - 0.03).all()
    assert np.median(ours - theirs) < 0.15
    assert (theirs < 0.6).any()


def test_slopes_are_about_those_of_the_world(rough):
    world, ground, places = rough
    cells = np.floor(places / world.resolution).astype(int)
    normals = world.normals[cells[:, 1], cells[:, 0]]
    centres = (cells + 0.5) * world.resolution
    for yaw in (0.0, 1.0, math.pi / 2):
        theirs = -(np.cos(yaw) * normals[:, 0] + np.sin(yaw) * normals[:, 1]) / normals[:, 2]
        ours = ground.slope_at(centres, np.full(len(centres), yaw))
        assert np.abs(ours - theirs).max() < 0.01


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
def test_a_plane_is_a_plane_wherever_it_lies(yaw):
    rng = np.random.default_rng(2)
    cell, a, b = 0.05, 0.2, -0.1
    x = (np.arange(120) + 0.5) * cell
    plane = a * x[None, :] + b * x[:100, None] + 0.3
    origin = (3.0, -1.0, yaw)
    local = rng.uniform((2.0, 2.0), (4.0, 3.0), (50, 2))
    c, s = math.cos(yaw), math.sin(yaw)
    places = local @ np.array([[c, s], [-s, c]]) + origin[:2]
    ground = floor_of(Heights(plane, cell, origin), places)
    wanted = a * local[:, 0] + b * local[:, 1] + 0.3
    assert ground.heights_at(places) == pytest.approx(wanted, abs=1e-9)
    assert ground.slope_at(places, np.full(50, yaw)) == pytest.approx(a, abs=1e-9)
    assert ground.slope_at(places, np.full(50, yaw + math.pi / 2)) == pytest.approx(b, abs=1e-9)
    steep = math.atan(math.hypot(a, b))
    assert ground.best_at(places) == pytest.approx(1.0 - 0.5 * steep / 0.4 + 0.02, abs=0.01)


def test_holes_without_heights_are_no_place_to_stand():
    height = np.zeros((60, 60))
    height[20:30, 20:30] = np.nan
    places = np.array([[1.25, 1.25], [0.5, 0.5], [1.25, 0.7]])
    ground = floor_of(Heights(height, 0.05), places)
    assert ground.best_at(places) == pytest.approx([0.0, 1.0, 1.0])
    assert ground.heights_at(places) == pytest.approx(0.0, abs=1e-9)
