"""Lets the scenario's events happen: on the world, the policy and the fleet."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from cavalcade.errors import ScenarioError
from cavalcade.execution.control import ControlLoop
from cavalcade.execution.formation_policy import formation_of
from cavalcade.execution.policy import Reconfigurable
from cavalcade.execution.steering import TASK_KINDS
from cavalcade.formation import DynamicObstacle
from cavalcade.recording.frames import ObstacleTrack
from cavalcade.scenario import Event, Obstacle, ObstacleSpan, Scenario, World, obstacle_spans
from cavalcade.world import OccupancyMap, shape_from_mapping

_TEAM_KINDS = ("goals", "formation", "lose", "rejoin")
"""Events that a policy must be able to take up."""

_NOTES = {"add": "obstacle added", "remove": "obstacle removed", "move": "obstacle moves"}

MAP_PERIOD = 1.0
"""While an obstacle moves, its map is handed to the recording this often, s."""


class EventRunner:
    """Applies what is due at each cycle.

    An obstacle that moves is rasterised anew whenever it has moved by one cell; the planner is
    also told its shape and velocity.

    Raises:
        ScenarioError: An event is for a policy that can be reconfigured, and this one cannot.
    """

    def __init__(self, scenario: Scenario, world: World, control: ControlLoop) -> None:
        policy = control.policy
        self._team = policy if isinstance(policy, Reconfigurable) else None
        for index, event in enumerate(scenario.execution.events):
            if self._team is None and event.kind in _TEAM_KINDS:
                raise ScenarioError(
                    f"a {type(policy).__name__} takes no new {event.kind} while it runs",
                    file=scenario.file,
                    key=f"execution.events[{index}].{event.kind}",
                )
        self._scenario = scenario
        self._control = control
        self._notes: list[str] = []
        self._world = world
        self._maps = [world.map]
        self._due = list(scenario.execution.events)
        self._goal_count = len(scenario.task.goals)
        self._obstacles = _Obstacles(world)
        self._map_time = 0.0

    def add(self, event: Event, scenario: Scenario) -> None:
        """One more event, of a scenario that has it, too; it is due at once."""
        self._scenario = scenario
        self._due.insert(sum(other.at <= event.at for other in self._due), event)
        spans = obstacle_spans(scenario)
        if spans != self._world.spans:
            self._obstacles.follow(spans)
            self._world = replace(self._world, spans=spans)
            self._tell_fleet("set_world", self._world)

    def news(self) -> tuple[tuple[str, ...], tuple[OccupancyMap, ...]]:
        """What happened since it was asked last, a line each, and each new map for the recording.

        The map at the start is the first of them.
        """
        notes, maps = tuple(self._notes), tuple(self._maps)
        self._notes, self._maps = [], []
        return notes, maps

    @property
    def last_waypoint(self) -> int:
        """Index of the last of the goals that hold now."""
        return self._goal_count - 1

    @property
    def task_pending(self) -> bool:
        """Whether an event is still to come that gives the team something to do."""
        return any(event.kind in TASK_KINDS for event in self._due)

    def change_pending(self, time: float) -> bool:
        """Whether anything at all will still happen, so that a team that is stuck may get free."""
        return bool(self._due) or self._obstacles.change_pending(time)

    def apply(self, time: float) -> bool:
        """Let everything happen that is due at `time` s; True if something did."""
        happened = False
        while self._due and self._due[0].at <= time + 1e-9:
            self._happen(self._due.pop(0))
            happened = True
        changed = self._obstacles.update(time)
        if changed is not None:
            if self._team is not None:
                self._team.update_map(changed)
            resting = not self._obstacles.motion_changed
            if happened or resting or time - self._map_time >= MAP_PERIOD - 1e-9:
                self._maps.append(changed)
                self._map_time = time
        if self._team is not None and self._obstacles.motion_changed:
            self._team.set_dynamic_obstacles(self._obstacles.movers(time))
        return happened

    def tracks(self, end: float) -> tuple[ObstacleTrack, ...]:
        """Every obstacle that came, went or moved until `end` s."""
        return tuple(
            ObstacleTrack(
                shape=span.obstacle.to_dict(),
                start=span.start,
                end=span.end,
                time=np.array(span.time),
                offset=np.array(span.offset).reshape(-1, 2),
            )
            for span in self._obstacles.spans
            if span.start <= end
        )

    def _happen(self, event: Event) -> None:
        team, text = self._team, _NOTES.get(event.kind, str(event.kind))
        if team is not None and event.goals is not None:
            team.set_goals(event.goals)
            self._goal_count = len(event.goals)
            text = f"new goals: {len(event.goals)}" if len(event.goals) > 1 else "new goal"
        elif team is not None and event.formation is not None:
            robots = len(self._scenario.robots)
            team.set_formation(formation_of(event.formation, robots, self._scenario.planner))
            text = f"new formation: {event.formation.shape}"
        elif event.lose is not None:
            self._tell_fleet("disable", event.lose)
            self._control.lose(event.lose)
            text = f"robot {event.lose} lost"
        elif event.rejoin is not None:
            self._tell_fleet("enable", event.rejoin)
            self._control.rejoin(event.rejoin)
            text = f"robot {event.rejoin} back"
        elif event.push is not None:
            push = event.push
            x, y = (part / push.duration for part in push.impulse)
            self._tell_fleet("push", push.robot, (x, y, 0.0), push.duration)
            text = f"robot {push.robot} pushed"
        self._notes.append(text)

    def _tell_fleet(self, what: str, *said: Any) -> None:
        """Let it happen to a simulated robot; a real one fails or is pushed by itself."""
        tell = getattr(self._control.fleet, what, None)
        if tell is not None:
            tell(*said)


class _Obstacles:
    """The obstacles that are not there all the time at one place."""

    def __init__(self, world: World) -> None:
        self.motion_changed = False
        self._world = world
        self._moving: list[Any] = []
        # The first map shows the world's own obstacles; what events bring is still to be drawn.
        self._drawn: list[tuple[float, float] | None] = []
        self.spans: tuple[ObstacleSpan, ...] = ()
        self._take(world.spans, {_name(span) for span in world.spans if span.start == 0.0})

    def follow(self, spans: tuple[ObstacleSpan, ...]) -> None:
        """Take over the spans of all obstacles, which go on from those so far."""
        self._take(spans, {_name(span) for span in self._all if span.fixed})

    def _take(self, spans: tuple[ObstacleSpan, ...], there: set[tuple[Obstacle, float]]) -> None:
        """Those that are on the map already are drawn where they were first, or last."""
        drawn = {_name(span): place for span, place in zip(self.spans, self._drawn, strict=True)}
        self._all = spans
        self.spans = tuple(span for span in spans if not span.fixed)
        self._shapes = [shape_from_mapping(span.obstacle.to_dict()) for span in self.spans]
        self._drawn = [
            drawn.get(name, (0.0, 0.0) if name in there else None)
            for name in map(_name, self.spans)
        ]
        self.__dict__.pop("_still_map", None)

    def update(self, time: float) -> OccupancyMap | None:
        """The new map if it has to be drawn anew, otherwise None."""
        if not self.spans:
            return None
        moving = [
            k
            for k, span in enumerate(self.spans)
            if span.start <= time < span.end and math.hypot(*span.velocity_at(time)) > 0.0
        ]
        self.motion_changed = bool(moving) or bool(self._moving)
        self._moving = moving
        places = self._places(time)
        if not self._changed(places, moving):
            return None
        self._drawn = places
        shapes = [
            shape.moved(place)
            for shape, place in zip(self._shapes, places, strict=True)
            if place is not None
        ]
        return self._still_map.with_shapes(shapes)

    def movers(self, time: float) -> list[Any]:
        """What moves now, as the planner takes it."""
        return [
            DynamicObstacle(
                self._shapes[k].moved(self.spans[k].offset_at(time)),
                self.spans[k].velocity_at(time),
            )
            for k in self._moving
        ]

    def change_pending(self, time: float) -> bool:
        """Whether one of them will still move, come or go."""
        return any(
            time < span.time[-1] or time < span.start or time < span.end < math.inf
            for span in self.spans
        )

    def _places(self, time: float) -> list[tuple[float, float] | None]:
        return [
            span.offset_at(time) if span.start <= time + 1e-9 and time + 1e-9 < span.end else None
            for span in self.spans
        ]

    def _changed(self, places: list[tuple[float, float] | None], moving: list[int]) -> bool:
        cell = self._world.base.resolution
        for k, (old, new) in enumerate(zip(self._drawn, places, strict=True)):
            if (old is None) != (new is None):
                return True
            # One that has come to rest is drawn exactly where it stands.
            least = cell - 1e-9 if k in moving else 1e-9
            if old is not None and new is not None and math.dist(old, new) >= least:
                return True
        return False

    @cached_property
    def _still_map(self) -> OccupancyMap:
        """Fixed ones are rasterised once; the others are added to that map as they stand."""
        fixed = [span.obstacle.to_dict() for span in self._all if span.fixed]
        return self._world.map_with(map(shape_from_mapping, fixed))


def _name(span: ObstacleSpan) -> tuple[Obstacle, float]:
    """What an obstacle is known by while it moves and goes."""
    return span.obstacle, span.start
