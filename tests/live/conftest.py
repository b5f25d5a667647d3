"""Graphs of their own for tests that need ROS 2, and the processes that meet there."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

PEERS = Path(__file__).parent / "peers"
sys.path.insert(0, str(Path(__file__).parent))  # for what tests here share
PATIENCE = 90.0
"""A generous limit for what must happen, s."""


class Peer:
    """A process on the graph, which says what it hears as JSON lines."""

    def __init__(self, command: list[str], log: Path) -> None:
        self._log = log
        with log.open("w") as out:
            self.process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=out, stderr=subprocess.STDOUT, text=True
            )

    def tell(self, **change: Any) -> float:
        """Make it misbehave; since when it does, s of the wall's time."""
        before = len(told := self._told)
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps(change) + "\n")
        self.process.stdin.flush()
        end = time.monotonic() + PATIENCE
        while len(told := self._told) == before:
            assert time.monotonic() < end, "it does not listen"
            time.sleep(0.005)
        return float(told[-1]["time"])

    @property
    def _told(self) -> list[dict[str, Any]]:
        return [entry for entry in self.heard if "told" in entry]

    @property
    def text(self) -> str:
        return self._log.read_text()

    @property
    def heard(self) -> list[dict[str, Any]]:
        lines = self.text.splitlines(keepends=True)
        return [json.loads(line) for line in lines if line.startswith("{") and line.endswith("\n")]

    def end(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        assert self.process.stdin is not None
        self.process.stdin.close()


@pytest.fixture
def graph(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> Iterator[Callable[..., Peer]]:
    """Starts processes on a graph that no other test is on: `graph("robot.py", ...)` for a peer,
    `graph("cavalcade", ...)` for a command of ours; in a `namespace` of the network."""
    from cavalcade.errors import InputError
    from cavalcade.fleet.ros2 import load_rclpy

    try:
        load_rclpy()
    except InputError as error:
        pytest.skip(str(error))
    domain = 1 + hash((os.getpid(), request.node.nodeid)) % 100
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    started: list[Peer] = []

    def start(what: str, *arguments: str, namespace: str = "") -> Peer:
        within = ["ip", "netns", "exec", namespace] if namespace else []
        code = ["-m", "cavalcade"] if what == "cavalcade" else [str(PEERS / what)]
        log = tmp_path / f"{len(started)}.log"
        started.append(Peer([*within, sys.executable, *code, *arguments], log))
        return started[-1]

    yield start
    for peer in started:
        peer.end()


@pytest.fixture
def until() -> Callable[[Callable[[], Any]], Any]:
    """Waits until something holds, and gives it; fails after a generous time."""

    def wait(condition: Callable[[], Any]) -> Any:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if found := condition():
                return found
            time.sleep(0.02)
        raise AssertionError("it did not happen in time")

    return wait


class MockGo2:
    """A Go2 mock in a process of its own, which tells what it hears."""

    def __init__(self, log: Path, arguments: list[str], namespace: str = "") -> None:
        within = ["ip", "netns", "exec", namespace] if namespace else []
        code = [sys.executable, "-m", "cavalcade.fleet.unitree.mock", "--log"]
        self.log = log
        with log.open("w") as out:
            self.process = subprocess.Popen(
                [*within, *code, *arguments], stdin=subprocess.PIPE, stdout=out, text=True
            )

    def command(self, line: str) -> None:
        """Make it misbehave, from when this returns on."""
        before = self._told()
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        end = time.monotonic() + PATIENCE
        while self._told() == before:
            assert time.monotonic() < end, "it does not listen"
            time.sleep(0.01)

    def _told(self) -> int:
        return sum("told" in entry for entry in self._entries)

    @property
    def _entries(self) -> list[dict[str, Any]]:
        lines = self.log.read_text().splitlines(keepends=True)
        return [json.loads(line) for line in lines if line.endswith("\n")]

    @property
    def requests(self) -> list[dict[str, Any]]:
        """What it was asked: `t` of the wall's time, `api`, `v`, `code`."""
        return [entry for entry in self._entries if "api" in entry]

    @property
    def states(self) -> list[dict[str, Any]]:
        """Where it was and what it did: `t`, `pose`, `v`, `is`."""
        return [entry for entry in self._entries if "is" in entry]

    def asked(self, api: int, since: float = 0.0) -> list[float]:
        """When it was asked for that."""
        return [e["t"] for e in self.requests if e["api"] == api and e["t"] >= since]

    @property
    def calls(self) -> list[int]:
        """Its requests in order, those that follow each other alike as one."""
        found: list[int] = []
        for entry in self.requests:
            if not found or found[-1] != entry["api"]:
                found.append(entry["api"])
        return found

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdin is not None
        self.process.stdin.close()


@pytest.fixture
def mocks(
    tmp_path: Path, request: pytest.FixtureRequest
) -> Iterator[Callable[..., tuple[int, MockGo2]]]:
    """Starts a Go2 mock on this machine, in a domain of its own: `domain, mock = mocks("--loss",
    "0.1")`; in a namespace of the network: `mocks(..., namespace=, interface=)`."""
    from cavalcade.errors import InputError
    from cavalcade.fleet.unitree import load_sdk

    try:
        load_sdk()
    except InputError as error:
        pytest.skip(str(error))
    first = 100 + hash((os.getpid(), request.node.nodeid)) % 120
    started: list[MockGo2] = []

    def start(*arguments: str, namespace: str = "", interface: str = "lo") -> tuple[int, MockGo2]:
        domain = 0 if namespace else first + len(started)
        place = ["--domain", str(domain), "--interface", interface]
        log = tmp_path / f"mock{len(started)}.log"
        started.append(MockGo2(log, [*place, *arguments], namespace))
        return domain, started[-1]

    yield start
    for mock in started:
        mock.end()
