"""Carries one scenario out, cycle by cycle, and gives what was recorded. Writes no files."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cavalcade.execution.arrival import ArrivalMonitor, tolerance_of
from cavalcade.execution.command_player import CommandPlayer
from cavalcade.execution.control import ControlLoop, Cycle, Planner
from cavalcade.execution.events import EventRunner
from cavalcade.execution.outcome import Outcome
from cavalcade.execution.progress import Progress, ProgressSink
from cavalcade.execution.team import make_watchdog
from cavalcade.fleet import Fall, FallingFleet, Fleet, LeapingFleet
from cavalcade.recording.frames import Recording
from cavalcade.recording.recorder import Recorder
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import Scenario, World
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


@dataclass(frozen=True)
class Simulated:
    """What a run left in memory.

    Attributes:
        recording: Every cycle.
        maps: (time, map) pairs: the map as it was from then on.
        outcome: How it ended.
    """

    recording: Recording
    maps: tuple[tuple[float, OccupancyMap], ...]
    outcome: Outcome


def simulate(
    scenario: Scenario,
    world: World,
    planner: Planner,
    fleet: Fleet,
    *,
    realtime: bool = False,
    progress: ProgressSink | None = None,
) -> Simulated:
    """Run until the team has arrived or there is a reason not to go on.

    Args:
        scenario: Its events, rate, time-out and budget hold.
        world: Its ground.
        planner: With its goals set.
        fleet: At the starts.
        realtime: Keep the pace of the wall clock; otherwise as fast as possible.
        progress: Called once per cycle.
    """
    started = clock.perf_counter()
    recorder = Recorder()
    watchdog = make_watchdog(scenario, world)
    notes: list[str] = []

    def note(moment: float, text: str) -> None:
        recorder.note(moment, text)
        notes.append(text)

    if isinstance(planner, CommandPlayer) and isinstance(fleet, LeapingFleet):
        planner.leaper = fleet
    with ControlLoop(planner, fleet, watchdog) as control:
        events = EventRunner(scenario, world, control, recorder.map, note)
        judge = _Judge(scenario, events, fleet, note)
        start, period = fleet.time, 1.0 / scenario.execution.rate
        planning: list[float] = []
        while True:
            now = round(fleet.time - start, 9)
            events.apply(now)
            cycle = control.plan()
            planning.append(cycle.planning)
            status = planner.status
            end = judge.end(now, cycle, status)
            commands = cycle.commands if end is None else np.zeros_like(cycle.commands)
            control.send(commands)
            seen = cycle.observation.poses
            recorder.cycle(now, fleet.true_poses(), seen, commands, status)
            if progress is not None:
                text = "; ".join(notes)
                progress(Progress(now, scenario.execution.timeout, status.state, text))
            notes.clear()
            if end is not None:
                break
            fleet.advance(period)
            if realtime:
                clock.sleep(max(0.0, started + fleet.time - start - clock.perf_counter()))
    wall_time = clock.perf_counter() - started
    reason, detail, involved = end
    recording = recorder.recording(events.tracks(now))
    if scenario.execution.backend == "mujoco":
        from cavalcade.execution.physics_collecting import track_of

        recording = replace(recording, physics=track_of(fleet, start))
    return Simulated(
        recording,
        recorder.maps,
        Outcome(
            reason=reason,
            detail=detail,
            involved=involved,
            last_waypoint=events.last_waypoint,
            wall_time=wall_time,
            planning=np.array(planning),
        ),
    )


_End = tuple[str, str, tuple[int, ...]]
"""Reason, detail, robots involved."""


class _Judge:
    """Decides when and why a run ends."""

    def __init__(
        self,
        scenario: Scenario,
        events: EventRunner,
        fleet: Fleet,
        note: Callable[[float, str], None],
    ) -> None:
        self._execution = scenario.execution
        self._budget = scenario.planner.budget
        self._events = events
        self._fleet = fleet
        self._note = note
        self._arrival = ArrivalMonitor(tolerance_of(scenario))
        self._falling = fleet if isinstance(fleet, FallingFleet) else None
        self._stopped: float | None = None
        self._cycles = 0
        self._planning = 0.0

    def end(self, time: float, cycle: Cycle, status: PlannerStatus) -> _End | None:
        self._cycles += 1
        self._planning += cycle.planning
        if self._falling is not None and self._falling.falls:
            return self._end_of_fall(self._falling.falls, self._fleet.time - time)
        if not cycle.report.ok:
            return self._end_of_stop(time, cycle)
        poses, velocities = self._fleet.true_poses(), self._fleet.true_velocities()
        last = self._events.last_waypoint
        arrived = self._arrival.update(time, poses, velocities, status, last)
        if arrived and not self._events.task_pending:
            return "arrived", "", ()
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
            self._note(time, f"watchdog: {text}")
        standing = bool((np.abs(self._fleet.true_velocities()) < _STANDING).all())
        if standing or time - self._stopped >= _LONGEST_STOP:
            return "stopped", f"watchdog: {text}", tuple(fault.robot for fault in cause)
        return None
