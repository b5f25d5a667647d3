"""Carries one scenario out, cycle by cycle, and gives what was recorded."""

from __future__ import annotations

import json
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cavalcade.errors import InputError
from cavalcade.execution.arrival import ArrivalMonitor, tolerance_of
from cavalcade.execution.control import ControlLoop, Cycle
from cavalcade.execution.events import EventRunner
from cavalcade.execution.policy import Policy
from cavalcade.execution.real_time import prepare_process, terminated_as_interrupted
from cavalcade.execution.steering import Steering
from cavalcade.execution.supervisor import Supervision, Supervisor
from cavalcade.fleet import Fall, FallingFleet, Fleet, LiveFleet, SampledFleet
from cavalcade.formation import Imperfections
from cavalcade.geometry import Array
from cavalcade.recording.frames import Frame, FrameSink, Recorder, Recording
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import Scenario, World
from cavalcade.scenario.settings import Budget
from cavalcade.world import OccupancyMap

_STANDING = 1e-3
"""Slower than this is standing still, m/s and rad/s."""

_FALLS = {
    "tilt": "rolled or pitched over",
    "height": "sank to the ground",
    "trunk": "touched the ground with its trunk",
}
"""Causes of falls in words."""

_LONGEST_STOP = 3.0
"""A team that was stopped is waited for this long, s; delayed commands may never reach it."""

_CONNECTING = 30.0
"""Live robots are waited for this long, s."""


_End = tuple[str, str, tuple[int, ...]]
"""Reason, detail, robots involved."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes:
        reason: `arrived`, `done`, `timeout`, `stuck`, `fallen`, `infeasible`, `budget` or
            `stopped`.
        detail: One line about it, empty where there is nothing to add.
        involved: The robots it is about.
        wall_time: Of the whole loop, s.
        planning: `(T,)` s of wall time spent in the policy in each cycle.
    """

    reason: str
    detail: str
    involved: tuple[int, ...]
    wall_time: float
    planning: Array


@dataclass(frozen=True)
class Execution:
    """What carrying out left in memory.

    Attributes:
        recording: Every cycle.
        maps: (time, map) pairs: the map as it was from then on.
        outcome: How it ended.
    """

    recording: Recording
    maps: tuple[tuple[float, OccupancyMap], ...]
    outcome: Outcome


def carry_out(
    scenario: Scenario,
    world: World,
    policy: Policy,
    fleet: Fleet,
    *,
    budget: Budget | None = None,
    realtime: bool = False,
    sinks: Sequence[FrameSink] = (),
    supervision: Supervision | None = None,
    steering: Steering | None = None,
) -> Execution:
    """Run until the team has arrived or there is a reason not to go on. Writes no files.

    However it ends, by Ctrl-C or SIGTERM, too, the last command is zero. Live fleets are
    connected first and closed at the end.

    Args:
        scenario: Its events, rate and time-out hold.
        world: Its ground.
        policy: With its goals set.
        fleet: At the starts.
        budget: Most cycles of the policy and seconds of wall time in it; None for the scenario's.
        realtime: Keep the pace of the wall clock; otherwise as fast as possible.
        sinks: Called with the frame of each cycle.
        supervision: What is allowed to the team; None for the defaults.
        steering: By which others pause the run and change it on its way; not with live fleets.

    Raises:
        ScenarioError: An event asks the policy for what it cannot do.
        InputError: Steering live robots.
        FleetError: Robots of a live fleet were not heard.
    """
    if steering is not None and isinstance(fleet, LiveFleet):
        raise InputError("is for simulated robots, whose clock can be stopped", key="steering")
    supervisor = Supervisor(
        scenario.models,
        1.0 / scenario.execution.rate,
        supervision,
        world.map,
        _imperfections(scenario),
    )
    run = _Run(scenario, world, ControlLoop(policy, fleet, supervisor), realtime, steering)
    budget = budget or scenario.planner.budget
    if not isinstance(fleet, LiveFleet):
        return run.carry_out(budget, sinks)
    with terminated_as_interrupted():
        try:
            prepare_process()
            fleet.start(_CONNECTING)
            return run.carry_out(budget, sinks)
        finally:
            fleet.close()


class _Run:
    """One run of a scenario."""

    def __init__(
        self,
        scenario: Scenario,
        world: World,
        control: ControlLoop,
        realtime: bool,
        steering: Steering | None,
    ) -> None:
        self._scenario = scenario
        self._world = world
        self._control = control
        self._realtime = realtime
        self._steering = steering

    def carry_out(self, budget: Budget, sinks: Sequence[FrameSink]) -> Execution:
        """Cycle by cycle until there is a reason to end."""
        scenario, fleet, steering = self._scenario, self._control.fleet, self._steering
        started = clock.perf_counter()
        recorder = Recorder()
        with self._control as control:
            events = EventRunner(scenario, self._world, control)
            judge = _Judge(scenario, budget, events, fleet)
            start, period = fleet.time, 1.0 / scenario.execution.rate
            planning: list[float] = []
            while True:
                now = round(fleet.time - start, 9)
                if steering is not None:
                    for event in steering.turn(now, period):
                        events.add(event, steering.scenario)
                events.apply(now)
                cycle = control.plan()
                planning.append(cycle.planning)
                status = control.policy.status
                end = judge.end(now, cycle, status)
                if steering is not None:
                    end = _steered(steering, end)
                commands = cycle.commands if end is None else np.zeros_like(cycle.commands)
                commands = control.send(commands, cycle)
                notes, maps = events.news()
                frame = Frame(
                    now,
                    fleet.true_poses(),
                    cycle.observation.poses,
                    commands,
                    status,
                    cycle.planning,
                    (*notes, *judge.news(), *self._last_words(end)),
                    maps,
                )
                recorder(frame)
                for sink in sinks:
                    sink(frame)
                if end is not None:
                    break
                fleet.advance(period)
                if self._realtime and not isinstance(fleet, LiveFleet):
                    clock.sleep(max(0.0, started + fleet.time - start - clock.perf_counter()))
        wall_time = clock.perf_counter() - started
        reason, detail, involved = end
        physics = fleet.track(start) if isinstance(fleet, SampledFleet) else None
        recording = replace(recorder.recording(events.tracks(now)), physics=physics)
        outcome = Outcome(reason, detail, involved, wall_time, np.array(planning))
        return Execution(recording, recorder.maps, outcome)

    def _last_words(self, end: _End | None) -> tuple[str, ...]:
        """How well live robots were kept up with."""
        if end is None or not isinstance(self._control.fleet, LiveFleet):
            return ()
        figures = self._control.statistics.to_dict(self._control.supervisor.missed)
        return (f"pace: {json.dumps(figures)}",)


def _steered(steering: Steering, end: _End | None) -> _End | None:
    """Whether and why the run ends, as those say who steer it."""
    if end is not None:
        return None if steering.goes_on(end[0]) else end
    return ("stopped", "finished by hand", ()) if steering.finishing else None


def _imperfections(scenario: Scenario) -> Imperfections:
    """How well simulated robots are really located and reached."""
    noise, delay = scenario.execution.noise, scenario.execution.delay
    return Imperfections(noise.position, noise.heading, min(delay.mean + 2.0 * delay.jitter, 10.0))


class _Judge:
    """Decides when and why a run ends."""

    def __init__(
        self,
        scenario: Scenario,
        budget: Budget,
        events: EventRunner,
        fleet: Fleet,
    ) -> None:
        self._execution = scenario.execution
        self._budget = budget
        self._events = events
        self._fleet = fleet
        self._notes: list[str] = []
        self._arrival = ArrivalMonitor(tolerance_of(scenario))
        self._falling = fleet if isinstance(fleet, FallingFleet) else None
        self._stopped: float | None = None
        self._unresponsive: list[int] = []
        self._cycles = 0
        self._planning = 0.0

    def news(self) -> tuple[str, ...]:
        """What there is to tell since it was asked last, a line each."""
        notes, self._notes = tuple(self._notes), []
        return notes

    def end(self, time: float, cycle: Cycle, status: PlannerStatus) -> _End | None:
        self._cycles += 1
        self._planning += cycle.planning
        for robot in cycle.report.unresponsive:
            self._unresponsive.append(robot)
            self._notes.append(f"watchdog: unresponsive: robot {robot}; the others go on")
        if self._falling is not None and self._falling.falls:
            return self._end_of_fall(self._falling.falls, self._fleet.time - time)
        if not cycle.report.ok:
            return self._end_of_stop(time, cycle)
        poses, velocities = self._fleet.true_poses(), self._fleet.true_velocities()
        last = self._events.last_waypoint
        arrived = self._arrival.update(time, poses, velocities, status, last)
        if arrived and not self._events.task_pending:
            return self._end_of_way()
        if status.state == "done":
            return "done", "", ()
        if status.state in ("stuck", "infeasible") and not self._events.change_pending(time):
            return status.state, status.message, status.involved
        if time >= self._execution.timeout - 1e-9:
            return "timeout", f"{self._execution.timeout:g} s are over", ()
        if self._budget.iterations is not None and self._cycles >= self._budget.iterations:
            return "budget", f"{self._budget.iterations} planner cycles are used up", ()
        if self._budget.seconds is not None and self._planning >= self._budget.seconds:
            return "budget", f"{self._budget.seconds:g} s of planning are used up", ()
        return None

    def _end_of_way(self) -> _End:
        """Nobody who was to arrive may have been left behind."""
        if not self._unresponsive:
            return "arrived", "", ()
        text = ", ".join(f"unresponsive: robot {robot}" for robot in self._unresponsive)
        return "stopped", f"watchdog: {text}; the others arrived", tuple(self._unresponsive)

    def _end_of_fall(self, falls: tuple[Fall, ...], start: float) -> _End:
        told = [
            f"robot {fall.robot} {_FALLS[fall.cause]} at {fall.time - start:.2f} s"
            for fall in falls
        ]
        return "fallen", ", ".join(told), tuple(fall.robot for fall in falls)

    def _end_of_stop(self, time: float, cycle: Cycle) -> _End | None:
        """Nobody is there to resume a run: it ends as soon as the team stands."""
        cause = cycle.report.cause
        text = ", ".join(str(fault) for fault in cause)
        if self._stopped is None:
            self._stopped = time
            self._notes.append(f"watchdog: {text}")
        standing = bool((np.abs(self._fleet.true_velocities()) < _STANDING).all())
        if standing or time - self._stopped >= _LONGEST_STOP:
            robots = tuple(fault.robot for fault in cause if fault.robot is not None)
            return "stopped", f"watchdog: {text}", robots
        return None
