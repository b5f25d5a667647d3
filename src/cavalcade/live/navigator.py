"""A team's navigation, whatever its robots are reached by: goals in, commands out, any thread."""

from __future__ import annotations

import logging
import math
import threading
import time as wall
from collections.abc import Callable, Sequence, Sized
from dataclasses import replace
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from cavalcade.errors import FleetError, InputError
from cavalcade.execution import ControlLoop, Degradable, Supervisor
from cavalcade.execution.arrival import LIVE, ArrivalMonitor
from cavalcade.execution.control import Cycle, tell_sent
from cavalcade.execution.formation_policy import formation_of
from cavalcade.fleet import DampingFleet, LiveFleet
from cavalcade.jobs import warming
from cavalcade.jobs.reporter import Reporter
from cavalcade.live.changes import Changes
from cavalcade.live.planners import (
    IndividualPolicy,
    kernels_of,
    make_individual,
    make_team_planner,
)
from cavalcade.live.status import (
    Pose,
    RobotStatus,
    TeamStatus,
    line_of,
    message_of,
    robots_of,
    state_of,
)
from cavalcade.live.team_file import Team
from cavalcade.recording.frames import Frame, FrameSink
from cavalcade.recording.live_writer import LiveRecording
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import FormationSection
from cavalcade.scenario.messages import scenario_error
from cavalcade.scenario.task import check_formation
from cavalcade.values import instance_of, number_array, pose_of
from cavalcade.world import OccupancyMap

_LOG = logging.getLogger(__name__)

Mode = Literal["formation", "individual"]

_FIRST_CYCLE = 10.0
"""The first cycle is waited for so long, s."""

_FIGURES = 2.0
"""Figures of the cycles are found anew this often, s."""

_STANDING_UP = 15.0
"""Robots are given so long to stand up after they were damped, s."""

_ENDING = 5.0
"""The planner's end is waited for so long, s."""


class TeamNavigator:
    """Drives a team to the goals that it is told, in a thread of its own, until it is closed.

    Goals are poses of the formation's centre, or of single robots; whichever came last counts. A
    supervisor watches (see `Supervision`): from the first fault on every command is zero until
    `resume`. Every method may be called from any thread and does not wait for planning; what is
    malformed is refused there and then.

    Use it as a context, or call `close`: the last command is zero. The fleet stays the caller's,
    who has started it and closes it afterwards.

    Args:
        team: Who they are and what they may do.
        fleet: What they are reached by; connected already.
        map: The ground.
        individual: Makes another policy for goals of single robots than `IndividualNavigator`.
        sinks: Called with the `Frame` of each cycle, in the planner's thread. One that raises is
            called no more, and the status says so, as it does what a recording cannot write.
        dry_run: Do everything, but command nobody; so is a team whose file says it.

    Raises:
        InputError: The planner refuses the team's values.
    """

    def __init__(
        self,
        team: Team,
        fleet: LiveFleet,
        *,
        map: OccupancyMap,
        individual: Callable[[Team, OccupancyMap], IndividualPolicy] | None = None,
        sinks: Sequence[FrameSink] = (),
        dry_run: bool = False,
    ) -> None:
        instance_of(team, Team, "team")
        instance_of(map, OccupancyMap, "map")
        if fleet.size != len(team.robots):
            text = f"a fleet of {fleet.size} for a team of {len(team.robots)}"
            raise InputError(text, key="fleet")
        self.team = team
        self._fleet = fleet
        self._period = 1.0 / team.rate
        self._formation = None if team.formation is None else make_team_planner(team, map)
        self._individual = (individual or make_individual)(team, map)
        policy: Degradable = self._formation or self._individual
        self._supervision = team.what_is_allowed(dry_run)
        self._supervisor = Supervisor(
            team.models, self._period, self._supervision, map, team.expected
        )
        self._control = ControlLoop(policy, fleet, self._supervisor)
        self._wanted: Degradable = policy
        self._sinks = list(sinks)
        self._lock = threading.RLock()
        self._map = map
        self._new_map: OccupancyMap | None = None
        self._maps: list[OccupancyMap] = [map]
        self._notes: list[str] = []
        self._goals: tuple[Pose, ...] = ()
        self._own_goals: list[Pose | None] = [None] * fleet.size
        self._paused = self._resuming = False
        self._refused = self._trouble = self._recording = ""
        self._last: tuple[Frame, Cycle] | None = None
        self._begin: float | None = None
        self._arrival, self._arrived = ArrivalMonitor(LIVE), False
        self._figures: tuple[float, dict[str, Any]] = -math.inf, {}
        self._changes = Changes(self._failed)
        self._shown = 0  # of the changes of the task: those that the last cycle knew
        self._end, self._first = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="cavalcade-planner", daemon=True)
        self._started = self._closed = False

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def start(self, quiet: bool = True) -> None:
        """Compile what is needed, then drive; it returns after the first cycle.

        Args:
            quiet: Print no progress of compiling.

        Raises:
            FleetError: No cycle came to an end.
        """
        with self._lock:
            if self._started or self._closed:
                raise InputError("can be started once", key="start")
            self._started = True
        with Reporter(quiet) as reporter:
            warming.warm(kernels_of(self.team), reporter)
        self._thread.start()
        self._changes.start()
        if not self._first.wait(_FIRST_CYCLE):
            self.close()
            raise FleetError(self._trouble or "the first control cycle did not come to an end")

    def close(self) -> None:
        """Command all robots to stop and end; a second call does nothing."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self._supervisor.close()
        self._end.set()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join(_ENDING)
        self._control.close()
        self._changes.close()
        self._individual.close()

    @property
    def map(self) -> OccupancyMap:
        """The map as it was told last."""
        with self._lock:
            return self._map

    def set_formation_goals(self, goals: ArrayLike) -> None:
        """Drive the formation's centre through poses `(G, 3)`; they replace all earlier goals.

        Raises:
            InputError: They are no finite poses, or the team has no formation.
        """
        if isinstance(goals, Sized) and len(goals) == 0:
            raise InputError("expected at least one pose", key="goals")
        poses = number_array(goals, "goals", (None, 3), "poses (x, y, yaw)")
        formation = self._formation
        if formation is None:
            raise InputError(
                "the team has no formation: set one in its file, or goals of single robots",
                key="goals",
            )
        told = tuple((float(x), float(y), float(yaw)) for x, y, yaw in poses)

        def change() -> None:
            formation.set_goals(poses)
            self._choose(formation)

        with self._lock:
            self._goals, self._own_goals = told, [None] * self._fleet.size
            self._redirect(change, f"new goal{'s'[: len(told) - 1]}: {_poses_in_words(told)}")

    def set_robot_goal(self, name: str, goal: Sequence[float] | ArrayLike) -> None:
        """Drive one robot to a pose (x, y, yaw); the others keep their own goals or stay.

        Raises:
            InputError: There is no such robot, or it is no finite pose.
        """
        robot = self._robot(name)
        pose = pose_of(goal, "goal")

        def change() -> None:
            self._individual.set_goal(robot, pose)
            self._choose(self._individual)

        with self._lock:
            self._goals = ()
            self._own_goals[robot] = pose
            self._redirect(change, f"new goal of {name}: {_poses_in_words([pose])}")

    def set_formation(self, section: object) -> None:
        """Change the shape while standing or moving.

        Args:
            section: As `task.formation` of a scenario says it: a `FormationSection` or a mapping.

        Raises:
            InputError: It is no shape that the team can take up.
        """
        planner = self._formation
        if planner is None:
            raise InputError("the team has no formation", key="formation")
        formation = formation_of(self._shape(section), self._fleet.size, self.team.planner)
        planner.set_formation(formation)  # refuses at once; it waits for a cycle at most
        with self._lock:
            self._redirect(lambda: None, f"new formation: {formation.name}")

    def set_map(self, map: OccupancyMap) -> None:
        """Replace the map, while robots stand or move; what is the same already is left out."""
        instance_of(map, OccupancyMap, "map")
        if _same_map(map, self.map):
            return
        with self._lock:
            self._map = map
            waiting = self._new_map is not None
            self._new_map = map
            if not waiting:  # else the job that waits will find it
                self._changes.put(self._use_map)

    def pause(self) -> None:
        """Let all robots brake and stand until `resume`; goals stay."""
        with self._lock:
            self._paused, self._resuming = True, False
            self._notes.append("paused")

    def resume(self) -> None:
        """Go on after `pause` or a stop, from the next cycle on, if that finds all data good.

        If it does not, the request is dropped: nothing starts by itself later.
        """
        with self._lock:
            self._paused, self._resuming = False, True
            self._notes.append("resume")
            if self._supervisor.cause:
                self._supervisor.resume()

    def cancel(self) -> None:
        """Forget all goals; the team brakes and stands."""

        def change() -> None:
            if self._formation is not None:
                self._formation.cancel()
            self._forget_own_goals()

        with self._lock:
            self._goals, self._own_goals = (), [None] * self._fleet.size
            self._redirect(change, "goals cancelled")

    def stop(self, detail: str = "") -> None:
        """The e-stop: zeros leave at once, and nothing else until `reset_stop` and `resume`.

        Robots whose motors can be damped sink to the ground.
        """
        self._control.stop(detail)
        if isinstance(self._fleet, DampingFleet):
            self._fleet.damp()
        with self._lock:
            self._notes.append("e-stop" + (f": {detail}" if detail else ""))

    def reset_stop(self) -> None:
        """Lift the e-stop; the team stands, robots that were damped stand up, until `resume`."""
        with self._lock:
            self._control.reset_stop()
            self._notes.append("e-stop lifted")
        if isinstance(self._fleet, DampingFleet):
            self._changes.put(self._stand_up)

    def lose(self, name: str) -> None:
        """Go on without a robot."""
        robot = self._robot(name)
        self._changes.put(lambda: self._count(robot, False))

    def rejoin(self, name: str) -> None:
        """Take a lost robot back."""
        robot = self._robot(name)
        self._changes.put(lambda: self._count(robot, True))

    def refuse(self, text: str) -> None:
        """Let the status and the recording tell of an input that could not be used."""
        with self._lock:
            self._refused = text
            self._notes.append(f"refused: {text}")
        _LOG.warning("refused: %s", text)

    @property
    def frame(self) -> Frame | None:
        """The last cycle's."""
        last = self._last
        return None if last is None else last[0]

    @property
    def status(self) -> TeamStatus:
        """The team as of the last cycle, and what stopped it since."""
        with self._lock:
            last, goals, own = self._last, self._goals, tuple(self._own_goals)
            refused, trouble, recording = self._refused, self._trouble, self._recording
            coming, arrived = self._shown != self._changes.asked, self._arrived
            mode: Mode = "formation" if self._wanted is self._formation else "individual"
        names = self.team.names
        now, cause = self._fleet.time, self._supervisor.cause
        for sink in tuple(self._sinks):
            if isinstance(sink, LiveRecording):
                recording = recording or sink.problem
        status = TeamStatus(
            "inactive", mode, now, tuple(map(RobotStatus, names)), message=trouble,
            refused=refused, recording=recording, dry_run=self._supervision.dry_run,
        )  # fmt: skip
        if last is None or self._closed:
            return status
        frame, cycle = last
        # While the cycle that lets the team go on is not over, it stands as of the last one.
        cause = cause or cycle.report.cause
        lines = tuple(line_of(fault, names) for fault in cause)
        planner = frame.status
        return replace(
            status,
            state=state_of(planner, bool(goals or any(own)), bool(cause), coming, arrived),
            robots=robots_of(names, frame, cycle, cause, own, self._supervisor.lost, now),
            cause=lines,
            message=message_of(planner, lines, trouble or recording, names),
            goals=goals,
            waypoint=planner.waypoint,
            goal_moved=planner.goal_moved,
            leader=names[planner.leader] if mode == "formation" and planner.leader >= 0 else "",
            pace=self._pace(),
        )

    def _pace(self) -> dict[str, Any]:
        """Figures of the cycles; percentiles of an hour take too long to be found each time."""
        now = wall.monotonic()
        with self._lock:
            known, found = self._figures
            if now - known < _FIGURES:
                return found
            self._figures = now, found
        found = self._control.statistics.to_dict(self._supervisor.missed)
        with self._lock:
            self._figures = now, found
        return found

    def _robot(self, name: str) -> int:
        if name not in self.team.names:
            raise InputError(f"there is no robot {name}", key="robot", choices=self.team.names)
        return self.team.names.index(name)

    def _shape(self, section: object) -> FormationSection:
        """The section, checked against the team."""
        if not isinstance(section, FormationSection):
            try:
                section = FormationSection.model_validate(section)
            except ValidationError as error:
                said = scenario_error(error, FormationSection, None)
                key = ".".join(part for part in ("formation", said.key) if part)
                raise InputError(said.message, key=key, choices=said.choices) from None
        width = min(model.width for model in self.team.models)
        size = self._fleet.size
        left = size - len(self._supervisor.lost)
        try:
            check_formation(section, left, width, accepted=(size,), place="formation")
        except PydanticCustomError as error:
            said_of = error.context or {}
            raise InputError(str(said_of.get("text")), key=str(said_of.get("key"))) from None
        return section

    def _redirect(self, change: Callable[[], None], note: str) -> None:
        """Let the team get something else to do; until then it has not arrived."""
        self._refused = ""
        self._notes.append(note)
        self._changes.put_task(change)

    def _failed(self, error: BaseException, what: str = "") -> None:
        """Something went wrong that must not: the team stops, and the status says it."""
        text = f"{what}{type(error).__name__}: {error}"
        self._supervisor.stop("planner", text)
        with self._lock:
            self._trouble = text

    def _choose(self, policy: Degradable) -> None:
        """Have a policy drive from the next cycle on, and let the other one forget its goals."""
        with self._lock:
            before, self._wanted = self._wanted, policy
        if before is policy:
            return
        if before is self._formation and self._formation is not None:
            self._formation.cancel()
        else:
            self._forget_own_goals()

    def _forget_own_goals(self) -> None:
        for robot in range(self._fleet.size):
            self._individual.set_goal(robot, None)

    def _use_map(self) -> None:
        with self._lock:
            area, self._new_map = self._new_map, None
        if area is None:
            return
        if self._formation is not None:
            self._formation.update_map(area)
        self._individual.set_map(area)
        self._supervisor.area = area
        with self._lock:
            self._maps.append(area)
            size = f"{area.cols} x {area.rows} cells of {area.resolution:g} m"
            self._notes.append(f"new map: {size}")

    def _stand_up(self) -> None:
        """Have robots that were damped stand up again."""
        try:
            self._fleet.start(_STANDING_UP)
        except FleetError as error:
            self.refuse(str(error))

    def _count(self, robot: int, present: bool) -> None:
        """Both policies know who takes part."""
        if present:
            self._supervisor.rejoin(robot)
        else:
            self._supervisor.lose(robot)
        for policy in (self._formation, self._individual):
            if policy is not None and present:
                policy.rejoin(robot)
            elif policy is not None:
                policy.lose(robot)

    def _run(self) -> None:
        """The planner's thread."""
        try:
            with self._control:
                self._begin = self._fleet.time
                while not self._end.is_set() and threading.main_thread().is_alive():
                    self._cycle()
                    self._fleet.advance(self._period)
        except BaseException as error:
            _LOG.exception("the planner's thread has ended")
            self._failed(error, "the planner's thread has ended: ")
        finally:
            self._end.set()

    def _cycle(self) -> None:
        done = self._take_over()
        self._stay_damped()
        try:
            cycle = self._control.plan()
        except Exception as error:
            # The supervisor has stopped the team; an operator may try again.
            _LOG.exception("a control cycle has failed")
            self._failed(error)
            self._control.send(np.zeros((self._fleet.size, 3)))
            self._end.wait(self._period)
            return
        policy, commands = self._control.policy, cycle.commands
        with self._lock:
            paused = self._paused
        if paused and policy.status.state != "paused":
            # It was resumed after a fault, or has just been chosen.
            policy.pause()
            commands = np.zeros_like(commands)
            tell_sent(policy, cycle.commands, commands)
        for robot in cycle.report.unresponsive:
            self._note(f"watchdog: {self.team.names[robot]} does not follow; the others go on")
            self._changes.put(lambda robot=robot: self._count(robot, False))  # type: ignore[misc]
        sent = self._control.send(commands, cycle)
        self._tell(cycle, sent, policy.status, done)
        self._first.set()

    def _stay_damped(self) -> None:
        """While the e-stop holds nobody stands up, also if that was asked for just before it."""
        with self._lock:
            if self._supervisor.pressed and isinstance(self._fleet, DampingFleet):
                self._fleet.damp()

    def _take_over(self) -> int:
        """What was asked for since the last cycle and concerns the loop itself.

        Returns:
            The number of the last change of the task that this cycle is to know.
        """
        control = self._control
        with self._lock:
            done = self._changes.done
            policy, paused = self._wanted, self._paused
            resuming, self._resuming = self._resuming, False
        if policy is not control.policy:
            control.policy.pause()
            control.policy = policy
            policy.resume()
        state = control.policy.status.state
        if paused and state != "paused":
            control.policy.pause()
        elif resuming and not self._supervisor.cause:
            control.policy.resume()
        if resuming:
            with self._lock:
                self._trouble = ""
        return done

    def _tell(self, cycle: Cycle, sent: np.ndarray, status: PlannerStatus, done: int) -> None:
        observation = cycle.observation
        with self._lock:
            notes, self._notes = tuple(self._notes), []
            maps, self._maps = tuple(self._maps), []
            before = self._last
        if cycle.report.cause and (before is None or before[1].report.cause != cycle.report.cause):
            lines = ", ".join(line_of(fault, self.team.names) for fault in cycle.report.cause)
            notes = (*notes, f"watchdog: {lines}")
            _LOG.warning("stopped: %s", lines)
        self._judge_arrival(observation.time, cycle, status, done)
        frame = Frame(
            round(observation.time - (self._begin or 0.0), 9),
            self._fleet.true_poses(),
            observation.poses.copy(),
            sent.copy(),
            replace(status, state="stopped") if cycle.report.cause else status,
            cycle.planning,
            notes,
            maps,
        )
        with self._lock:
            self._last, self._shown = (frame, cycle), done
        for sink in tuple(self._sinks):
            try:
                sink(frame)
            except Exception as error:
                self._sinks.remove(sink)
                _LOG.exception("a sink of frames has failed")
                with self._lock:
                    text = f"what was recorded ends here: {type(error).__name__}: {error}"
                    self._recording = text

    def _judge_arrival(self, now: float, cycle: Cycle, status: PlannerStatus, done: int) -> None:
        """All stand at their goals, turned right, for a while: see `ArrivalMonitor`."""
        driving = status.state == "final" or status.targets is not None
        if done != self._shown or not driving or not cycle.report.ok:
            self._arrival, self._arrived = ArrivalMonitor(LIVE), False
            return
        with self._lock:
            last = max(len(self._goals) - 1, 0)
        poses, velocities = self._fleet.true_poses(), self._fleet.true_velocities()
        self._arrived = self._arrival.update(now, poses, velocities, status, last)

    def _note(self, text: str) -> None:
        with self._lock:
            self._notes.append(text)


def _same_map(one: OccupancyMap, other: OccupancyMap) -> bool:
    """Whether two maps say the same of the same ground."""
    return (
        (one.resolution, one.origin, one.unknown) == (other.resolution, other.origin, other.unknown)
        and one.grid.shape == other.grid.shape
        and np.array_equal(one.occupied, other.occupied)
    )


def _poses_in_words(poses: Sequence[Pose]) -> str:
    shown = [f"({x:.2f}, {y:.2f}, {yaw:.2f})" for x, y, yaw in poses[:3]]
    return " ".join(shown) + (f" and {len(poses) - 3} more" if len(poses) > 3 else "")
