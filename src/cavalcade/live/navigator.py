"""A team's navigation, whatever its robots are reached by: goals in, commands out, any thread."""

from __future__ import annotations

import logging
import math
import queue
import threading
import time as wall
from collections.abc import Callable, Sequence, Sized
from dataclasses import replace
from typing import Any, Literal, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from cavalcade.errors import FleetError, InputError
from cavalcade.execution import ControlLoop, Degradable, Supervisor
from cavalcade.execution.arrival import LIVE, ArrivalMonitor
from cavalcade.execution.control import Cycle, tell_sent
from cavalcade.execution.formation_policy import formation_of, settings_of
from cavalcade.execution.individual_navigator import PLANNING, IndividualNavigator
from cavalcade.fleet import DampingFleet, Fault, LiveFleet
from cavalcade.formation import FormationPlanner
from cavalcade.jobs import warming
from cavalcade.jobs.reporter import Reporter
from cavalcade.live.status import Pose, RobotStatus, TeamStatus, pose_or_none
from cavalcade.live.team_file import Team
from cavalcade.recording.frames import Frame, FrameSink
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
"""The threads' ends are waited for so long, s."""


@runtime_checkable
class IndividualPolicy(Degradable, Protocol):
    """A policy for robots with goals of their own, which may change at any time.

    Every method may be called from any thread. While it is paused its `step` lets robots brake
    or stand, and its status says `paused`.
    """

    def set_goal(self, robot: int, pose: Pose | None) -> None:
        """Drive a robot to a pose, or let it stay where it is."""

    def set_map(self, map: OccupancyMap) -> None:
        """Replace the map."""

    def close(self) -> None:
        """End its threads."""


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
            called no more, and the status says so, as it does what a `problem` of theirs says.
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
        self._refused = self._trouble = self._unrecorded = ""
        self._last: tuple[Frame, Cycle] | None = None
        self._begin: float | None = None
        self._arrival, self._arrived = ArrivalMonitor(LIVE), False
        self._figures: tuple[float, dict[str, Any]] = -math.inf, {}
        self._asked = self._done = self._shown = 0  # changes of the task, and which are in effect
        self._changes: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._end, self._first = threading.Event(), threading.Event()
        self._threads: list[threading.Thread] = []
        self._closed = False

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
            if self._threads or self._closed:
                raise InputError("can be started once", key="start")
            self._threads = [
                threading.Thread(target=self._run, name="cavalcade-planner", daemon=True),
                threading.Thread(target=self._work, name="cavalcade-changes", daemon=True),
            ]
        with Reporter(quiet) as reporter:
            warming.warm(kernels_of(self.team), reporter)
        for thread in self._threads:
            thread.start()
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
        self._changes.put(None)
        for thread in self._threads:
            if thread.ident is not None and thread is not threading.current_thread():
                thread.join(_ENDING)
        self._control.close()
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
        if same_map(map, self.map):
            return
        with self._lock:
            self._map = map
            waiting = self._new_map is not None
            self._new_map = map
            if not waiting:  # else the job that waits will find it
                self._later(self._use_map)

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
            self._later(self._stand_up)

    def lose(self, name: str) -> None:
        """Go on without a robot."""
        robot = self._robot(name)
        self._later(lambda: self._count(robot, False))

    def rejoin(self, name: str) -> None:
        """Take a lost robot back."""
        robot = self._robot(name)
        self._later(lambda: self._count(robot, True))

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
            refused, trouble = self._refused, self._trouble or self._unrecorded
            coming, arrived = self._shown != self._asked, self._arrived
            mode: Mode = "formation" if self._wanted is self._formation else "individual"
        names = self.team.names
        now, cause = self._fleet.time, self._supervisor.cause
        if last is None or self._closed:
            robots = tuple(RobotStatus(name) for name in names)
            return TeamStatus("inactive", mode, now, robots, message=trouble, refused=refused)
        frame, cycle = last
        # While the cycle that lets the team go on is not over, it stands as of the last one.
        cause = cause or cycle.report.cause
        lines = tuple(_line(fault, names) for fault in cause)
        planner, lost = frame.status, self._supervisor.lost
        commands = frame.commands if not cause else np.zeros_like(frame.commands)
        robots = tuple(
            RobotStatus(
                name,
                pose_or_none(frame.estimated[k]),
                _age(now, float(cycle.observation.stamps[k])),
                pose_or_none(commands[k]) or (0.0, 0.0, 0.0),
                int(planner.roles[k]),
                own[k],
                k in lost,
                tuple(_line(f, ()) for f in (*cycle.report.faults, *cause) if f.robot == k),
            )
            for k, name in enumerate(names)
        )
        state = _state(planner, bool(goals or any(own)), lines, coming, arrived)
        return TeamStatus(
            state, mode, now, robots, lines, _message(planner, lines, trouble, names), refused,
            goals, planner.waypoint, planner.goal_moved,
            names[planner.leader] if mode == "formation" and planner.leader >= 0 else "",
            self._supervision.dry_run, self._pace(),
        )  # fmt: skip

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

    def _later(self, change: Callable[[], None]) -> None:
        self._changes.put(change)

    def _redirect(self, change: Callable[[], None], note: str) -> None:
        """Let the team get something else to do; until then it has not arrived."""
        self._refused = ""
        self._notes.append(note)
        self._asked += 1
        number = self._asked

        def act() -> None:
            change()
            self._done = number

        self._later(act)

    def _work(self) -> None:
        """The thread in which changes come about that may take longer than a cycle."""
        while (change := self._changes.get()) is not None:
            try:
                change()
            except Exception as error:
                _LOG.exception("a change of the team's task has failed")
                self._failed(f"{type(error).__name__}: {error}")

    def _failed(self, text: str) -> None:
        """Something went wrong that must not: the team stops, and the status says it."""
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
            self._failed(f"the planner's thread has ended: {type(error).__name__}: {error}")
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
            self._failed(f"{type(error).__name__}: {error}")
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
            self._later(lambda robot=robot: self._count(robot, False))  # type: ignore[misc]
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
            done = self._done
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
            lines = ", ".join(_line(fault, self.team.names) for fault in cycle.report.cause)
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
        unrecorded = ""
        for sink in tuple(self._sinks):
            try:
                sink(frame)
                unrecorded = unrecorded or str(getattr(sink, "problem", ""))
            except Exception as error:
                self._sinks.remove(sink)
                _LOG.exception("a sink of frames has failed")
                with self._lock:
                    self._trouble = f"what was recorded ends here: {type(error).__name__}: {error}"
        self._unrecorded = unrecorded and f"not recorded: {unrecorded}"

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


def kernels_of(team: Team) -> list[warming.Needs]:
    """What has to be compiled before a team is driven."""
    found = [warming.Needs("individual", None, live=True)]
    if team.formation is not None:
        found.append(warming.Needs("formation", None, team.planner.variant, moving=True))
    return found


def make_individual(team: Team, map: OccupancyMap) -> IndividualNavigator:
    """The planner of a team's goals of single robots.

    Raises:
        InputError: It refuses the team's values.
    """
    said = team.planner
    settings = replace(
        PLANNING,
        margin=PLANNING.margin if said.margin is None else said.margin,
        constraints=said.constraints or PLANNING.constraints,
        conflict=said.conflict or PLANNING.conflict,
        improve=PLANNING.improve if said.improve is None else said.improve,
        iterations=said.budget.iterations or PLANNING.iterations,
        seconds=said.budget.seconds,
    )
    return IndividualNavigator(team.models, map, team.rate, settings, team.seed)


def make_team_planner(team: Team, map: OccupancyMap) -> FormationPlanner:
    """The planner of a team with a formation, without goals.

    Raises:
        InputError: The planner refuses the team's values, or there is no formation.
    """
    if team.formation is None:
        raise InputError("missing", file=team.file, key="formation")
    try:
        return FormationPlanner(
            map,
            formation_of(team.formation, len(team.robots), team.planner),
            robots=len(team.robots),
            model=max(team.models, key=lambda model: model.length * model.width),
            settings=settings_of(team.planner),
            variant=team.planner.variant,
            rate=team.rate,
            seed=team.seed,
            lookahead=team.planner.lookahead,
            expected=team.expected,
            live=True,
        )
    except InputError as error:
        key = ".".join(part for part in ("planner", error.key) if part)
        raise InputError(error.message, file=team.file, key=key, choices=error.choices) from None


def same_map(one: OccupancyMap, other: OccupancyMap) -> bool:
    """Whether two maps say the same of the same ground."""
    return (
        (one.resolution, one.origin, one.unknown) == (other.resolution, other.origin, other.unknown)
        and one.grid.shape == other.grid.shape
        and np.array_equal(one.occupied, other.occupied)
    )


def _state(
    planner: PlannerStatus, goals: bool, cause: tuple[str, ...], coming: bool, arrived: bool
) -> str:
    if cause:
        return "stopped"
    if planner.state in ("paused", "stale"):
        return planner.state
    if not goals:
        return "idle"
    if coming and planner.state in ("inactive", "final", "stuck", "infeasible"):
        return "partial"  # the planner's state is of what was to be done before
    return "arrived" if arrived else planner.state


def _message(
    planner: PlannerStatus, cause: tuple[str, ...], trouble: str, names: Sequence[str]
) -> str:
    """What happened, and what to do."""
    if cause:
        estop = any(line.startswith("e-stop") for line in cause)
        lift = "call reset_stop, then resume" if estop else "call resume"
        why = "; ".join(cause)
        if trouble and trouble not in why:
            why += f" ({trouble})"
        return f"stopped: {why}. When it is over, {lift}"
    if planner.message and planner.involved:
        who = ", ".join(names[robot] for robot in planner.involved)
        return f"{planner.message} ({who})"
    return planner.message or trouble


def _line(fault: Fault, names: Sequence[str]) -> str:
    who = f": {names[fault.robot]}" if fault.robot is not None and names else ""
    return f"{fault.kind}{who}" + (f" ({fault.detail})" if fault.detail else "")


def _age(now: float, stamp: float) -> float | None:
    return now - stamp if math.isfinite(stamp) and math.isfinite(now) else None


def _poses_in_words(poses: Sequence[Pose]) -> str:
    shown = [f"({x:.2f}, {y:.2f}, {yaw:.2f})" for x, y, yaw in poses[:3]]
    return " ".join(shown) + (f" and {len(poses) - 3} more" if len(poses) > 3 else "")
