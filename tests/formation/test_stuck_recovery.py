"""Finding robots that cannot turn where they are."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from cavalcade.formation.cycle import Cycle
from cavalcade.formation.planning_maps import PlanningMaps
from cavalcade.formation.settings import IMPROVED
from cavalcade.formation.stuck_recovery import StuckRecovery
from cavalcade.robots import robot_model
from cavalcade.world import Box, OccupancyMap

GO1 = robot_model("go1")
PERIOD = 0.05
GOAL = np.array([3.0, 3.0, math.pi])
ALLEY = OccupancyMap.empty((6.0, 6.0)).with_shapes(
    [Box((4.0, 3.0 + side * 0.5), (3.0, 0.3)) for side in (1.0, -1.0)]
)
GROUND = PlanningMaps(ALLEY.occupied, ALLEY.resolution, IMPROVED)


def cycle_at(pose: list[float], time: float, others: list[list[float]] = []) -> Cycle:  # noqa: B006
    """Robot 0 at a pose, in the state final; its slot is the goal's."""
    poses = np.array([pose, *others])
    plan = SimpleNamespace(maps=GROUND, pose=GOAL)
    active = np.array([0])
    cycle = Cycle(plan, SimpleNamespace(), poses, poses[:, :2].copy(), active, time)  # type: ignore[arg-type]
    cycle.roles = np.array([0] + [-1] * len(others))
    cycle.away = np.hypot(*(poses[:, :2] - GOAL[:2]).T)
    return cycle


def watch(pose: list[float], seconds: float, **more: object) -> tuple[Cycle, StuckRecovery]:
    """The last cycle after a robot has stood somewhere for so long."""
    wedges = StuckRecovery(GO1)
    ways = more.pop("ways", None)
    for step in range(round(seconds / PERIOD) + 1):
        cycle = cycle_at(pose, step * PERIOD, **more)  # type: ignore[arg-type]
        wedges.update(cycle, ways)  # type: ignore[arg-type]
    return cycle, wedges


def test_one_that_stands_across_its_slot_is_sent_to_turn_where_it_can() -> None:
    cycle, _ = watch([3.0, 3.0, 0.0], 2.1)
    place = cycle.detours[0]
    assert GROUND.distance_at(place) >= math.hypot(GO1.length, GO1.width) / 2.0
    assert cycle.facing[0] == pytest.approx(math.pi)
    assert cycle.away[0] > np.hypot(*(place - GOAL[:2])), "it may neither rest nor count as there"


@pytest.mark.parametrize("pose", [[3.0, 3.0, 3.1], [2.0, 3.0, 0.0]])
def test_one_that_is_right_or_not_there_is_left_alone(pose: list[float]) -> None:
    cycle, _ = watch(pose, 6.0)
    assert not cycle.detours
    assert np.isnan(cycle.facing).all()


def test_one_that_is_turning_is_left_alone() -> None:
    wedges = StuckRecovery(GO1)
    for step in range(100):
        cycle = cycle_at([3.0, 3.0, 0.06 * step / 2.0], step * PERIOD)
        wedges.update(cycle)
        assert not cycle.detours


def test_once_turned_it_comes_back_with_that_heading() -> None:
    cycle, wedges = watch([3.0, 3.0, 0.0], 2.1)
    x, y = cycle.detours[0]
    turned = cycle_at([x, y, math.pi - 0.05], cycle.time + PERIOD)
    wedges.update(turned)
    assert not turned.detours
    assert turned.facing[0] == pytest.approx(math.pi)
    back = cycle_at([2.9, 3.0, math.pi - 0.2], turned.time + PERIOD)
    wedges.update(back)
    assert back.facing[0] == pytest.approx(math.pi)


def test_a_place_where_another_robot_stands_is_not_taken() -> None:
    first, _ = watch([3.0, 3.0, 0.0], 2.1)
    other = [*first.detours[0], 0.0]
    second, _ = watch([3.0, 3.0, 0.0], 2.1, others=[other])
    assert np.hypot(*(second.detours[0] - first.detours[0])) > 0.7


def test_it_gives_up_after_some_places() -> None:
    wedges, tried, was = StuckRecovery(GO1), [], None
    for step in range(round(90.0 / PERIOD)):
        cycle = cycle_at([3.0, 3.0, 0.0], step * PERIOD)
        wedges.update(cycle)
        now = cycle.detours.get(0)
        if now is not None and was is None:
            tried.append(now)
        was = now
    assert 1 < len(tried) <= 4
    assert not cycle.detours
    assert all(np.hypot(*(a - b)) >= 0.4 for a in tried for b in tried if a is not b)


def test_on_its_way_one_turns_to_what_lies_ahead_and_keeps_it_until_past() -> None:
    pose, way = [4.5, 3.0, math.pi / 2 + 0.1], np.array([[4.5 - 0.05 * k, 3.0] for k in range(40)])
    alone, _ = watch(pose, 6.0)
    assert not alone.detours, "far from its slot only those with a way are helped"
    cycle, wedges = watch(pose, 2.1, ways=[way])
    assert cycle.facing[0] == pytest.approx(math.pi)
    x, y = cycle.detours[0]
    for here, kept in (([x, y], True), ([4.5 + 0.3, 3.0], True), ([4.45, 3.0], False)):
        after = cycle_at([*here, math.pi], cycle.time + PERIOD)
        wedges.update(after, [way])
        assert np.isfinite(after.facing[0]) == kept
        assert not after.detours
