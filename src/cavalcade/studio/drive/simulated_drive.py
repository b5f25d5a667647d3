"""A simulated run that is steered from the page, in a thread of its own."""

from __future__ import annotations

import logging
import math
import threading
import time as wall
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cavalcade.errors import CavalcadeError, InputError
from cavalcade.execution import Steering
from cavalcade.execution.real_time import prepare_process
from cavalcade.geometry import Array
from cavalcade.jobs.reporter import Reporter, duration
from cavalcade.jobs.running import run
from cavalcade.jobs.warming import needs_of, warm
from cavalcade.kernels.progress import Compilation, watched
from cavalcade.metrics.summary import Summary
from cavalcade.recording.frames import Frame
from cavalcade.robots import RobotModel
from cavalcade.scenario import (
    ObstacleSpan,
    ResolvedScenario,
    Scenario,
    World,
    build_world,
    obstacle_spans,
    resolve_scenario,
)
from cavalcade.studio.drive.changes import Changes
from cavalcade.studio.drive.drive import Phase, Pose
from cavalcade.studio.snapshot import Snapshot
from cavalcade.world import shape_from_mapping
from cavalcade.world.gaps import body_at, gap_between

_LOG = logging.getLogger(__name__)

LONGEST = 3600.0
"""A drive ends after so long, s, simulated; who drives ends it otherwise."""

_PACE = 2.0
"""How fast it really goes is found over so many seconds."""

_PHASES: Mapping[str, Phase] = {
    "running": "running",
    "paused": "paused",
    "waiting": "waiting",
}


class SimulatedDrive:
    """A run of a scenario that others watch and change on its way.

    Args:
        scenario: Of any backend that simulates; it ends after `LONGEST` at the earliest.
        out: The folder for its results, missing or empty.
        speed: Simulated seconds per second.
        paused: Whether it begins paused.
    """

    live = False

    def __init__(
        self, scenario: Scenario, out: Path, *, speed: float = 1.0, paused: bool = False
    ) -> None:
        execution = scenario.execution
        longer = {"timeout": max(execution.timeout, LONGEST)}
        scenario = scenario.model_copy(update={"execution": execution.model_copy(update=longer)})
        self._given = resolve_scenario(scenario)
        self.world: World = build_world(self._given)
        self.models: tuple[RobotModel, ...] = self._given.models
        self._out = out
        self._steering = Steering(speed, paused)
        self._thread = threading.Thread(target=self._run, name="cavalcade-drive", daemon=True)
        self._newest: tuple[Frame, Array | None] | None = None
        self._goals: tuple[Pose, ...] = self._given.task.goals
        self._spans = self._given, self.world.spans
        self._pace: list[tuple[float, float]] = []
        self._progress = ""
        self._over = self._stopped = False
        self.changes = Changes()
        self.trouble = ""
        self.summary: Summary | None = None
        self.folder: Path | None = None

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self) -> None:
        """End it and wait until it has."""
        self._stopped = True
        self._steering.finish()
        if self._thread.ident is not None:
            self._thread.join()

    # What it does.

    @property
    def phase(self) -> Phase:
        """What it does; `ended` once its results are there."""
        if self._over:
            return "ended"
        found = self._steering.phase
        return "preparing" if found == "new" else _PHASES.get(found, "running")

    @property
    def words(self) -> str:
        """The same for people, with the reason and what to do."""
        phase = self.phase
        if self.trouble:
            return f"Ended: {self.trouble}"
        if phase == "ended" and self.summary is not None:
            return "Ended: " + _reason(self.summary["reason"], self.summary["detail"])
        if self._stopped:
            return "Ending, and writing the results …"
        if phase == "preparing":
            return self._progress or "Preparing …"
        if phase == "waiting":
            text = f"{_reason(self._steering.reason, '')}. Drag the goal to go on, or stop"
            count = self._steering.pending
            said = "1 change comes" if count == 1 else f"{count} changes come"
            return f"{text}; {said} about with the next goal" if count else text
        if phase == "paused":
            return "Paused"
        return self._news or "Running"

    @property
    def _news(self) -> str:
        newest = self._newest
        if newest is None:
            return ""
        status = newest[0].status
        said = {"stuck": "Stuck", "infeasible": "The goal cannot be reached"}.get(status.state, "")
        text = f"{said}: {status.message}" if said and status.message else said or status.message
        if not text and status.goal_moved > 0.0:
            text = (
                f"Running; the goal was moved by {status.goal_moved:.2f} m to where the shape fits"
            )
        return text

    @property
    def scenario(self) -> ResolvedScenario:
        """What is run, with all that has happened."""
        try:
            return self._steering.scenario  # type: ignore[return-value]
        except InputError:
            return self._given

    @property
    def played(self) -> ResolvedScenario:
        """The scenario that gives the same run from a file.

        A run that was stopped by hand ends by its time-out there, at the same time.
        """
        scenario = resolve_scenario(self.scenario)
        if not self._stopped or self._steering.reason in ("arrived", "stuck", "infeasible"):
            return scenario
        time = max(self._steering.time, 1.0 / scenario.execution.rate)
        execution = scenario.execution.model_copy(update={"timeout": round(time, 9)})
        return scenario.model_copy(update={"execution": execution})

    @property
    def time(self) -> float:
        """Simulated, s."""
        return self._steering.time

    @property
    def speed(self) -> float:
        """Simulated seconds per second that are asked for."""
        return self._steering.speed or math.inf

    @property
    def pace(self) -> float | None:
        """Simulated seconds per second that there really were lately; None while it stands."""
        if self.phase != "running":
            self._pace.clear()
            return None
        self._pace.append((wall.monotonic(), self._steering.time))
        while len(self._pace) > 2 and self._pace[-1][0] - self._pace[1][0] > _PACE:
            self._pace.pop(0)
        (begin, first), (end, last) = self._pace[0], self._pace[-1]
        return (last - first) / (end - begin) if end - begin > 0.5 * _PACE else None

    @property
    def refused(self) -> tuple[str, ...]:
        """Why changes that were asked for could not happen any more."""
        return self._steering.refused

    @property
    def planning(self) -> float:
        """How long the newest cycle took, s."""
        newest = self._newest
        return 0.0 if newest is None else newest[0].planning

    @property
    def goals(self) -> tuple[Pose, ...]:
        """Those that are still to be driven to; at the end the last one."""
        newest, goals = self._newest, self._goals
        done = 0 if newest is None else newest[0].status.waypoint
        return goals[min(done, len(goals) - 1) :] if goals else ()

    @property
    def lost(self) -> tuple[int, ...]:
        """Robots that are no part of the team."""
        lost: dict[int, None] = {}
        for event in self.scenario.execution.events:
            if event.at > self._steering.time + 1e-9:
                break
            if event.lose is not None:
                lost[event.lose] = None
            elif event.rejoin is not None:
                lost.pop(event.rejoin, None)
        return tuple(lost)

    @property
    def spans(self) -> tuple[ObstacleSpan, ...]:
        """Every obstacle over time."""
        known, spans = self._spans
        scenario = self.scenario
        if scenario is not known:
            spans = obstacle_spans(scenario)
            self._spans = scenario, spans
        return spans

    def snapshot(self) -> Snapshot | None:
        """The newest moment; None before the first."""
        newest = self._newest
        if newest is None:
            return None
        frame, bodies = newest
        obstacles = [span.obstacle_at(frame.time) for span in self.spans if not span.fixed]
        trunks = joints = None
        if bodies is not None:
            trunks = bodies[:, [0, 1, 2, 4, 5, 6, 3]]
            joints = tuple(bodies[:, 7:])
        return Snapshot(
            frame.time,
            frame.poses,
            frame.commands,
            frame.status,
            trunks,
            joints,
            tuple(found for found in obstacles if found is not None),
            self.lost,
        )

    # What is done to it.

    def pause(self) -> None:
        """Stop the clock."""
        self._check_going()
        self._steering.pause()

    def resume(self) -> None:
        """Let it run."""
        self._check_going()
        self._steering.resume()

    def step(self) -> None:
        """Carry out one cycle, then pause."""
        self._check_going()
        self._steering.step()

    def set_speed(self, speed: float) -> None:
        """Simulated seconds per second."""
        self._steering.speed = speed

    def stop(self) -> None:
        """End it; what was done is kept."""
        self._check_going()
        self._stopped = True
        self._steering.finish()

    def set_goals(self, goals: Sequence[Pose]) -> None:
        """Drive through these poses instead of those so far."""
        told = tuple(tuple(round(float(value), 4) for value in pose) for pose in goals)
        self._submit(goals=told)
        self._goals = told  # type: ignore[assignment]

    def set_formation(self, section: Mapping[str, Any]) -> None:
        """Change the shape."""
        self._submit(formation=dict(section))

    def add(self, obstacle: Mapping[str, Any]) -> None:
        """Put an obstacle down where nobody stands."""
        self._check_free(obstacle)
        self._submit(add=dict(obstacle))

    def remove(self, index: int) -> None:
        """Take an obstacle away."""
        self._submit(remove=self._words_of(index))

    def move(self, index: int, to: tuple[float, float], speed: float) -> None:
        """Let an obstacle go somewhere; with speed 0 it is there at once."""
        said = self._words_of(index)
        if speed > 0.0:
            self._submit(move={**said, "to": list(to), "speed": speed})
            return
        span = self.spans[index]
        x, y = span.obstacle.center
        there = span.obstacle.moved((to[0] - x, to[1] - y)).to_dict()
        self._check_free(there)
        self._submit(remove=said)
        self._submit(add=there)

    def lose(self, robot: int) -> None:
        """Go on without a robot."""
        self._submit(lose=robot)

    def rejoin(self, robot: int) -> None:
        """Take it back."""
        self._submit(rejoin=robot)

    def push(self, robot: int, impulse: tuple[float, float]) -> None:
        """Push a robot, N s."""
        if self._given.execution.backend != "mujoco":
            raise InputError("only robots in physics can be pushed; expected backend mujoco")
        self._submit(push={"robot": robot, "impulse": list(impulse)})

    def _submit(self, **event: Any) -> None:
        self._check_going()
        if self._steering.phase == "new":
            raise InputError("the run has not begun yet; it is being prepared")
        try:
            self._steering.submit(**event)
        except CavalcadeError as error:
            # The file and the event's number in it are not what somebody sees who clicks.
            key = (error.key or "").rpartition("]")[2].lstrip(".")
            raise InputError(error.message, key=key, choices=error.choices) from None

    def _check_going(self) -> None:
        if self._over or self._stopped:
            raise InputError("the run is over; start it again")

    def _check_free(self, obstacle: Mapping[str, Any]) -> None:
        """An obstacle that is put on a robot would throw it over, or be no place to stand at."""
        newest = self._newest
        if newest is None:
            return
        shape = shape_from_mapping(obstacle)
        for robot, (model, pose) in enumerate(zip(self.models, newest[0].poses, strict=True)):
            if gap_between(body_at(model, pose), shape) <= 0.0:
                raise InputError(f"robot {robot} stands there; put it beside")

    def _words_of(self, index: int) -> dict[str, Any]:
        """What an obstacle is called in an event: as it stands or, while it moves, as it was."""
        spans, time = self.spans, self._steering.time
        if not 0 <= index < len(spans) or spans[index].obstacle_at(time) is None:
            raise InputError("this obstacle is not there any more")
        span = spans[index]
        here = span.obstacle_at(time)
        rests = math.hypot(*span.velocity_at(time)) == 0.0
        found = here if rests and here is not None else span.obstacle
        return found.to_dict()

    # The run.

    def _run(self) -> None:
        try:
            needs = needs_of(self._given, self._given.execution.backend)
            warm([needs, replace(needs, moving=True)], _Telling(self._tell))
            prepare_process()
            self._progress = "Planning …" if self._given.goals else "Preparing …"
            result = run(
                self._given, self._out, figures=False, sinks=[self._sink], steering=self._steering
            )
            self.summary, self.folder = result.summary, result.directory
        except CavalcadeError as error:
            self.trouble = str(error)
        except Exception as error:
            _LOG.exception("a drive has failed")
            self.trouble = f"{type(error).__name__}: {error}. This is a fault of Cavalcade's own"
        finally:
            self._over = True
            self.changes.tell()

    def _tell(self, compilation: Compilation) -> None:
        text = f"Compiling (once): {100.0 * compilation.share:.0f} %"
        if compilation.share > 0.0:
            text += f", about {duration(compilation.seconds_left)} left"
        self._progress = text

    def _sink(self, frame: Frame) -> None:
        """In the planner's thread: only keep what there is to see."""
        simulator = getattr(self._steering.fleet, "simulator", None)
        self._newest = frame, None if simulator is None else np.array(simulator.qpos)
        self.changes.tell()


class _Telling(Reporter):
    """Tells of compiling, and of nothing else."""

    def __init__(self, tell: Any) -> None:
        super().__init__(quiet=True)
        self._told = tell

    @contextmanager
    def compiling(
        self, modules: Iterable[str], unused: Iterable[str] = ()
    ) -> Iterator[Compilation]:
        with watched(Compilation(modules, unused, self._told)) as compilation:
            yield compilation


def _reason(reason: str, detail: str) -> str:
    text = {
        "arrived": "Arrived",
        "done": "Done",
        "timeout": "The time is over",
        "stuck": "Stuck",
        "fallen": "A robot has fallen",
        "infeasible": "The goal cannot be reached",
        "budget": "The planner's budget is used up",
        "stopped": "Stopped",
    }.get(reason, reason)
    return f"{text} ({detail})" if detail else text
