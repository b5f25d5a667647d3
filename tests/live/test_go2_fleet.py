"""Go2s that are none, each in a DDS domain of its own, and the fleet that drives them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cavalcade as cv
from cavalcade.errors import FleetError
from cavalcade.execution.control import ControlLoop
from cavalcade.execution.supervisor import Supervisor
from cavalcade.fleet import Fault, LiveFleet
from cavalcade.fleet.unitree import Go2Fleet, Go2Link
from cavalcade.fleet.unitree.sport import Api
from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import robot_model

Mocks = Callable[..., tuple[int, Any]]
Wait = Callable[[Callable[[], Any]], Any]

STOP_WITHIN = 0.6
"""From the last word of a fleet until its robots have heard a stop, s."""


@contextmanager
def fleet_of(*domains: int, **options: Any) -> Iterator[Go2Fleet]:
    links = [Go2Link(domain, "lo") for domain in domains]
    options.setdefault("starts", [(0.0, float(k), 0.0) for k in range(len(links))])
    fleet = Go2Fleet(links, **options)
    try:
        yield fleet
    finally:
        fleet.close()


def drive(fleet: Go2Fleet, *commands: tuple[float, float, float]) -> None:
    """One cycle."""
    fleet.send(commands)
    fleet.advance(0.05)


def kinds(fleet: Go2Fleet) -> list[tuple[int | None, str]]:
    return [(fault.robot, fault.kind) for fault in fleet.observe().faults]


def test_robots_stand_up_are_driven_from_their_starts_and_stopped_at_the_end(
    mocks: Mocks, until: Wait
) -> None:
    places = [mocks("--start", str(9 + k), "0", "1") for k in range(2)]
    with fleet_of(*(domain for domain, _ in places), starts=[(1, 2, 0.5), (3, 4, -2)]) as fleet:
        assert isinstance(fleet, LiveFleet)
        fleet.start(60.0)
        seen = fleet.observe()
        assert seen.poses == pytest.approx(np.array([(1, 2, 0.5), (3, 4, -2)]), abs=1e-5)
        assert (seen.time - seen.stamps < 0.5).all()
        assert seen.faults == ()

        def moved() -> bool:
            drive(fleet, (0.5, 0.0, 0.0), (0.0, 0.0, 0.0))
            fleet.observe()
            return bool(fleet.true_velocities()[0, 0] > 0.3)

        until(moved)
        x, y, _ = fleet.observe().poses[0]
        assert (y - 2) / (x - 1) == pytest.approx(np.tan(0.5), rel=1e-3)
        assert fleet.observe().poses[1] == pytest.approx((3, 4, -2), abs=1e-5)
    fleet.close()
    fleet.send([(0.5, 0.0, 0.0)] * 2)
    for _, mock in places:
        rising = [Api.STAND_UP, Api.BALANCE_STAND]
        assert [api for api in mock.calls if api != Api.STOP_MOVE] == [*rising, Api.MOVE]
        assert mock.calls[-1] == Api.STOP_MOVE


def test_commands_are_streamed_at_50_hz(mocks: Mocks, until: Wait) -> None:
    domain, mock = mocks()
    with fleet_of(domain) as fleet:
        fleet.start(60.0)
        until(lambda: drive(fleet, (0.2, 0.0, 0.1)) or len(mock.asked(Api.MOVE)) > 100)
        assert np.median(np.diff(mock.asked(Api.MOVE))) == pytest.approx(0.02, abs=0.005)
        assert mock.requests[-1]["v"] == [0.2, 0.0, 0.1]


def test_robots_lie_down_at_the_end_where_that_is_asked_for(mocks: Mocks) -> None:
    domain, mock = mocks()
    with fleet_of(domain, lie_down=True) as fleet:
        fleet.start(60.0)
        drive(fleet, (0.3, 0.0, 0.0))
    assert mock.calls[-2:] == [Api.STOP_MOVE, Api.STAND_DOWN]
    assert mock.states[-1]["is"] == "lying"


def test_a_fleet_that_says_nothing_has_its_robots_stopped(mocks: Mocks, until: Wait) -> None:
    domain, mock = mocks()
    with fleet_of(domain) as fleet:
        fleet.start(60.0)
        until(lambda: drive(fleet, (0.4, 0.0, 0.0)) or mock.states[-1]["v"][0] > 0.3)
        last = time.time()
        until(lambda: mock.asked(Api.STOP_MOVE, last))
        assert mock.asked(Api.STOP_MOVE, last)[0] - last <= STOP_WITHIN
        until(lambda: abs(mock.states[-1]["v"][0]) < 0.01)
        # Nothing is wrong with it: it goes on when the fleet does.
        until(lambda: drive(fleet, (0.4, 0.0, 0.0)) or mock.states[-1]["v"][0] > 0.3)


@pytest.mark.parametrize("damp", [False, True])
def test_robots_of_a_fleet_that_was_killed_are_stopped(
    mocks: Mocks, until: Wait, damp: bool
) -> None:
    places = [mocks() for _ in range(2)]
    peer = Path(__file__).parent / "peers" / "go2_fleet.py"
    arguments = [str(domain) for domain, _ in places] + ["--damp"] * damp
    process = subprocess.Popen([sys.executable, "-P", str(peer), *arguments])
    try:
        until(lambda: all(mock.states and mock.states[-1]["v"][0] > 0.3 for _, mock in places))
    finally:
        killed = time.time()
        process.send_signal(signal.SIGKILL)
        process.wait()
    for _, mock in places:
        until(lambda mock=mock: mock.asked(Api.STOP_MOVE, killed))
        assert mock.asked(Api.STOP_MOVE, killed)[0] - killed <= STOP_WITHIN
        until(lambda mock=mock: abs(mock.states[-1]["v"][0]) < 0.01)
        if damp:
            until(lambda mock=mock: mock.states[-1]["is"] == "damping")
        assert not [e for e in mock.requests if e["t"] > killed + STOP_WITHIN and any(e["v"])]


def test_a_robot_that_refuses_is_named_with_the_code(mocks: Mocks, until: Wait) -> None:
    domain, mock = mocks()
    with fleet_of(domain) as fleet:
        fleet.connect(60.0)
        mock.command("refuse 1004 4202")
        with pytest.raises(FleetError, match=r"robot 0 .*StandUp: code 4202, .*not initialised"):
            fleet.start(60.0)
        mock.command("refuse 1004 0")
        fleet.start(60.0)
        mock.command("refuse 1008 3205")
        until(lambda: drive(fleet, (0.1, 0.0, 0.0)) or kinds(fleet) == [(0, "api-error")])
        assert "Move: code 3205, another program" in fleet.observe().faults[0].detail
        mock.command("refuse 1008 0")
        until(lambda: drive(fleet, (0.0, 0.0, 0.0)) or not kinds(fleet))
        mock.command("mute")
        until(lambda: drive(fleet, (0.0, 0.0, 0.0)) or kinds(fleet) == [(0, "api-error")])
        assert "no answer in time" in fleet.observe().faults[0].detail


def test_an_e_stop_damps_and_nothing_moves_until_started_again(mocks: Mocks, until: Wait) -> None:
    domain, mock = mocks()
    with fleet_of(domain) as fleet:
        fleet.start(60.0)
        until(lambda: drive(fleet, (0.4, 0.0, 0.0)) or mock.states[-1]["v"][0] > 0.3)
        pressed = time.time()
        fleet.damp()
        assert kinds(fleet) == [(0, "damping")]
        until(lambda: drive(fleet, (0.4, 0.0, 0.0)) or mock.states[-1]["is"] == "damping")
        assert mock.asked(Api.DAMP, pressed)[0] - pressed <= 0.2
        assert not mock.asked(Api.MOVE, pressed + 0.2)
        fleet.start(60.0)
        assert fleet.observe().faults == ()
        until(lambda: drive(fleet, (0.4, 0.0, 0.0)) or mock.states[-1]["v"][0] > 0.3)


def test_low_batteries_and_fallen_robots_are_faults_and_do_not_stand_up(
    mocks: Mocks, until: Wait
) -> None:
    (first, low), (second, other) = mocks(), mocks()
    with fleet_of(first, second) as fleet:
        fleet.start(60.0)
        low.command("battery 12")
        until(lambda: drive(fleet, *[(0.0, 0.0, 0.0)] * 2) or kinds(fleet) == [(0, "battery-low")])
        assert fleet.observe().faults[0].detail == "12 %, 20 % are asked for"
        other.command("fall")
        until(lambda: drive(fleet, *[(0.0, 0.0, 0.0)] * 2) or (1, "fallen") in kinds(fleet))
        with pytest.raises(FleetError, match=r"battery-low: robot 0.*fallen: robot 1"):
            fleet.start(60.0)


def test_a_robot_whose_motors_somebody_damped_is_a_fault(mocks: Mocks, until: Wait) -> None:
    from cavalcade.fleet.unitree.client import SportClient
    from cavalcade.fleet.unitree.sdk import Network

    domain, _ = mocks()
    with fleet_of(domain) as fleet:
        fleet.start(60.0)
        remote = SportClient(Network(domain, "lo"))

        def damped() -> bool:
            drive(fleet, (0.0, 0.0, 0.0))
            remote.ask(Api.DAMP, time.monotonic())
            return kinds(fleet) == [(0, "damping")]

        until(damped)


def test_a_second_commander_is_a_fault_as_long_as_it_is_there(mocks: Mocks, until: Wait) -> None:
    from cavalcade.fleet.unitree.client import SportClient
    from cavalcade.fleet.unitree.sdk import Network

    domain, _ = mocks()
    with fleet_of(domain) as fleet:
        fleet.start(60.0)
        other = SportClient(Network(domain, "lo"))

        def noticed() -> bool:
            drive(fleet, (0.0, 0.0, 0.0))
            other.move(0.1, 0.0, 0.0, time.monotonic(), answered=False)
            return kinds(fleet) == [(0, "second-commander")]

        until(noticed)
        until(lambda: drive(fleet, (0.0, 0.0, 0.0)) or not kinds(fleet))


def test_who_is_not_there_is_named(mocks: Mocks) -> None:
    domain, _ = mocks()
    with (
        fleet_of(domain, 231) as fleet,
        pytest.raises(FleetError, match=r"^robot 1: nothing was heard .* domain 231 on lo"),
    ):
        fleet.connect(5.0)
    missing = Go2Fleet([Go2Link(domain, "no-such-card", offset=(0.0, 0.0, 0.0))])
    with pytest.raises(FleetError, match=r"robot 0: .*'no-such-card'"):
        missing.connect(10.0)
    missing.close()


def test_a_helper_that_was_killed_is_a_fault(mocks: Mocks, until: Wait) -> None:
    domain, _ = mocks()
    with fleet_of(domain) as fleet:
        fleet.start(60.0)
        (helper,) = helpers_of(os.getpid())
        os.kill(helper, signal.SIGKILL)
        until(lambda: drive(fleet, (0.0, 0.0, 0.0)) or kinds(fleet) == [(0, "helper")])


def helpers_of(parent: int) -> list[int]:
    """The helper processes of a process."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                command = (entry / "cmdline").read_text().split("\0")
                above = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except OSError:
                continue
            if above == parent and "cavalcade.fleet.unitree.helper_process" in command:
                found.append(int(entry.name))
    return found


def test_poses_may_come_from_somebody_who_sees_the_robots(mocks: Mocks, until: Wait) -> None:
    domain, _ = mocks("--drift", "0.5")
    fleet = Go2Fleet([Go2Link(domain, "lo", "external")])
    try:
        with pytest.raises(FleetError, match="no pose was handed in"):
            fleet.connect(5.0)
        assert np.isnan(fleet.observe().poses).all()
        fleet.set_pose(0, (1.0, 2.0, 0.5))
        fleet.start(60.0)
        stamp = fleet.time
        fleet.set_pose(0, (1.5, 2.0, 0.5), stamp)
        fleet.set_pose(0, (9.0, 9.0, 0.5), stamp - 0.1)  # overtaken on its way
        seen = fleet.observe()
        assert seen.poses.tolist() == [[1.5, 2.0, 0.5]]
        assert seen.stamps.tolist() == [stamp]
        fleet.set_pose(0, (np.nan, np.nan, np.nan))
        assert np.isnan(fleet.observe().poses).all()
        assert np.isfinite(fleet.true_poses()).all()
    finally:
        fleet.close()


class Onward:
    """A policy that goes ahead."""

    def __init__(self, count: int) -> None:
        self._count = count

    @property
    def status(self) -> PlannerStatus:
        return PlannerStatus(
            state="final",
            roles=np.full(self._count, -1),
            goals=np.zeros((self._count, 2)),
            paths=(np.empty((0, 2)),) * self._count,
            eta=np.zeros(self._count),
        )

    def step(self, *_: Any) -> Any:
        return np.tile((0.3, 0.0, 0.0), (self._count, 1))

    def pause(self) -> None: ...

    def resume(self) -> None: ...


@pytest.mark.parametrize(
    ("line", "fault"),
    [("battery 5", "battery-low"), ("refuse 1008 4201", "api-error"), ("fall", "fallen")],
)
def test_a_fault_of_one_robot_stops_all_until_somebody_resumes(
    mocks: Mocks, until: Wait, line: str, fault: str
) -> None:
    (first, one), (second, other) = mocks(), mocks()
    with fleet_of(first, second) as fleet:
        fleet.start(60.0)
        supervisor = Supervisor([robot_model("go2")] * 2, 0.05)
        with ControlLoop(Onward(2), fleet, supervisor) as control:

            def cycle() -> tuple[Fault, ...]:
                planned = control.plan()
                control.send(planned.commands, planned)
                fleet.advance(0.05)
                return planned.report.cause

            until(lambda: cycle() == () and other.states[-1]["v"][0] > 0.2)
            one.command(line)
            until(lambda: fault in [cause.kind for cause in cycle()])
            told = time.time()
            until(lambda: cycle() and abs(other.states[-1]["v"][0]) < 0.01)
            after = [e for e in other.requests if e["t"] > told + 0.1 and e["api"] == Api.MOVE]
            assert not any(any(e["v"]) for e in after)


SCENARIO = """
version: 1
name: two-go2
world: {empty: {size: [6.0, 4.0]}}
robots:
  - {model: go2, start: [1.0, 1.5, 0.0]%s}
  - {model: go2, start: [1.0, 2.5, 0.0]%s}
task: %s
execution:
  timeout: 60
  backend: unitree
  unitree: {robots: [{domain: %d, interface: lo}, {domain: %d, interface: lo}]}
"""

FORMATION = ("", "", "{formation: {shape: line, spacing: 1.0}, goals: [[3.5, 2.0, 0.0]]}")
GOALS = (", goal: [3.5, 2.5, 0.0]", ", goal: [3.5, 1.5, 0.0]", "{goals: individual}")


@pytest.mark.slow
@pytest.mark.parametrize("task", [FORMATION, GOALS], ids=["formation", "goals"])
def test_two_go2s_arrive(mocks: Mocks, tmp_path: Path, task: tuple[str, str, str]) -> None:
    imperfect = ("--latency", "0.05", "--loss", "0.05", "--drift", "0.01")
    domains = [mocks(*imperfect, "--seed", str(k))[0] for k in range(2)]
    file = tmp_path / "scenario.yaml"
    file.write_text(SCENARIO % (*task, *domains))
    result = cv.run(file, tmp_path / "out", figures=False, replay=False)
    assert result.reason == "arrived", result.summary.detail
    assert not any(result.summary.to_dict()["collisions"].values())
