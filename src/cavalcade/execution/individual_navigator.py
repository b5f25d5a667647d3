"""Robots with goals of their own that may change at any time, as live teams have them."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from threading import RLock
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cavalcade.coordination import PlanSettings
from cavalcade.errors import InputError
from cavalcade.execution.arrival import LIVE
from cavalcade.execution.goal_planning import Answer, Goals, Pose, Request, Team, answer, meets
from cavalcade.execution.plan_follower import PlanFollower
from cavalcade.execution.policy import Degradable
from cavalcade.execution.time_scaling import WALKING, FollowSettings
from cavalcade.formation.cycle_clock import LATEST
from cavalcade.geometry import Array, wrap_angle
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import RobotModel, robot_model
from cavalcade.values import instance_of, number_array, number_in, pose_of, whole_number
from cavalcade.world import OccupancyMap, Terrain

_P = ParamSpec("_P")
_T = TypeVar("_T")

PLANNING = PlanSettings(margin=0.05, leaps=False, iterations=100_000)
"""How live teams are planned if nothing else is said: bodies sway, and nobody waits for minutes."""

FOLLOWING = replace(WALKING, quiet=(0.03, 0.08), quiet_heading=(0.04, 0.12))
"""Who stands is not sent about by the noise of a localisation."""

_OFF = (0.3, 0.7)
"""A robot that is farther from where it was sent, m or rad, is off its plan."""

_MOVED = (0.15, 0.35)
"""An obstacle that has moved by more, m or rad, is another one."""

_STANDS = (0.03, 0.05)
"""The mean pose of one that stands changes by less, m and rad, from one half of `_WATCHED` s to the
next."""

_WATCHED = 0.6

_PATIENCE = 3.0
"""Robots that are to come to rest are waited for this long, s; they are where they are then."""

_LAGGING = 3.0
"""A robot that is behind for so long is named, s."""


class AtOnce(Executor):
    """Does work in the cycle that asks for it: for simulated time, which waits for it."""

    def submit(self, fn: Callable[_P, _T], /, *args: _P.args, **kwargs: _P.kwargs) -> Future[_T]:
        """The work, done."""
        future: Future[_T] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@dataclass(frozen=True, eq=False)
class _Ready:
    """An answer, and the number of the last change that it takes into account."""

    number: int
    answer: Answer


class IndividualNavigator(Degradable):
    """Drives robots to goals of their own: planned together, and anew when something changes.

    A goal that comes is planned for with all others. Meanwhile the robots come to rest along their
    present plan, within their limits and in its order, so that it is known from where the new one
    begins; planning takes no longer than braking, as a rule, and always happens beside the cycles
    (see `executor`). Then all follow the new plan as `PlanFollower` does: who lags is waited for
    by those whose turn comes after it. Robots without a goal stay, or step aside and return.

    Where no plan leads to all goals the robots keep the ones that they had, and the status names
    who was refused and why; that goal is tried again with the next change. Robots off their plan
    by more than 0.3 m, lost ones and maps on which the present plan would meet something are
    reasons for a new plan, too.

    Every method may be called from any thread. Same calls, same poses and the same cycle in which
    a plan is ready: same commands.

    Args:
        models: One per robot, by name or as a `RobotModel`.
        map: The ground.
        rate: Cycles per second.
        settings: Of the plans; `PLANNING` if None. They keep to the method `auto`.
        seed: Of all random numbers.
        terrain: Heights on the map's grid; None for flat ground. Nobody leaps.
        executor: Where plans are made; None for a thread of its own, `AtOnce()` for simulated time.

    Raises:
        InputError: An argument of another kind, or a robot without legs on uneven ground.
    """

    def __init__(
        self,
        models: Sequence[RobotModel | str],
        map: OccupancyMap,
        rate: float,
        settings: PlanSettings | None = None,
        seed: int = 0,
        *,
        terrain: Terrain | None = None,
        executor: Executor | None = None,
    ) -> None:
        robots = tuple(robot_model(model) for model in models)
        if not robots:
            raise InputError("expected at least one robot", key="models")
        instance_of(map, OccupancyMap, "map")
        rate = number_in(rate, "rate", 0.1, 1000.0, "Hz")
        settings = PLANNING if settings is None else settings
        instance_of(settings, PlanSettings, "settings")
        if terrain is not None and any(model.legs is None for model in robots):
            raise InputError("uneven ground is for robots with legs", key="models")
        settings = replace(settings, leaps=False)
        seed = whole_number(seed, "seed", 0)
        self._team = Team(robots, terrain, rate, settings, seed, following_of(robots))
        self._size = size = len(robots)
        self._lock = RLock()
        self._own = executor is None
        self._executor = executor or ThreadPoolExecutor(1, "cavalcade-goals")
        self._map = map
        self._asked: list[Pose | None] = [None] * size
        self._agreed: Goals = (None,) * size
        self._latest = list(range(size))
        self._refused: dict[int, str] = {}
        self._lost: set[int] = set()
        # Robots that are on no plan, and where robots were when the last one was asked for.
        self._loose = set(range(size))
        self._anchors: Array | None = None
        self._follower: PlanFollower | None = None
        self._valid = False  # whether the present plan may go on
        self._number = self._answered = 0  # changes that ask for a plan, and which have theirs
        self._job: Future[None] | None = None
        self._ready: _Ready | None = None
        self._rest: Array | None = None  # where robots on their plan come to rest
        self._since = 0.0  # when that began
        self._paused = self._closed = False
        self._seen = _Seen(size, rate)
        self._status = self._make_status(None)

    @property
    def map(self) -> OccupancyMap:
        """The ground, as it was told last."""
        return self._map

    @property
    def status(self) -> PlannerStatus:
        """Of the last cycle.

        `eta` is what robots have before them, s: 0 at the goal, inf while there is no plan for it.
        `arrived` is said when all robots that take part are at the goals that they were told.
        """
        return self._status

    def set_goal(self, robot: int, pose: Sequence[float] | ArrayLike | None) -> None:
        """Drive a robot to a pose x, y, yaw; None: it stays where it is, or comes to rest.

        Raises:
            InputError: There is no such robot, or it is no finite pose.
        """
        robot = self._checked(robot)
        goal = None if pose is None else pose_of(pose, "pose")
        with self._lock:
            if goal == self._asked[robot] and robot not in self._refused:
                return
            self._asked[robot] = goal
            self._latest.remove(robot)
            self._latest.insert(0, robot)
            self._refused.pop(robot, None)
            if robot not in self._lost:
                self._plan_anew()

    def set_map(self, map: OccupancyMap) -> None:
        """Replace the map; a plan that meets what is new on it ends at once."""
        instance_of(map, OccupancyMap, "map")
        with self._lock:
            before, self._map = self._map, map
            follower, ready = self._follower, self._ready
            ways = self._ways(follower)
            coming = self._ways(None if ready is None else ready.answer.follower)
        # Beside the cycles, as it may take longer than one; who plans now looks for himself.
        first = {k: meets(map, self._team.models[k], way[0], before) for k, way in ways.items()}
        changed = any(
            meets(map, self._team.models[k], way[0], before) is not None
            for k, way in coming.items()
        )
        met = {k: at for k, at in first.items() if at is not None}
        with self._lock:
            if met and follower is not None and follower is self._follower:
                self._valid = False
                for robot, at in met.items():
                    if at <= ways[robot][1]:  # braking along the plan would end in it
                        self._drop(follower, robot)
            if met or changed or self._refused:
                self._plan_anew()

    def lose(self, robot: int) -> None:
        """A robot takes no part any more: it is an obstacle wherever it stands."""
        robot = self._checked(robot)
        with self._lock:
            if robot in self._lost:
                return
            self._lost.add(robot)
            self._refused.pop(robot, None)
            self._leave(robot)

    def rejoin(self, robot: int) -> None:
        """It takes part again, and goes on to its goal if it has one."""
        robot = self._checked(robot)
        with self._lock:
            if robot not in self._lost:
                return
            self._lost.remove(robot)
            self._leave(robot)

    def pause(self) -> None:
        """Let all robots come to rest, along their plan and within their limits."""
        with self._lock:
            self._paused = True
            if self._follower is not None:
                self._follower.halt()

    def resume(self) -> None:
        """Go on from rest."""
        with self._lock:
            self._paused = False
            if self._follower is not None and self._rest is None:
                self._follower.release()

    def close(self) -> None:
        """End planning; nobody is told to move any more."""
        with self._lock:
            self._closed = True
        if self._own:
            self._executor.shutdown(wait=False, cancel_futures=True)

    def step(self, poses: ArrayLike, time: float, stamps: ArrayLike | None = None) -> Array:
        """One cycle, which waits for no plan.

        Args:
            poses: `(N, 3)` x, y, yaw of all robots, as last reported.
            time: Now, s, by a clock that advances.
            stamps: `(N,)` when each was measured, s; None for now.

        Returns:
            `(N, 3)` body-frame velocities, m/s, m/s, rad/s.

        Raises:
            InputError: Poses or stamps of the wrong shape, or not finite.
        """
        seen = number_array(poses, "poses", (self._size, 3), f"({self._size}, 3) poses")
        measured = np.full(self._size, float(time))
        if stamps is not None:
            what = f"({self._size},) times in s"
            known = number_array(stamps, "stamps", (self._size,), what, LATEST)
            measured = np.minimum(known, time)
        with self._lock:
            commands = np.zeros((self._size, 3))
            gone_on = self._seen.add(seen, time)
            if not self._closed:
                self._watch(seen, gone_on)
                self._look_after_job()
                self._take_up(time)
                self._begin(time)
                follower = self._follower
                resting = follower is None or (self._paused and bool(follower.at_rest.all()))
                if follower is not None and not resting:
                    commands = follower.step(seen, time, measured)
            self._status = self._make_status(seen)
            return commands

    def _checked(self, robot: int) -> int:
        return whole_number(robot, "robot", 0, self._size - 1)

    @property
    def _pending(self) -> bool:
        return self._number != self._answered

    def _plan_anew(self) -> None:
        self._number += 1
        self._ready = None

    def _drop(self, follower: PlanFollower | None, robot: int) -> None:
        """A robot follows no plan until the next one, and is not commanded."""
        self._loose.add(robot)
        if follower is not None:
            follower.hold(robot)

    def _leave(self, robot: int) -> None:
        """The team that the plan is for has changed."""
        self._drop(self._follower, robot)
        self._valid = False
        if self._follower is not None or self._pending or any(self._asked):
            self._plan_anew()

    def _ways(self, follower: PlanFollower | None) -> dict[int, tuple[Array, int]]:
        """What robots have before them, see `PlanFollower.ahead`; also where others stand."""
        if follower is None:
            return {}
        return {k: follower.ahead(k) for k in range(self._size)}

    def _watch(self, poses: Array, gone_on: bool) -> None:
        """Robots that are not where the plan has them are a reason for another one.

        Unless it has `gone_on` somebody else may have moved them since the last cycle.
        """
        follower = self._follower
        if follower is not None:
            errors = follower.errors if gone_on else follower.references - poses
            errors[:, 2] = wrap_angle(errors[:, 2])
            for robot in np.flatnonzero(_farther(errors, _OFF)).tolist():
                if robot not in self._loose:
                    self._drop(follower, robot)
                    self._valid = False
                    self._plan_anew()
        if self._anchors is None or not self._loose:
            return
        moved = poses - self._anchors
        moved[:, 2] = wrap_angle(moved[:, 2])
        if any(_farther(moved, _MOVED)[robot] for robot in self._loose):
            self._anchors = None  # until a plan is asked for from where they stand
            self._valid = False
            self._plan_anew()

    def _look_after_job(self) -> None:
        """What has failed beside the cycles must not go unseen."""
        job = self._job
        if job is not None and job.done():
            self._job = None
            job.result()

    def _begin(self, time: float) -> None:
        """Have a plan made, if one is needed and it is known where it begins."""
        if not self._pending:
            return
        follower = self._follower
        if follower is not None and self._rest is None:
            self._rest, self._since = follower.halt(), time
        if self._job is not None or self._ready is not None:
            return
        if not all(self._seen.stands(robot) for robot in self._loose):
            return
        starts = self._seen.mean() if self._rest is None else self._rest.copy()
        for robot in self._loose:
            starts[robot] = self._seen.mean()[robot]
        self._anchors = starts
        number = self._number
        request = Request(
            self._map, starts, tuple(self._asked), self._agreed, tuple(self._latest),
            frozenset(self._lost), self._valid, lambda: self._closed or self._number != number,
        )  # fmt: skip
        self._job = self._executor.submit(self._work, request, number)
        self._look_after_job()

    def _work(self, request: Request, number: int) -> None:
        """Beside the cycles: an answer for the map as it is when the answer is there."""
        while True:
            found = answer(self._team, request)
            with self._lock:
                if found is None or number != self._number:
                    return
                before, request = request.map, replace(request, map=self._map)
                if request.map is before:
                    self._ready = _Ready(number, found)
                    return
            ways = self._ways(found.follower)
            hits = (meets(request.map, self._team.models[k], w[0], before) for k, w in ways.items())
            if all(hit is None for hit in hits):
                with self._lock:
                    if request.map is self._map and number == self._number:
                        self._ready = _Ready(number, found)
                        return

    def _take_up(self, time: float) -> None:
        """Let a plan begin that is ready, as soon as everybody stands where it begins."""
        ready, follower = self._ready, self._follower
        if ready is None or self._paused:
            return
        found = ready.answer
        if found.follower is None:
            if follower is not None:
                follower.release()
        else:
            if follower is not None and not follower.at_rest.all():
                if time - self._since > _PATIENCE:
                    for robot in np.flatnonzero(~follower.at_rest).tolist():
                        self._drop(follower, robot)
                    self._valid = False
                    self._plan_anew()
                return
            self._follower, self._agreed = found.follower, found.goals
            self._loose = set(found.fixed)
            self._valid = True
        self._refused = dict(found.refused)
        self._answered = ready.number
        self._ready = self._rest = None

    def _make_status(self, poses: Array | None) -> PlannerStatus:
        follower, size = self._follower, self._size
        places = np.zeros((size, 3)) if poses is None else poses.copy()
        targets, eta = places.copy(), np.zeros(size)
        paths: tuple[Array, ...] = (np.zeros((0, 2)),) * size
        followed = None if follower is None else follower.status
        errors = np.zeros((size, 3)) if follower is None else follower.errors
        late = self._pending
        for robot in range(size):
            goal = self._asked[robot]
            if robot in self._refused:
                goal = self._agreed[robot]
            if robot in self._lost:
                eta[robot] = 0.0 if goal is None else math.inf
            elif goal is None:
                continue
            elif followed is None or goal != self._agreed[robot] or robot in self._loose:
                eta[robot] = math.inf
            else:
                eta[robot] = followed.eta[robot]
            if goal is not None:
                targets[robot] = goal
        if followed is not None:
            assert followed.targets is not None
            paths = tuple(
                paths[k] if k in self._loose else path for k, path in enumerate(followed.paths)
            )
            free = [k for k, model in enumerate(self._team.models) if _turns_freely(model)]
            targets[free, 2] = followed.targets[free, 2]
        driving = [k for k, goal in enumerate(self._asked) if goal and k not in self._lost]
        there = ~_farther(errors, (LIVE.position, LIVE.heading))
        arrived = (
            bool(driving) and not late and not self._refused
            and all(eta[k] <= 0.0 and there[k] for k in driving)
        )  # fmt: skip
        state = "final" if driving else "inactive"
        if driving and late:
            state = "partial"
        elif self._refused and not any(0.0 < eta[k] < math.inf for k in driving):
            state = "infeasible"
        message, involved = self._words(errors)
        return PlannerStatus(
            state="paused" if self._paused else state,
            roles=np.arange(size),
            goals=targets[:, :2].copy(),
            paths=paths,
            eta=eta,
            arrived=arrived,
            involved=involved,
            message=message,
            targets=None if poses is None else targets,
        )

    def _words(self, errors: Array) -> tuple[str, tuple[int, ...]]:
        """What there is to say, and about whom."""
        if self._refused:
            told = [
                f"goal of robot {k} refused: {why}"
                if k not in self._loose
                else f"robot {k} cannot go on: {why}"
                for k, why in sorted(self._refused.items())
            ]
            return "; ".join(told) + "; tried again when something changes", tuple(
                sorted(self._refused)
            )
        if self._pending:
            moving = tuple(k for k in sorted(self._loose) if not self._seen.stands(k))
            if moving:
                names = ", ".join(map(str, moving))
                return f"robot {names}: waited for until it stands, to plan from there", moving
            return "", ()
        behind = self._seen.behind(np.hypot(errors[:, 0], errors[:, 1]) > 0.5 * _OFF[0])
        late = tuple(k for k in behind if k not in self._loose)
        if late and self._follower is not None and not self._paused:
            names = ", ".join(map(str, late))
            return f"robot {names}: does not follow; those whose turn is after it wait", late
        return "", ()


class _Seen:
    """The poses of the last moment: who stands, and where."""

    def __init__(self, size: int, rate: float) -> None:
        self._poses: deque[Array] = deque(maxlen=max(4, round(_WATCHED * rate)))
        self._behind = np.full(size, math.inf)
        self._time = 0.0

    def add(self, poses: Array, time: float) -> bool:
        """Poses `(N, 3)` of a cycle; whether it is the one after the last."""
        gone_on = not self._poses or time - self._time <= _WATCHED
        if not gone_on:
            self._poses.clear()
            self._behind[:] = math.inf
        if self._poses:
            poses = poses.copy()
            poses[:, 2] = self._poses[-1][:, 2] + wrap_angle(poses[:, 2] - self._poses[-1][:, 2])
        self._poses.append(poses)
        self._time = time
        return gone_on

    def stands(self, robot: int) -> bool:
        """Whether it has not gone on lately; not known before it was watched for a while."""
        poses = self._poses
        if len(poses) < (poses.maxlen or 0):
            return False
        track = np.array([pose[robot] for pose in poses])
        half = len(track) // 2
        change = (track[half:].mean(axis=0) - track[:half].mean(axis=0))[None]
        return not bool(_farther(change, _STANDS)[0])

    def mean(self) -> Array:
        """`(N, 3)` mean poses."""
        return np.asarray(np.mean(list(self._poses), axis=0))

    def behind(self, robots: NDArray[np.bool_]) -> list[int]:
        """Those of robots `(N,)` that have been among them for a while."""
        self._behind = np.where(robots, np.minimum(self._behind, self._time), math.inf)
        return np.flatnonzero(self._behind <= self._time - _LAGGING).tolist()


def following_of(models: Sequence[RobotModel]) -> FollowSettings:
    """How robots of these kinds follow live; the limits of legs are for teams that have some."""
    legs = any(model.drive == "legged" for model in models)
    return FOLLOWING if legs else replace(FOLLOWING, limits=None)


def _turns_freely(model: RobotModel) -> bool:
    return model.drive.startswith("integrator")


def _farther(off: Array, most: tuple[float, float]) -> NDArray[np.bool_]:
    """Which of `(K, 3)` are off by more, m or rad."""
    return np.asarray((np.hypot(off[:, 0], off[:, 1]) > most[0]) | (np.abs(off[:, 2]) > most[1]))
