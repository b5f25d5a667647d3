"""Simulated runs that are driven from the page, without a page."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.scenario import load_scenario, parse_scenario
from cavalcade.studio.drive.result import scenario_bytes
from cavalcade.studio.drive.simulated_drive import LONGEST, SimulatedDrive

WORDS: dict[str, Any] = {
    "version": 1,
    "name": "driven",
    "world": {
        "empty": {"size": [10, 8]},
        "obstacles": [{"circle": {"center": [5.0, 6.0], "radius": 0.4}}],
    },
    "robots": [{"model": "go1", "start": [1.5, 3.0 + y, 0.0]} for y in (0.0, 1.0)],
    "task": {"formation": {"shape": "column", "spacing": 1.0}, "goals": [[8.0, 4.0, 0.0]]},
    "execution": {"timeout": 20},
}
ROCK = {"box": {"center": [5.0, 3.5], "size": [0.5, 0.5]}}
TIMES = {"wall_time_s", "planning_time_s", "cycle_ms", "real_time_factor"}


def until(condition: Callable[[], Any], patience: float = 120.0) -> None:
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, "it did not come to that"
        time.sleep(0.005)


@pytest.fixture
def drive_of(tmp_path: Path) -> Iterator[Callable[..., SimulatedDrive]]:
    drives: list[SimulatedDrive] = []

    def begun(words: dict[str, Any] = WORDS, **options: Any) -> SimulatedDrive:
        out = tmp_path / f"drive-{len(drives)}"
        drive = SimulatedDrive(parse_scenario(words), out, **{"speed": 10.0, **options})
        drives.append(drive)
        drive.start()
        return drive

    yield begun
    for drive in drives:
        drive.close()


def summary_on_the_command_line(drive: SimulatedDrive, folder: Path) -> dict[str, Any]:
    """Of what was played, exported and run there."""
    folder.mkdir()
    file = folder / "exported.yaml"
    file.write_bytes(scenario_bytes(drive.played))
    command = [sys.executable, "-m", "cavalcade", "run", str(file), "--out", str(folder / "out")]
    done = subprocess.run([*command, "--quiet"], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    return dict(json.loads((folder / "out" / "summary.json").read_text()))


def without_times(summary: Any) -> dict[str, Any]:
    return {key: value for key, value in dict(summary).items() if key not in TIMES}


def test_it_is_prepared_runs_is_paused_waits_and_ends(drive_of: Any) -> None:
    drive = drive_of(paused=True)
    seen = {drive.phase}
    until(lambda: seen.add(drive.phase) or drive.phase == "paused")
    assert seen <= {"preparing", "running", "paused"}
    assert "Paused" in drive.words
    assert drive.snapshot() is None
    drive.step()
    until(lambda: drive.phase == "paused" and drive.snapshot() is not None)
    drive.step()
    until(lambda: drive.phase == "paused" and drive.snapshot().time > 0.0)
    assert drive.snapshot().time == pytest.approx(0.05)
    drive.resume()
    until(lambda: drive.phase == "waiting")
    assert drive.words.startswith("Arrived. Drag the goal")
    assert drive.goals == ((8.0, 4.0, 0.0),)
    drive.add(ROCK)
    assert drive.words.endswith("1 change comes about with the next goal")
    drive.set_goals([(6.5, 5.0, 0.0)])
    until(lambda: drive.phase == "running")
    until(lambda: drive.phase == "waiting")
    drive.stop()
    assert drive.words.startswith("Ending")
    until(lambda: drive.phase == "ended")
    assert drive.words == "Ended: Arrived"
    assert drive.summary["reason"] == "arrived"
    assert {"summary.json", "scenario.yaml", "replay.html", "recording.mcap"} <= {
        file.name for file in drive.folder.iterdir()
    }


def test_what_was_played_gives_the_same_on_the_command_line(drive_of: Any, tmp_path: Path) -> None:
    drive = drive_of()
    until(lambda: drive.snapshot() is not None and drive.time > 0.5)
    drive.add(ROCK)
    until(lambda: any(not span.fixed for span in drive.spans))
    drive.set_goals([(5.0, 5.0, 0.0), (8.0, 4.5, 0.3)])
    until(lambda: drive.time > 2.0)
    drive.move(1, (5.0, 2.0), 0.5)
    drive.move(0, (5.0, 7.0), 0.0)
    drive.set_formation({"shape": "line", "spacing": 1.0})
    until(lambda: drive.time > 4.0)
    drive.lose(1)
    until(lambda: drive.lost == (1,))
    assert drive.snapshot().lost == (1,)
    until(lambda: drive.time > 6.0)
    drive.rejoin(1)
    until(lambda: drive.phase == "waiting")
    assert drive.lost == ()
    drive.stop()
    until(lambda: drive.phase == "ended")
    events = [event.kind for event in drive.played.execution.events]
    assert sorted(events) == sorted(
        ["add", "goals", "move", "remove", "add", "formation", "lose", "rejoin"]
    )
    again = summary_on_the_command_line(drive, tmp_path / "again")
    assert without_times(again) == without_times(drive.summary)


def test_what_walked_gives_the_same_on_the_command_line(drive_of: Any, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    drive = drive_of({**WORDS, "execution": {"backend": "mujoco"}, "task": {
        **WORDS["task"], "goals": [[4.5, 4.0, 0.0]]}})  # fmt: skip
    until(lambda: drive.snapshot() is not None and drive.time > 0.5)
    moment = drive.snapshot()
    assert moment.trunks.shape == (2, 7)
    assert moment.trunks[:, 2] == pytest.approx([0.3, 0.3], abs=0.1)
    assert np.linalg.norm(moment.trunks[:, 3:], axis=1) == pytest.approx([1.0, 1.0])
    assert abs(moment.trunks[0, 6]) > 0.9  # upright: w comes last
    assert [len(joints) for joints in moment.joints] == [12, 12]
    drive.add({"box": {"center": [3.0, 3.2], "size": [0.3, 0.3]}})
    until(lambda: drive.time > 1.5)
    drive.push(0, (0.0, 8.0))
    until(lambda: drive.phase in ("waiting", "ended"))
    if drive.phase == "waiting":
        drive.stop()
    until(lambda: drive.phase == "ended")
    assert [event.kind for event in drive.played.execution.events] == ["add", "push"]
    again = summary_on_the_command_line(drive, tmp_path / "again")
    assert without_times(again) == without_times(drive.summary)


def test_a_run_that_is_stopped_ends_at_the_same_time_in_its_file(
    drive_of: Any, tmp_path: Path
) -> None:
    drive = drive_of()
    until(lambda: drive.time > 1.0)
    drive.stop()
    until(lambda: drive.phase == "ended")
    assert drive.summary["reason"] == "stopped"
    again = summary_on_the_command_line(drive, tmp_path / "again")
    assert again["reason"] == "timeout"
    assert again["sim_time_s"] == drive.summary["sim_time_s"]


def test_obstacles_come_go_and_move_in_what_is_shown(drive_of: Any) -> None:
    drive = drive_of(paused=True)
    until(lambda: drive.phase == "paused")
    drive.step()
    until(lambda: drive.snapshot() is not None)
    assert drive.snapshot().obstacles == ()
    drive.add(ROCK)
    drive.step()
    until(lambda: len(drive.snapshot().obstacles) == 1)
    assert drive.snapshot().obstacles[0].to_dict()["box"]["center"] == [5.0, 3.5]
    drive.move(0, (5.0, 7.0), 10.0)  # it was there from the start
    drive.step()
    until(lambda: len(drive.snapshot().obstacles) == 2)
    drive.remove(1)
    drive.step()
    until(lambda: len(drive.snapshot().obstacles) == 1)
    with pytest.raises(InputError, match="not there any more"):
        drive.remove(1)


def test_wrong_things_are_refused_in_words(drive_of: Any, tmp_path: Path) -> None:
    unbegun = SimulatedDrive(parse_scenario(WORDS), tmp_path / "unbegun")
    with pytest.raises(InputError, match="has not begun"):
        unbegun.set_goals([(4.0, 4.0, 0.0)])
    drive = drive_of(paused=True)
    until(lambda: drive.phase == "paused")
    drive.step()
    until(lambda: drive.snapshot() is not None)
    for wrong, words in (
        (lambda: drive.set_goals([]), "at least 1"),
        (lambda: drive.set_goals([(np.nan, 0.0, 0.0)]), "number"),
        (lambda: drive.set_formation({"shape": "sqare"}), "did you mean square"),
        (lambda: drive.set_formation({"shape": "line", "spacing": 0.0}), "greater than 0"),
        (lambda: drive.add({"box": {"center": [1.5, 3.0], "size": [1, 1]}}), "robot 0 stands"),
        (lambda: drive.add({"box": {"center": [1.5, 5.0], "size": [0, 1]}}), "size"),
        (lambda: drive.add({}), "expected one shape"),
        (lambda: drive.remove(7), "not there any more"),
        (lambda: drive.move(0, (1.5, 3.0), 0.0), "robot 0 stands"),
        (lambda: drive.move(0, (1.5, 3.0), -1.0), "robot 0 stands"),
        (lambda: drive.move(0, (1.5, 3.0), 1e9), "speed"),
        (lambda: drive.lose(2), "there is no robot 2"),
        (lambda: drive.rejoin(0), "is not lost"),
        (lambda: drive.push(0, (10.0, 0.0)), "in physics"),
        (lambda: drive.set_speed(0.0), "speed"),
        (lambda: drive.set_speed(11.0), "speed"),
    ):
        with pytest.raises(InputError, match=words) as found:
            wrong()
        assert "execution.events" not in str(found.value)
    drive.lose(0)
    with pytest.raises(InputError, match="lost already"):
        drive.lose(0)
    drive.stop()
    for late in (drive.pause, drive.resume, drive.step, drive.stop, lambda: drive.lose(1)):
        with pytest.raises(InputError, match="over"):
            late()
    until(lambda: drive.phase == "ended")
    with pytest.raises(InputError, match="over"):
        drive.set_goals([(4.0, 4.0, 0.0)])


def test_goals_of_single_robots_are_planned_ahead(drive_of: Any, tmp_path: Path) -> None:
    drive = SimulatedDrive(load_scenario("head-on"), tmp_path / "out", speed=10.0, paused=True)
    drive.start()
    until(lambda: drive.phase == "paused")
    assert drive.goals == ()
    with pytest.raises(InputError, match="planned ahead"):
        drive.add(ROCK)
    drive.resume()
    until(lambda: drive.phase in ("waiting", "ended"))
    drive.close()
    assert drive.summary["success"]


def test_a_world_that_cannot_be_made_ends_in_words(tmp_path: Path) -> None:
    words = {**WORDS, "robots": [{"model": "go1", "start": [5.0, 6.0, 0.0]}] * 1}
    with pytest.raises(InputError, match="start"):
        SimulatedDrive(parse_scenario(words), tmp_path / "out")


def test_a_folder_that_cannot_be_written_to_ends_in_words(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    drive = SimulatedDrive(parse_scenario(WORDS), tmp_path / "file" / "out")
    drive.start()
    until(lambda: drive.phase == "ended")
    assert drive.words.startswith("Ended: ")
    assert "file" in drive.words
    assert drive.folder is None


def test_it_goes_on_after_the_scenarios_own_time(drive_of: Any) -> None:
    drive = drive_of({**WORDS, "execution": {"timeout": 0.2}}, speed=10.0)
    until(lambda: drive.time > 1.0)
    assert drive.phase == "running"
    assert drive.played.execution.timeout == LONGEST


def test_it_says_how_fast_it_really_goes(drive_of: Any) -> None:
    drive = drive_of(speed=2.0)
    until(lambda: drive.pace is not None)
    assert drive.pace == pytest.approx(2.0, rel=0.5)
    drive.pause()
    until(lambda: drive.phase == "paused")
    assert drive.pace is None


def test_it_can_be_closed_at_any_moment(tmp_path: Path) -> None:
    for number, wait in enumerate((0.0, 0.05, 0.5)):
        drive = SimulatedDrive(parse_scenario(WORDS), tmp_path / f"out-{number}")
        drive.start()
        time.sleep(wait)
        drive.close()
        assert drive.phase == "ended"
        assert not drive.trouble
    drive = SimulatedDrive(parse_scenario(WORDS), tmp_path / "never")
    drive.close()
