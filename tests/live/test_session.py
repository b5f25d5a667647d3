"""What `cavalcade ros2 navigate --out` leaves, however it ends."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from navigation_peers import Peers

from cavalcade.cli.commands import run_command
from cavalcade.errors import InputError
from cavalcade.fleet.ros2 import load_rclpy
from cavalcade.jobs import finish_recording
from cavalcade.scenario import load_scenario

THERE, BACK = (2.5, 3.0, 0.0), (1.6, 3.0, 0.0)

try:
    load_rclpy()
except InputError as error:
    pytest.skip(str(error), allow_module_level=True)


@pytest.fixture
def peers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> Iterator[Peers]:
    domain = 1 + hash((os.getpid(), request.node.nodeid)) % 100
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    found = Peers(tmp_path)
    try:
        found.simulate()
        yield found
    finally:
        found.close()


@pytest.fixture
def small(tmp_path: Path) -> Iterator[Path]:
    """A disk of half a megabyte."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=512k", "tmpfs", str(disk)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("nothing can be mounted here")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


def size_of(folder: Path) -> int:
    file = folder / "recording.mcap"
    return file.stat().st_size if file.exists() else 0


def arrive(peers: Peers, node: Any, goal: tuple[float, float, float]) -> None:
    peers.send_goal(goal)
    peers.until(lambda: peers.state() == "partial" or peers.moving(), node)
    peers.until(lambda: onward(peers) and peers.state() == "arrived", node)


def onward(peers: Peers) -> bool:
    """Whether nothing stops them; a machine that stood still for half a second has."""
    if peers.state() == "stopped":
        peers.call("resume")
    return bool(peers.status["ok"])


def test_folders_of_sessions_that_ended_that_were_killed_and_that_are_replaced(
    peers: Peers, capsys: pytest.CaptureFixture[str]
) -> None:
    whole, killed = peers.folder / "whole", peers.folder / "killed"
    node = peers.navigate("--out", str(whole))
    arrive(peers, node, THERE)
    node.send_signal(signal.SIGTERM)
    assert node.wait(60) == 0, node.output.read_text()
    said = json.loads((whole / "summary.json").read_text())
    assert (said["reason"], said["success"], said["backend"]) == ("arrived", True, "ros2")
    left = {str(file.relative_to(whole)) for file in whole.rglob("*") if file.is_file()}
    files = {"summary.json", "scenario.yaml", "recording.mcap", "replay.html", "map.yaml"}
    assert files | {"figures/sequence.png"} <= left
    assert all(str(whole / name) in node.output.read_text() for name in files - {"map.yaml"})
    assert load_scenario(whole / "scenario.yaml").task.goals == (THERE,)
    assert run_command(["check", str(whole)]) == 0, capsys.readouterr()

    # The process dies while robots move.
    node = peers.navigate("--out", str(killed), "--quiet")
    peers.send_goal(BACK)
    peers.until(lambda: peers.poses["robot_0"][0][0] < THERE[0] - 0.3, node)
    begun = size_of(killed)
    peers.until(lambda: size_of(killed) > begun, node)
    node.kill()
    node.wait()
    capsys.readouterr()
    assert run_command(["check", str(killed)]) == 1
    assert "breaks off" in capsys.readouterr().out
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        result = finish_recording(killed, figures=False)  # as `cavalcade show` does it
    assert "the end of this recording is missing" in str(warned[0].message)
    assert result.reason == "crashed"
    assert (killed / "replay.html").is_file()

    # What is there is kept, unless somebody says that it need not be.
    before = (whole / "summary.json").read_bytes()
    assert run_command(["ros2", "navigate", str(peers.team), "--out", str(whole)]) == 2
    assert "not empty; name another one or use --force" in capsys.readouterr().err
    assert (whole / "summary.json").read_bytes() == before
    peers.until(peers.standing)
    node = peers.navigate("--out", str(whole), "--force")
    assert not (whole / "summary.json").exists()
    peers.until(lambda: size_of(whole) > 0, node)


def test_a_full_disk_is_said_and_stops_nobody(
    peers: Peers, small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, filler = small / "s", small / "filler"
    node = peers.navigate("--out", str(folder))
    peers.until(lambda: size_of(folder) > 1000, node)
    with filler.open("wb") as file:
        fill(file.fileno())
    peers.send_goal(THERE)
    peers.until(lambda: "cannot be written" in peers.status["recording"], node)
    assert "No space left on device" in peers.status["message"]
    assert not peers.status["cause"]
    peers.until(lambda: onward(peers) and peers.state() == "arrived", node)
    filler.unlink()
    peers.until(lambda: peers.status["message"] == "", node)
    with filler.open("wb") as file:
        fill(file.fileno())
    peers.until(lambda: "cannot be written" in peers.status["recording"], node)
    # What comes after the robots have stopped has no room, either.
    node.send_signal(signal.SIGTERM)
    assert node.wait(60) == 2
    text = node.output.read_text()
    assert "No space left on device" in text
    assert "Traceback" not in text
    assert not peers.moving()
    # What was written until then can be used where there is room.
    kept = shutil.copytree(folder, peers.folder / "kept")
    capsys.readouterr()
    assert run_command(["check", "--json", str(kept)]) == 1
    found = json.loads(capsys.readouterr().out)["violations"]
    assert {one["kind"] for one in found} == {"samples"}  # what is there is clean
    assert "breaks off" in str(found)


def fill(file: int) -> None:
    """Write until there is no room, not for a byte."""
    for size in (2**16, 2**12, 1):
        try:
            while True:
                os.write(file, bytes(size))
        except OSError:
            continue
