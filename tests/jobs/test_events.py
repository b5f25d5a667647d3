from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cavalcade.errors import ScenarioError
from cavalcade.execution.control import ControlLoop
from cavalcade.execution.events import EventRunner
from cavalcade.execution.supervisor import Supervisor
from cavalcade.fleet import IdealFleet
from cavalcade.scenario import Scenario, build_world
from cavalcade.world import Box, Circle, OccupancyMap

CIRCLE = {"circle": {"center": [6.0, 1.0], "radius": 0.3}}


class Stage:
    """Events of a scenario, applied at 20 Hz."""

    def __init__(self, scenario: Scenario, straight: Any) -> None:
        self.world = build_world(scenario)
        self.planner = straight(scenario, self.world)
        self.fleet = IdealFleet(scenario.models, scenario.starts)
        self.supervisor = Supervisor(scenario.models, 0.05)
        self.maps: list[tuple[float, OccupancyMap]] = []
        self.notes: list[tuple[float, str]] = []
        self.control = ControlLoop(self.planner, self.fleet, self.supervisor)
        self.events = EventRunner(scenario, self.world, self.control)
        self.cycle = 0
        self._keep(0.0)

    def until(self, end: float) -> None:
        while self.cycle / 20 <= end + 1e-9:
            self.events.apply(self.cycle / 20)
            self._keep(self.cycle / 20)
            self.cycle += 1

    def _keep(self, time: float) -> None:
        notes, maps = self.events.news()
        self.notes += [(time, text) for text in notes]
        self.maps += [(time, grid) for grid in maps]

    @property
    def map(self) -> OccupancyMap:
        """The map that the planner has now."""
        given = self.planner.called("update_map")
        return given[-1][0] if given else self.world.map


@pytest.fixture
def stage(make_scenario: Callable[..., Scenario], straight: Any) -> Callable[..., Stage]:
    def make(*events: dict[str, Any], **options: Any) -> Stage:
        return Stage(make_scenario(events=list(events), **options), straight)

    return make


def test_without_events_nothing_happens(stage: Callable[..., Stage]) -> None:
    quiet = stage()
    assert [time for time, _ in quiet.maps] == [0.0]
    quiet.until(5.0)
    assert [call[0] for call in quiet.planner.calls] == ["set_goals"]
    assert len(quiet.maps) == 1
    assert quiet.events.tracks(5.0) == ()
    assert not quiet.events.task_pending
    assert not quiet.events.change_pending(5.0)


def test_an_obstacle_appears_and_disappears(stage: Callable[..., Stage]) -> None:
    play = stage({"at": 1.0, "add": CIRCLE}, {"at": 2.0, "remove": CIRCLE})
    play.until(0.95)
    assert play.planner.called("update_map") == []
    assert play.events.change_pending(0.95)
    play.until(1.0)
    assert play.map == play.world.map.with_shapes([Circle((6.0, 1.0), 0.3)])
    play.until(2.0)
    assert play.map == play.world.map
    assert len(play.planner.called("update_map")) == 2
    assert [time for time, _ in play.maps] == [0.0, 1.0, 2.0]
    assert play.notes == [(1.0, "obstacle added"), (2.0, "obstacle removed")]
    (track,) = play.events.tracks(5.0)
    assert (track.shape, track.start, track.end) == (CIRCLE, 1.0, 2.0)
    assert play.events.tracks(0.5) == ()


def test_a_moving_obstacle_is_drawn_cell_by_cell_and_announced(
    stage: Callable[..., Stage],
) -> None:
    play = stage({"at": 1.0, "move": {**CIRCLE, "to": [6.0, 3.0], "speed": 0.5}})
    play.until(5.5)
    given = [call[0] for call in play.planner.called("update_map")]
    # It appears, then 2 m in cells of 0.05 m.
    assert 38 <= len(given) <= 43
    assert play.map == play.world.map.with_shapes([Circle((6.0, 3.0), 0.3)])
    announced = [call[0] for call in play.planner.called("set_dynamic_obstacles")]
    assert announced[-1] == []
    moving = [movers[0] for movers in announced[:-1]]
    assert len(moving) == 80
    assert all(np.allclose(mover.velocity, (0.0, 0.5)) for mover in moving)
    places = [mover.shape.center[1] for mover in moving]
    assert places == pytest.approx(np.arange(80) * 0.025 + 1.0)
    # The recording gets it once a second and at the end.
    assert len(play.maps) <= 8
    assert play.maps[-1][1] == play.map
    assert not play.events.change_pending(5.5)


def test_a_shape_of_the_world_that_moves_leaves_its_old_place(stage: Callable[..., Stage]) -> None:
    box = {"box": {"center": [6.0, 1.0], "size": [0.4, 0.4], "yaw": 0.0}}
    wall = {"box": {"center": [4.0, 5.5], "size": [1.0, 0.4], "yaw": 0.0}}
    play = stage(
        {"at": 0.5, "move": {**box, "to": [7.0, 1.0], "speed": 1.0}},
        world={"obstacles": [wall, box]},
    )
    play.until(3.0)
    expected = play.world.base.with_shapes(
        [Box((4.0, 5.5), (1.0, 0.4)), Box((7.0, 1.0), (0.4, 0.4))]
    )
    assert play.map == expected
    (track,) = play.events.tracks(3.0)
    assert track.start == 0.0


def test_new_goals(stage: Callable[..., Stage]) -> None:
    play = stage({"at": 1.0, "goals": [[2.0, 2.0, 0.0], [3.0, 3.0, 1.0]]})
    assert play.events.task_pending
    assert play.events.last_waypoint == 0
    play.until(1.0)
    assert play.planner.called("set_goals")[-1] == (((2.0, 2.0, 0.0), (3.0, 3.0, 1.0)),)
    assert play.events.last_waypoint == 1
    assert not play.events.task_pending
    assert play.notes == [(1.0, "new goals: 2")]


def test_a_new_formation(stage: Callable[..., Stage]) -> None:
    play = stage({"at": 1.0, "formation": {"shape": "column", "spacing": 0.9}})
    play.until(1.0)
    ((formation,),) = play.planner.called("set_formation")
    assert len(formation.slots) == 4
    assert play.notes == [(1.0, "new formation: column")]


def test_a_robot_lost_and_back(stage: Callable[..., Stage]) -> None:
    play = stage({"at": 1.0, "lose": 2}, {"at": 2.0, "rejoin": 2})
    play.until(1.0)
    assert play.planner.called("lose") == [(2,)]
    play.fleet.send(np.full((4, 3), 0.1))
    play.fleet.advance(1.0)
    assert play.fleet.true_velocities()[:, 0].round(9).tolist() == pytest.approx(
        play.fleet.true_velocities()[0, 0] * np.array([1, 1, 0, 1]), abs=1e-6
    )
    assert play.events.task_pending
    play.until(2.0)
    assert play.planner.called("rejoin") == [(2,)]
    assert [text for _, text in play.notes] == ["robot 2 lost", "robot 2 back"]


def test_a_policy_that_takes_no_goals_is_not_given_any(
    make_scenario: Callable[..., Scenario],
) -> None:
    class Stubborn:
        status = None

        def step(self, poses: Any, time: float, stamps: Any) -> Any:
            return np.zeros((4, 3))

        def pause(self) -> None: ...

        def resume(self) -> None: ...

    for event in ({"goals": [[2.0, 2.0, 0.0]]}, {"lose": 2}):
        scenario = make_scenario(events=[{"at": 1.0, "add": CIRCLE}, {"at": 2.0, **event}])
        fleet = IdealFleet(scenario.models, scenario.starts)
        supervisor = Supervisor(scenario.models, 0.05)
        control = ControlLoop(Stubborn(), fleet, supervisor)  # type: ignore[arg-type]
        (kind,) = event
        with pytest.raises(ScenarioError, match=rf"execution.events\[1\].{kind}: a Stubborn takes"):
            EventRunner(scenario, build_world(scenario), control)
