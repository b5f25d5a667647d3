"""Real robots, or simulated ones of a ROS 2 graph, that are driven from the page."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.errors import CavalcadeError, InputError
from cavalcade.fleet import LiveFleet
from cavalcade.live.navigator import TeamNavigator
from cavalcade.live.session import SessionFolder
from cavalcade.live.status import TeamStatus
from cavalcade.live.team_file import Team, team_of
from cavalcade.metrics.summary import Summary
from cavalcade.recording.frames import Frame
from cavalcade.robots import RobotModel
from cavalcade.scenario import (
    Obstacle,
    ObstacleSpan,
    ResolvedScenario,
    Scenario,
    World,
    build_world,
    resolve_scenario,
)
from cavalcade.studio.drive.changes import Changes
from cavalcade.studio.drive.drive import Phase, Pose
from cavalcade.studio.snapshot import Snapshot
from cavalcade.world import shape_from_mapping

_LOG = logging.getLogger(__name__)

CONNECTING = 30.0
"""Robots are waited for so long, s."""

_PHASES: Mapping[str, Phase] = {
    "paused": "paused",
    "stopped": "stopped",
    "arrived": "waiting",
    "idle": "waiting",
}


class LiveDrive:
    """A team whose robots move in a time of their own, with a supervisor that may stop it.

    Args:
        scenario: The team, its ground and its goals.
        out: The folder for its recording, missing or empty.
        make_fleet: Makes what the team is reached by, not yet started; None: robots `robot_0`,
            `robot_1` and so on of a ROS 2 graph.
    """

    live = True
    refused = ()

    def __init__(
        self,
        scenario: Scenario,
        out: Path,
        make_fleet: Callable[[Team], LiveFleet] | None = None,
    ) -> None:
        if scenario.execution.backend == "unitree" and make_fleet is None:
            raise InputError("Go2s are driven by cavalcade ros2 navigate; expected backend ros2")
        self.scenario: ResolvedScenario = resolve_scenario(scenario)
        self.world: World = build_world(self.scenario)
        self.models: tuple[RobotModel, ...] = self.scenario.models
        self._team = team_of(scenario)
        self._fleet = (make_fleet or _ros2_fleet)(self._team)
        self._session = SessionFolder(self._team, out)
        self._navigator: TeamNavigator | None = None
        self._thread = threading.Thread(target=self._run, name="cavalcade-drive", daemon=True)
        self._end = threading.Event()
        self._lock = threading.RLock()
        self._newest: Frame | None = None
        self._goals: tuple[Pose, ...] = self.scenario.task.goals
        self._spans = list(self.world.spans)
        self._emergency = self._over = False
        self.changes = Changes()
        self.trouble = ""
        self.summary: Summary | None = None
        self.folder: Path | None = None

    def start(self) -> None:
        """Connect, and drive to the scenario's goals."""
        self._thread.start()

    def stop(self) -> None:
        """Let all robots stop, and end."""
        self._check_going()
        self._end.set()

    def close(self) -> None:
        """The same, and wait until it has."""
        self._end.set()
        if self._thread.ident is not None:
            self._thread.join()

    def emergency_stop(self, why: str) -> None:
        """The e-stop: zeros leave at once, and nothing else until `resume`."""
        navigator = self._navigator
        if navigator is None:
            self._end.set()  # nobody is driven yet, and nobody shall be
            return
        navigator.stop(why)
        self._emergency = True

    # What it does.

    @property
    def status(self) -> TeamStatus | None:
        """The team's own; None before it is driven."""
        return None if self._navigator is None else self._navigator.status

    @property
    def phase(self) -> Phase:
        """What it does."""
        status = self.status
        if self._over:
            return "ended"
        if status is None or status.state == "inactive":
            return "preparing"
        return _PHASES.get(status.state, "running")

    @property
    def words(self) -> str:
        """The same for people, with the reason and what to do."""
        status, phase = self.status, self.phase
        if phase == "ended":
            why = f"Ended: {self.trouble}" if self.trouble else "Ended"
            return f"{why}. All robots were commanded to stop"
        if self._end.is_set():
            return "Ending: all robots stop"
        if status is None or phase == "preparing":
            return f"Waiting for {', '.join(self._team.names)} …"
        if phase == "stopped":
            cause = "; ".join(status.cause)
            return f"Stopped: {cause}. When it is over, resume"
        found = {"arrived": "Arrived. Drag the goal to go on", "idle": "No goal"}
        return found.get(status.state, status.message or status.state.capitalize())

    @property
    def goals(self) -> tuple[Pose, ...]:
        """Those that are still to be driven to."""
        newest, goals = self._newest, self._goals
        done = 0 if newest is None else newest.status.waypoint
        return goals[min(done, len(goals) - 1) :] if goals else ()

    @property
    def lost(self) -> tuple[int, ...]:
        """Robots that are no part of the team."""
        status = self.status
        return (
            ()
            if status is None
            else tuple(k for k, robot in enumerate(status.robots) if robot.lost)
        )

    @property
    def spans(self) -> tuple[ObstacleSpan, ...]:
        """Obstacles of the map, and those that were put on it by hand."""
        with self._lock:
            return tuple(self._spans)

    @property
    def planning(self) -> float:
        """How long the newest cycle took, s."""
        return 0.0 if self._newest is None else self._newest.planning

    def snapshot(self) -> Snapshot | None:
        """The newest moment; None before the first."""
        frame = self._newest
        if frame is None:
            return None
        there = [span.obstacle_at(frame.time) for span in self.spans if not span.fixed]
        poses = np.where(np.isfinite(frame.poses), frame.poses, 0.0)
        obstacles = tuple(found for found in there if found is not None)
        return Snapshot(
            frame.time, poses, frame.commands, frame.status, obstacles=obstacles, lost=self.lost
        )

    # What is done to it.

    def pause(self) -> None:
        """Let all robots brake and stand."""
        self._driven().pause()

    def resume(self) -> None:
        """Go on, also after an e-stop."""
        navigator = self._driven()
        if self._emergency:
            self._emergency = False
            navigator.reset_stop()
        navigator.resume()

    def step(self) -> None:
        """Real robots take no single steps."""
        raise InputError("real robots take no single steps")

    def set_speed(self, speed: float) -> None:
        """Real robots have a time of their own."""
        raise InputError("real robots move in a time of their own")

    def set_goals(self, goals: Sequence[Pose]) -> None:
        """Drive through these poses instead of those so far."""
        self._driven().set_formation_goals(goals)
        self._goals = tuple(goals)

    def set_formation(self, section: Mapping[str, Any]) -> None:
        """Change the shape."""
        self._driven().set_formation(dict(section))

    def add(self, obstacle: Mapping[str, Any]) -> None:
        """Put an obstacle on the map."""
        navigator, now = self._driven(), self._time
        found = Obstacle.model_validate(dict(obstacle))
        shape_from_mapping(found.to_dict())
        with self._lock:
            self._spans.append(ObstacleSpan(found, now, time=(now,)))
            navigator.set_map(self._map())

    def remove(self, index: int) -> None:
        """Take an obstacle off the map; it may be real."""
        navigator = self._driven()
        with self._lock:
            if not 0 <= index < len(self._spans):
                raise InputError("this obstacle is not there any more")
            self._spans[index] = replace(self._spans[index], end=self._time)
            navigator.set_map(self._map())

    def move(self, index: int, to: tuple[float, float], speed: float) -> None:
        """Put an obstacle of the map elsewhere."""
        here = self.spans[index].obstacle
        x, y = here.center
        self.remove(index)
        self.add(here.moved((to[0] - x, to[1] - y)).to_dict())

    def lose(self, robot: int) -> None:
        """Go on without a robot."""
        if robot in self.lost:
            raise InputError(f"robot {robot} is lost already")
        self._driven().lose(self._team.names[robot])

    def rejoin(self, robot: int) -> None:
        """Take it back."""
        if robot not in self.lost:
            raise InputError(f"robot {robot} is not lost")
        self._driven().rejoin(self._team.names[robot])

    def push(self, robot: int, impulse: tuple[float, float]) -> None:
        """Real robots are pushed by hand."""
        raise InputError("only robots in physics can be pushed from here")

    @property
    def _time(self) -> float:
        return 0.0 if self._newest is None else max(self._newest.time, 1e-9)

    def _map(self) -> Any:
        now = self._time
        shapes = [span.obstacle for span in self._spans if span.start <= now < span.end]
        return self.world.map_with([shape_from_mapping(shape.to_dict()) for shape in shapes])

    def _driven(self) -> TeamNavigator:
        self._check_going()
        if self._navigator is None:
            raise InputError("the robots have not been heard yet")
        return self._navigator

    def _check_going(self) -> None:
        if self._over or self._end.is_set():
            raise InputError("the drive is over; start it again")

    # The session.

    def _run(self) -> None:
        try:
            self._fleet.start(CONNECTING)
            if not self._end.is_set():
                self._drive()
        except CavalcadeError as error:
            self.trouble = str(error)
        except Exception as error:
            _LOG.exception("a live drive has failed")
            self.trouble = f"{type(error).__name__}: {error}. This is a fault of Cavalcade's own"
        finally:
            self._finish()

    def _drive(self) -> None:
        recording = self._session.begin(self.world.map, self._fleet.true_poses())
        navigator = TeamNavigator(
            self._team, self._fleet, map=self.world.map, sinks=[recording, self._sink]
        )
        with navigator:
            if self.scenario.goals:
                for name, goal in zip(self._team.names, self.scenario.goals, strict=True):
                    navigator.set_robot_goal(name, goal)
            elif self._goals:
                navigator.set_formation_goals(self._goals)
            self._navigator = navigator
            self._end.wait()

    def _finish(self) -> None:
        """However it has ended, robots are told to stop."""
        try:
            self._fleet.close()
            result = self._session.finish()
            if result is not None:
                self.summary, self.folder = result.summary, result.directory
        except CavalcadeError as error:
            self.trouble = self.trouble or str(error)
        except Exception as error:
            _LOG.exception("the results of a live drive cannot be made")
            self.trouble = self.trouble or f"{type(error).__name__}: {error}"
        finally:
            self._over = True
            self.changes.tell()

    def _sink(self, frame: Frame) -> None:
        """In the planner's thread: only keep what there is to see."""
        self._newest = frame
        self.changes.tell()


def _ros2_fleet(team: Team) -> LiveFleet:
    from cavalcade.fleet.ros2 import Ros2Fleet

    return Ros2Fleet(team.ros2_robots(), name="cavalcade_studio", use_sim_time=team.use_sim_time)
