"""Live teams that are driven from the page, without a page and on robots that are pretended."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.errors import FleetError, InputError
from cavalcade.scenario import parse_scenario
from cavalcade.studio.drive.live_drive import LiveDrive

sys.path.insert(0, str(Path(__file__).parents[1] / "live"))
from fake_fleet import FakeFleet, until

STARTS = ((1.5, 2.0, 0.0), (1.5, 3.0, 0.0))
WORDS: dict[str, Any] = {
    "version": 1,
    "name": "live",
    "world": {"empty": {"size": [10, 6]}},
    "robots": [{"model": "go1", "start": list(start)} for start in STARTS],
    "task": {"formation": {"shape": "line", "spacing": 1.0}, "goals": [[8.0, 2.5, 0.0]]},
    # Slow cycles: the machine may be busy with other things.
    "execution": {"backend": "ros2", "rate": 5, "timeout": 60},
}


@pytest.fixture
def fleet() -> FakeFleet:
    return FakeFleet(STARTS)


@pytest.fixture
def drive(fleet: FakeFleet, tmp_path: Path) -> Iterator[LiveDrive]:
    found = LiveDrive(parse_scenario(WORDS), tmp_path / "out", lambda team: fleet)
    found.start()
    until(lambda: found.phase == "running", 120.0)
    yield found
    found.close()


def stands(fleet: FakeFleet) -> bool:
    return not np.any(fleet.sent[-1][1])


def moves(fleet: FakeFleet) -> bool:
    return bool(np.any(fleet.sent[-1][1]))


def test_it_drives_arrives_goes_on_and_ends(drive: LiveDrive, fleet: FakeFleet) -> None:
    until(lambda: drive.snapshot() is not None and moves(fleet))
    assert drive.snapshot().poses.shape == (2, 3)
    drive.set_goals([(3.0, 2.5, 0.0)])
    until(lambda: drive.phase == "waiting", 90.0)
    assert drive.words.startswith("Arrived")
    assert drive.goals == ((3.0, 2.5, 0.0),)
    drive.set_goals([(5.0, 2.5, 0.0)])
    until(lambda: drive.phase == "running" and moves(fleet))
    drive.pause()
    until(lambda: drive.phase == "paused" and stands(fleet))
    drive.resume()
    until(lambda: drive.phase == "running" and moves(fleet))
    drive.stop()
    until(lambda: drive.phase == "ended", 60.0)
    assert stands(fleet)
    assert fleet.closed
    assert {"summary.json", "recording.mcap"} <= {file.name for file in drive.folder.iterdir()}
    assert "commanded to stop" in drive.words


def test_the_emergency_stop_holds_until_it_is_resumed(drive: LiveDrive, fleet: FakeFleet) -> None:
    until(lambda: moves(fleet))
    drive.emergency_stop("by hand")
    until(lambda: drive.phase == "stopped" and stands(fleet))
    assert "e-stop" in drive.words
    assert "by hand" in drive.words
    drive.set_goals([(6.0, 2.5, 0.0)])  # does not start anybody
    count = len(fleet.sent)
    until(lambda: len(fleet.sent) > count + 5)
    assert all(not np.any(sent) for _, sent in fleet.sent[count:])
    drive.resume()
    until(lambda: drive.phase == "running" and moves(fleet))


def test_robots_and_obstacles_come_and_go(drive: LiveDrive, fleet: FakeFleet) -> None:
    until(lambda: drive.snapshot() is not None)
    drive.lose(1)
    until(lambda: drive.lost == (1,))
    assert drive.snapshot().lost == (1,)
    with pytest.raises(InputError, match="lost already"):
        drive.lose(1)
    drive.rejoin(1)
    until(lambda: drive.lost == ())
    with pytest.raises(InputError, match="is not lost"):
        drive.rejoin(1)
    drive.add({"circle": {"center": [5.0, 4.5], "radius": 0.3}})
    until(lambda: len(drive.snapshot().obstacles) == 1)
    drive.move(0, (5.0, 5.0), 0.5)
    until(lambda: [one.center for one in drive.snapshot().obstacles] == [(5.0, 5.0)])
    drive.remove(1)
    until(lambda: drive.snapshot().obstacles == ())


def test_what_real_robots_cannot_do_is_refused(drive: LiveDrive) -> None:
    for wrong, words in (
        (drive.step, "single steps"),
        (lambda: drive.set_speed(2.0), "time of their own"),
        (lambda: drive.push(0, (1.0, 0.0)), "physics"),
        (lambda: drive.set_goals([]), "at least one"),
        (lambda: drive.set_goals([(np.nan, 0.0, 0.0)]), "finite"),
        (lambda: drive.set_formation({"shape": "sqare"}), "shape"),
        (lambda: drive.remove(3), "not there any more"),
    ):
        with pytest.raises(InputError, match=words):
            wrong()
    drive.stop()
    for late in (drive.pause, drive.resume, drive.stop, lambda: drive.set_goals([(1.0, 1.0, 0.0)])):
        with pytest.raises(InputError, match="over"):
            late()


def test_a_robot_that_is_not_heard_ends_it_in_words(tmp_path: Path) -> None:
    class Deaf(FakeFleet):
        def start(self, timeout: float) -> None:
            raise FleetError("robot_1 was not heard on /robot_1/pose")

    fleet = Deaf(STARTS)
    drive = LiveDrive(parse_scenario(WORDS), tmp_path / "out", lambda team: fleet)
    assert drive.phase == "preparing"
    assert "robot_0, robot_1" in drive.words
    drive.start()
    until(lambda: drive.phase == "ended")
    assert "robot_1 was not heard" in drive.words
    assert fleet.closed
    with pytest.raises(InputError, match="over"):
        drive.resume()


def test_an_emergency_stop_before_anybody_is_heard_drives_nobody(tmp_path: Path) -> None:
    class Slow(FakeFleet):
        def start(self, timeout: float) -> None:
            until(lambda: self.go)

    fleet = Slow(STARTS)
    fleet.go = False  # type: ignore[attr-defined]
    drive = LiveDrive(parse_scenario(WORDS), tmp_path / "out", lambda team: fleet)
    drive.start()
    drive.emergency_stop("by hand")
    fleet.go = True  # type: ignore[attr-defined]
    until(lambda: drive.phase == "ended")
    assert all(not np.any(sent) for _, sent in fleet.sent)
    assert fleet.closed


def test_teams_that_cannot_be_driven_are_refused_before(tmp_path: Path) -> None:
    def of(words: dict[str, Any]) -> Callable[[], LiveDrive]:
        return lambda: LiveDrive(parse_scenario(words), tmp_path / "out")

    commands = {
        **WORDS,
        "task": {"commands": [{"at": 0.0, "velocity": [0.1, 0.0, 0.0]}]},
    }
    with pytest.raises(InputError, match="commands"):
        of(commands)()
