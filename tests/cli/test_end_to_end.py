"""Real commands: the main job, refusals and Ctrl-C.

The main job and Ctrl-C are shown in processes of their own, what is refused in this one: that its
exit code reaches the shell stands in `test_main.py`.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cavalcade.cli import main

Captured = pytest.CaptureFixture[str]

_SCENARIO = """\
version: 1
name: short
world: {empty: {size: [6, 4]}}
robots:
  - {model: go1, start: [1.0, 2.5, 0.0]}
  - {model: go1, start: [1.0, 1.5, 0.0]}
task:
  formation: {shape: line, spacing: 1.0}
  goals: [[2.5, 2.0, 0.0]]
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "short.yaml"
    path.write_text(_SCENARIO, encoding="utf-8")
    return path


def _command(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "cavalcade", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
    )


def _refused(capfd: Captured, *arguments: object) -> str:
    """The one line that a command in this process is refused with."""
    code = main([str(argument) for argument in arguments])
    out, error = capfd.readouterr()
    assert code == 2, error
    assert out == ""
    assert error.startswith("cavalcade: ")
    assert error.count("\n") == 1
    return error


def test_run_then_check(scenario: Path, tmp_path: Path, capfd: Captured) -> None:
    out = tmp_path / "a"
    done = _command("run", scenario, "--out", out, "--json")
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["success"] is True
    assert summary["reason"] == "arrived"
    assert json.loads((out / "summary.json").read_text(encoding="utf-8")) == summary
    assert main(["check", str(out)]) == 0
    capfd.readouterr()
    # What holds something is not overwritten unless that is said.
    assert "--force" in _refused(capfd, "run", scenario, "--out", out)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("robots[0].start=[0.1, 2.5, 0]", "robots[0].start: the robot at (0.1, 2.5) reaches"),
        (
            "robots[0].start=[1.0, 1.5, 0]",
            "robots[1].start: the robot at (1, 1.5) overlaps robot 0",
        ),
        ("robots[0].start=[.nan, 1.5, 0]", "robots[0].start[0]: expected a finite number"),
        ("task.formation.shape=blob", "task.formation.shape: unknown value 'blob'"),
        ("world={empty: {size: [500, 500]}}", "world.empty.size: "),
        ("world={map: none.yaml}", "none.yaml"),
    ],
)
def test_bad_input_leaves_nothing(
    scenario: Path, tmp_path: Path, capfd: Captured, change: str, message: str
) -> None:
    line = _refused(capfd, "run", scenario, "--out", tmp_path / "a", "--set", change)
    assert message in line
    assert os.listdir(tmp_path) == ["short.yaml"]


@pytest.mark.parametrize(
    ("picture", "yaml", "message"),
    [
        (b"P5 120 80 255\n" + bytes(4000), "", "lab.pgm: the picture is truncated: 4000 of 9600"),
        (b"P5 10000 10000 255\n", "", "lab.pgm: picture: 10000 x 10000 cells are too many"),
        (b"P5 120 80 255\n" + bytes(9600), "free_thresh: much", "lab.yaml: free_thresh: "),
        (b"P5 120 80 255\n" + bytes(9600), "origin: [0, 0]", "lab.yaml: origin: "),
        (b"P5 120 80 255\n" + bytes(9600), "resolution: .nan", "lab.yaml: resolution: "),
    ],
)
def test_a_bad_map_leaves_nothing(
    scenario: Path, tmp_path: Path, capfd: Captured, picture: bytes, yaml: str, message: str
) -> None:
    said = {
        "image": "lab.pgm",
        "resolution": "0.05",
        "origin": "[0, 0, 0]",
        "negate": "0",
        "occupied_thresh": "0.65",
        "free_thresh": "0.196",
    }
    said.update([yaml.split(": ")] if yaml else [])
    (tmp_path / "lab.pgm").write_bytes(picture)
    (tmp_path / "lab.yaml").write_text("".join(f"{k}: {v}\n" for k, v in said.items()))
    before = sorted(os.listdir(tmp_path))
    to_map = ("--set", "world={map: lab.yaml}")
    assert message in _refused(capfd, "run", scenario, "--out", tmp_path / "a", *to_map)
    assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (_SCENARIO.replace("version: 1\n", ""), "short.yaml: version: missing"),
        (_SCENARIO.replace("[2.5, 2.0, 0.0]", "east"), "short.yaml: task.goals[0]: expected"),
        (_SCENARIO.replace("robots:", "robot:"), "short.yaml: robot: unknown key"),
        (_SCENARIO[:-4], "short.yaml: "),
    ],
)
def test_a_bad_scenario_leaves_nothing(
    scenario: Path, tmp_path: Path, capfd: Captured, text: str, message: str
) -> None:
    scenario.write_text(text, encoding="utf-8")
    assert message in _refused(capfd, "run", scenario, "--out", tmp_path / "a")
    assert os.listdir(tmp_path) == ["short.yaml"]


def test_an_output_folder_that_cannot_be_made(
    scenario: Path, tmp_path: Path, capfd: Captured
) -> None:
    assert str(scenario) in _refused(capfd, "run", scenario, "--out", scenario / "a")
    assert os.listdir(tmp_path) == ["short.yaml"]


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_is_130_and_leaves_nothing(scenario: Path, tmp_path: Path) -> None:
    arguments = [
        "run",
        scenario,
        "--out",
        tmp_path / "a",
        "--realtime",
        "--set",
        "execution.rate=10",
    ]
    process = subprocess.Popen(
        [sys.executable, "-m", "cavalcade", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    until = time.monotonic() + 60.0
    while not (tmp_path / "a").exists() and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 130, error
    assert "Traceback" not in error
    assert os.listdir(tmp_path) == ["short.yaml"]


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_while_dataclasses_are_made(tmp_path: Path) -> None:
    """It comes up within an `exec` there, after which Python would end by the signal itself."""
    code = (
        "import os, signal, sys; from cavalcade.cli import commands, main; "
        "load = lambda *_: exec('os.kill(os.getpid(), signal.SIGINT)'); "
        "commands.options.load = load; "
        f"sys.exit(main(['run', 'cone', '--out', {str(tmp_path / 'a')!r}]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stderr) == (130, "cavalcade: interrupted\n")
    assert os.listdir(tmp_path) == []
