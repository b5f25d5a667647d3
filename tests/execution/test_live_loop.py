"""Live fleets: robots that wait for nobody, a guard beside the planner, zeros on every way out."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.execution.control import ControlLoop
from cavalcade.execution.loop import carry_out
from cavalcade.execution.supervisor import Supervision, Supervisor
from cavalcade.fleet import IdealFleet, LiveFleet, Observation
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import robot_model
from cavalcade.scenario import build_world, parse_scenario

GO1 = robot_model("go1")
PERIOD = 0.1
SPEED = 0.3  # of the robots' clock, so that a busy machine makes nobody late


class LiveRobots:
    """Ideal robots in wall time that keep when they were told what."""

    def __init__(self, starts: Any) -> None:
        IdealFleet([GO1], starts[:1]).advance(PERIOD)  # kernels are loaded before time begins
        self._robots = IdealFleet([GO1] * len(starts), starts)
        self._start = time.monotonic()
        self._lock = threading.Lock()
        self._due = 0.0
        self.frozen: float | None = None
        self.log: list[tuple[float, np.ndarray]] = []
        self.started = self.closed = 0

    @property
    def size(self) -> int:
        return self._robots.size

    @property
    def time(self) -> float:
        if self.frozen is not None:
            return self.frozen
        return SPEED * (time.monotonic() - self._start)

    def _catch_up(self) -> None:
        passed = self.time - self._robots.time
        if passed > 1e-6:
            self._robots.advance(passed)

    def observe(self) -> Observation:
        with self._lock:
            self._catch_up()
            return self._robots.observe()

    def send(self, commands: Any) -> None:
        with self._lock:
            self._catch_up()
            self._robots.send(commands)
            self.log.append((self.time, np.array(commands)))

    def advance(self, dt: float) -> None:
        self._due = max(self._due + dt, self.time)
        while self.time < self._due and self.frozen is None:
            time.sleep(0.002)

    def true_poses(self) -> np.ndarray:
        return self.observe().poses

    def true_velocities(self) -> np.ndarray:
        with self._lock:
            return self._robots.true_velocities()

    def start(self, timeout: float) -> None:
        self.started += 1

    def close(self) -> None:
        self.closed += 1

    def silent(self, robot: int) -> None:
        with self._lock:
            self._robots.silence(robot)


class Forwards:
    """A policy that goes ahead and does what it is told in a cycle."""

    def __init__(self, robots: int) -> None:
        self.robots = robots
        self.steps = 0
        self.at: dict[int, Callable[[], None]] = {}

    @property
    def status(self) -> PlannerStatus:
        n = self.robots
        paths = (np.zeros((0, 2)),) * n
        return PlannerStatus(
            state="final", roles=np.arange(n), goals=np.zeros((n, 2)), paths=paths, eta=np.ones(n)
        )

    def step(self, poses: Any, now: float, stamps: Any) -> np.ndarray:
        self.steps += 1
        self.at.get(self.steps, lambda: None)()
        return np.tile([0.2, 0.0, 0.0], (self.robots, 1))

    def pause(self) -> None: ...

    def resume(self) -> None: ...


def team(**allowed: Any) -> tuple[LiveRobots, Forwards, ControlLoop]:
    fleet = LiveRobots([(1.0, 1.0, 0.0), (1.0, 2.0, 0.0)])
    assert isinstance(fleet, LiveFleet)
    policy = Forwards(2)
    loop = ControlLoop(policy, fleet, Supervisor([GO1] * 2, PERIOD, Supervision(**allowed)))
    return fleet, policy, loop


def cycle(loop: ControlLoop) -> np.ndarray:
    planned = loop.plan()
    sent = loop.send(planned.commands, planned)
    loop.fleet.advance(PERIOD)
    return sent


def until(condition: Callable[[], bool], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def test_a_planner_that_does_not_deliver_is_replaced_by_zeros():
    fleet, policy, loop = team()
    late = threading.Event()
    policy.at[3] = lambda: (late.wait(60.0), None)[1]
    with loop:
        planner = threading.Thread(target=lambda: [cycle(loop) for _ in range(6)])
        planner.start()
        until(lambda: policy.steps == 3)
        begin = fleet.time
        until(lambda: bool(fleet.log) and not fleet.log[-1][1].any())
        first = next(at for at, sent in reversed(fleet.log) if sent.any())
        assert [fault.kind for fault in loop.supervisor.cause] == ["deadline"]
        zeros = next(at for at, sent in fleet.log if at > first and not sent.any())
        assert zeros - begin >= PERIOD  # one miss is no reason yet
        late.set()
        planner.join(30.0)
    # What the late planner came to did not leave, and nobody went on by himself.
    assert not any(sent.any() for at, sent in fleet.log if at >= zeros)
    assert loop.supervisor.missed >= 1


def test_a_cycle_that_never_begins_is_noticed_too():
    fleet, _, loop = team()
    with loop:
        planned = loop.plan()
        loop.send(planned.commands, planned)
        until(lambda: loop.supervisor.stopped)
        assert [fault.kind for fault in loop.supervisor.cause] == ["deadline"]
        until(lambda: not fleet.log[-1][1].any())
        assert fleet.log[-1][0] - planned.observation.time >= 3.0 * PERIOD - 1e-3
        loop.resume()
        fleet._due = fleet.time
        assert loop.send(loop.plan().commands).any()


def test_a_clock_that_stands_still_stops_the_team():
    fleet, _, loop = team()
    with loop:
        cycle(loop)
        fleet.frozen = fleet.time
        until(lambda: loop.supervisor.stopped)
        assert loop.supervisor.cause[0].kind == "clock-still"
        until(lambda: not fleet.log[-1][1].any())


@pytest.mark.parametrize(("by", "kind"), [(-5.0, "clock-back"), (5.0, "clock-forward")])
def test_a_clock_that_is_set_stops_the_team(by, kind):
    fleet, _, loop = team()
    with loop:
        cycle(loop)
        fleet.frozen = fleet.time + by
        until(lambda: loop.supervisor.stopped)
        assert loop.supervisor.cause[0].kind == kind


def test_without_a_guard_no_team_is_driven(monkeypatch):
    fleet, _, loop = team()
    sound, failed = LiveRobots.time, []

    def clock(robots):
        if not failed and threading.current_thread().name == "cavalcade-guard":
            failed.append(True)
            raise RuntimeError("there is no clock")
        return sound.fget(robots)

    with loop:
        assert cycle(loop).any()
        monkeypatch.setattr(LiveRobots, "time", property(clock))
        until(lambda: loop.supervisor.stopped)
        cause = loop.supervisor.cause
        assert str(cause[0]) == "guard (RuntimeError: there is no clock)"
        for _ in range(3):
            loop.resume()
            assert not cycle(loop).any()
        assert not fleet.log[-1][1].any()


def test_the_e_stop_acts_at_once_and_between_two_cycles():
    fleet, _, loop = team()
    with loop:
        assert cycle(loop).any()
        planned = loop.plan()
        assert planned.commands.any()
        loop.stop("button")
        assert not fleet.log[-1][1].any()
        assert not loop.send(planned.commands, planned).any()
        loop.resume()
        assert not cycle(loop).any()
        loop.reset_stop()
        assert not cycle(loop).any()
        loop.resume()
        assert cycle(loop).any()


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, ValueError])
def test_zeros_leave_on_every_way_out(error):
    fleet, policy, loop = team()

    def fail() -> None:
        raise error

    policy.at[3] = fail

    def leave() -> None:
        with loop:
            for _ in range(9):
                cycle(loop)

    with pytest.raises(error):
        leave()
    assert any(sent.any() for _, sent in fleet.log)
    assert not fleet.log[-1][1].any()
    assert loop.supervisor.cause[0].kind == "planner"
    count = len(fleet.log)
    assert not loop.send(np.full((2, 3), 0.1)).any()
    assert len(fleet.log) == count + 1
    assert not any(thread.name == "cavalcade-guard" for thread in threading.enumerate())


def test_a_planners_thread_that_ends_without_a_word_leaves_zeros():
    fleet, _, loop = team()

    def plan() -> None:
        loop.__enter__()
        cycle(loop)

    thread = threading.Thread(target=plan)
    thread.start()
    thread.join(30.0)
    until(lambda: loop.supervisor.stopped and not fleet.log[-1][1].any())
    until(lambda: not any(t.name == "cavalcade-guard" for t in threading.enumerate()))
    assert loop.supervisor.cause[0].kind in ("planner", "deadline")


def test_how_well_the_pace_is_kept_is_measured():
    _, _, loop = team()
    with loop:
        for _ in range(8):
            cycle(loop)
    figures = loop.statistics.to_dict(loop.supervisor.missed)
    assert figures["cycles"] == 8
    assert 0.5e3 * PERIOD < figures["period_ms"]["p50"] < 2e3 * PERIOD
    assert figures["jitter_ms"]["p50"] < 1e3 * PERIOD
    assert 0.0 <= figures["cycle_ms"]["p50"] < 1e3 * PERIOD
    assert 0.0 <= figures["pose_age_ms"]["p50"] < 1e3 * PERIOD


def scenario(**execution: Any) -> Any:
    return parse_scenario(
        {
            "version": 1,
            "name": "live",
            "world": {"empty": {"size": [8, 6]}},
            "robots": [{"start": [1.0, 1.0, 0.0]}, {"start": [1.0, 2.0, 0.0]}],
            "task": {"formation": {"shape": "line", "spacing": 1.0}, "goals": [[5.0, 3.0, 0.0]]},
            "execution": {"rate": 10, "timeout": 0.5, **execution},
        }
    )


def test_a_scenario_is_carried_out_by_a_live_fleet():
    said = scenario()
    fleet = LiveRobots(said.starts)
    done = carry_out(said, build_world(said), Forwards(2), fleet)
    assert done.outcome.reason == "timeout"
    assert (fleet.started, fleet.closed) == (1, 1)
    assert not fleet.log[-1][1].any()
    assert not done.recording.commands[-1].any()
    assert any(text.startswith("pace: ") for _, text in done.recording.notes)


def test_what_was_sent_is_recorded_and_a_silent_robot_stops_the_run():
    said = scenario(timeout=20.0)
    fleet = LiveRobots(said.starts)
    policy = Forwards(2)
    policy.at[3] = lambda: fleet.silent(1)
    done = carry_out(said, build_world(said), policy, fleet)
    assert (done.outcome.reason, done.outcome.involved) == ("stopped", (1,))
    assert "stale: robot 1" in done.outcome.detail
    assert fleet.closed == 1


def test_a_fleet_that_cannot_be_reached_is_closed_again():
    said = scenario()
    fleet = LiveRobots(said.starts)

    def fail(timeout: float) -> None:
        raise ConnectionError

    fleet.start = fail  # type: ignore[method-assign]
    with pytest.raises(ConnectionError):
        carry_out(said, build_world(said), Forwards(2), fleet)
    assert fleet.closed == 1
    assert fleet.log == []


PROGRAM = """
import sys
sys.path.insert(0, {here!r})
from test_live_loop import Forwards, LiveRobots, scenario
from cavalcade.execution.loop import carry_out
from cavalcade.execution.supervisor import Supervision
from cavalcade.scenario import build_world
said = scenario(timeout=600.0)
fleet = LiveRobots(said.starts)
policy = Forwards(2)
policy.at[3] = lambda: print("moving", flush=True)
try:
    carry_out(said, build_world(said), policy, fleet, supervision=Supervision(deadline=60.0))
except KeyboardInterrupt:
    moved = any(sent.any() for _, sent in fleet.log)
    print("zeros" if moved and not fleet.log[-1][1].any() else "moving", fleet.closed, flush=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_with_zeros(number):
    program = PROGRAM.format(here=str(Path(__file__).parent))
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "moving\n"
        process.send_signal(number)
        assert process.stdout.readline() == "zeros 1\n"
    assert process.returncode == 0
