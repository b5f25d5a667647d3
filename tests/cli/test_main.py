"""The command line as a user meets it: exit codes, one-line errors, what goes where."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import types
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cavalcade.cli import main
from cavalcade.errors import OutputError, RecordingError
from cavalcade.scenario import scenario_names

Fake = Callable[..., None]


@pytest.fixture
def fake_run(monkeypatch: pytest.MonkeyPatch) -> list[tuple[tuple[Any, ...], dict[str, Any]]]:
    """Puts a stand-in for the running package; the list tells how it was called."""
    calls: list[tuple[tuple[Any, ...], dict[str, Any]]] = []
    module = types.ModuleType("cavalcade.jobs")

    def run(*arguments: Any, **options: Any) -> Any:
        calls.append((arguments, options))
        outcome = _OUTCOME.get(arguments[0].name)
        if isinstance(outcome, BaseException):
            raise outcome
        reason = "arrived" if outcome is None else outcome
        return types.SimpleNamespace(
            summary={"reason": reason, "goal_moved_m": None},
            success=reason == "arrived",
            reason=reason,
        )

    module.run = run  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "cavalcade.jobs", module)
    return calls


_OUTCOME: dict[str, Any] = {
    "infeasible": "infeasible",
    "cone": KeyboardInterrupt(),
    "tour-ten": OutputError("runs/a: the folder is not empty"),
    "maze-solo": OSError(28, "No space left on device", "runs/a"),
}


def _refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """The one line on stderr with which the command is refused."""
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("cavalcade: ")
    assert err.count("\n") == 1
    return err


def test_run_hands_everything_over(fake_run: list[Any], tmp_path: Path) -> None:
    code = main(
        [
            *("run", "square-clutter", "--out", str(tmp_path / "a"), "--seed", "7", "--force"),
            *("--set", "planner.variant=published", "--set", "execution.rate=10"),
            *("--backend", "ideal", "--quiet", "--realtime"),
        ]
    )
    assert code == 0
    (scenario, out), options = fake_run[0]
    assert (scenario.seed, scenario.planner.variant, scenario.execution.rate) == (
        7,
        "published",
        10,
    )
    assert out == tmp_path / "a"
    assert options == {"force": True, "realtime": True, "quiet": True}


def test_json_is_all_that_goes_to_stdout(
    fake_run: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "square-clutter", "--out", "x", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"reason": "arrived", "goal_moved_m": None}
    assert fake_run[0][1]["quiet"]


def test_not_achieved_is_one_and_one_line(
    fake_run: list[Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "infeasible", "--out", "x"]) == 1
    assert capsys.readouterr().err == "cavalcade: infeasible: not achieved: infeasible\n"


def test_interrupted_is_130(fake_run: list[Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "cone", "--out", "x"]) == 130
    assert capsys.readouterr().err == "cavalcade: interrupted\n"


@pytest.mark.parametrize(
    ("scenario", "message"),
    [("tour-ten", "the folder is not empty"), ("maze-solo", "runs/a: No space left on device")],
)
def test_what_cannot_be_written_is_two(
    fake_run: list[Any], capsys: pytest.CaptureFixture[str], scenario: str, message: str
) -> None:
    assert message in _refused(["run", scenario, "--out", "x"], capsys)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "square-cluter", "--out", "x"], "did you mean square-clutter?"),
        (["run", "square-clutter"], "--out"),
        (["run", "square-clutter", "--out", "x", "--set", "planner.variant=new"], "variant"),
        (["run", "square-clutter", "--out", "x", "--set", "rubbish"], "expected KEY=VALUE"),
        (["run", "square-clutter", "--out", "x", "--seed", "-4"], "execution.seed: expected"),
        (["run", "square-clutter", "--out", "x", "--seed", "one"], "--seed"),
        (
            ["run", "square-clutter", "--out", "x", "--backend", "gazebo"],
            "(one of: ideal, mujoco, ros2, unitree)",
        ),
        (
            ["run", "octagon-swap", "--out", "x", "--backend", "mujoco"],
            "robots[0].model: physics has no masses and joints of a spirit; expected a robot",
        ),
        (["run", "square-clutter", "--out", "x", "--fast"], "--fast"),
        (["fly"], "fly"),
        (["show", "cone", "--out", "cone.txt"], "expected the name of a picture"),
        (["show", "cone", "--out", "no/such/folder/cone.png"], "no/such/folder: no such folder"),
        (["import", "x"], "--out"),
        (["import", "x", "--out", "y.yaml"], "x: no such file"),
        (["studio", "--port", "70000"], "--port"),
    ],
)
def test_bad_input_is_two_and_one_line(
    fake_run: list[Any], capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert message in _refused(arguments, capsys)
    assert fake_run == []


def test_a_bad_start_names_file_and_key(
    fake_run: list[Any], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "s.yaml"
    file.write_text("version: 1\nname: x\nworld: {empty: {size: [5, 5]}}\n", encoding="utf-8")
    line = _refused(["run", str(file), "--out", "x"], capsys)
    assert line.startswith(f"cavalcade: {file}: robots: missing")


def test_scenarios_lists_them_all(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenarios"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(scenario_names())
    assert all(len(line.split()) > 2 for line in lines)
    assert main(["scenarios", "--json"]) == 0
    assert list(json.loads(capsys.readouterr().out)) == list(scenario_names())


def test_schema_is_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    assert "robots" in json.loads(capsys.readouterr().out)["properties"]


def test_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    import cavalcade

    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == cavalcade.__version__
    for arguments in (["--help"], []):
        assert main(arguments) == 0
        assert "scenarios" in capsys.readouterr().out
    assert main(["run", "--help"]) == 0
    assert "--realtime" in capsys.readouterr().out


def _fake_check(monkeypatch: pytest.MonkeyPatch, outcome: Any) -> None:
    module = types.ModuleType("cavalcade.checking")

    def check(directory: Path) -> Any:
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    module.check = check  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "cavalcade.checking", module)


def test_check_clean_violated_and_unreadable(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from cavalcade.checking.report import Figures, Report, Violation

    figures = Figures(4, 38.5, 0.212, 0.9, 1.0, float("inf"), 1.5)
    _fake_check(monkeypatch, Report((), figures))
    assert main(["check", "runs/a"]) == 0
    assert capsys.readouterr().out == "runs/a: clean; 4 robots, 38.5 s, smallest gap 0.212 m\n"
    assert main(["check", "runs/a", "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert main(["check", "runs/a", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["ok"] is True
    assert said["violations"] == []
    assert said["figures"]["max_acceleration"] is None

    touch = Violation("robot-robot", 12.345, (0, 2), "robot 0 touches robot 2", 0.0, 0.0)
    _fake_check(monkeypatch, Report((touch, touch), figures))
    assert main(["check", "runs/a"]) == 1
    out = capsys.readouterr().out
    assert out == "runs/a: robot-robot at 12.35 s: robot 0 touches robot 2 (and 1 more)\n"
    assert main(["check", "runs/a", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["violations"][0]["robots"] == [0, 2]

    wall = Violation("robot-obstacle", 3.0, (1,), "robot 1 is too near", 0.0, 0.0, "event at 2 s")
    _fake_check(monkeypatch, Report((wall,), figures))
    assert main(["check", "runs/a"]) == 1
    out = capsys.readouterr().out
    assert out == "runs/a: robot-obstacle at 3.00 s: robot 1 is too near; touched: event at 2 s\n"
    assert main(["check", "runs/a", "--json"]) == 1
    said = json.loads(capsys.readouterr().out)
    assert said["violations"][0]["obstacle"] == "event at 2 s"
    assert said["figures"]["min_footprint_gap_m"] == 0.212

    _fake_check(monkeypatch, RecordingError("there is no such folder", file="runs/a"))
    assert _refused(["check", "runs/a"], capsys) == "cavalcade: runs/a: there is no such folder\n"


def test_warnings_are_one_line_on_stderr(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    module = types.ModuleType("cavalcade.checking")

    def check(directory: Path) -> Any:
        warnings.simplefilter("default")
        warnings.warn("grey 205\nis free", UserWarning, stacklevel=2)
        return types.SimpleNamespace(ok=True, violations=(), figures=None)

    module.check = check  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "cavalcade.checking", module)
    assert main(["check", "runs/a"]) == 0
    assert capsys.readouterr().err == "cavalcade: warning: grey 205 is free\n"


def test_show_draws_where_it_is_asked_to(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    drawn: list[Any] = []
    module = types.ModuleType("cavalcade.drawing.overview")
    module.draw_scenario = lambda *arguments: drawn.append(arguments)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "cavalcade.drawing.overview", module)
    monkeypatch.chdir(tmp_path)
    assert main(["show", "cone"]) == 0
    assert main(["show", "maze-solo", "--out", "b.pdf", "--set", "name=a/b ", "--quiet"]) == 0
    assert capsys.readouterr().out == "cone.png\n"
    assert [call[2] for call in drawn] == [Path("cone.png"), Path("b.pdf")]
    assert drawn[1][0].world.generate is None  # the very obstacles that are drawn


def _command(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "cavalcade", *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        **options,
    )


def test_listing_imports_nothing_heavy() -> None:
    code = (
        "import sys; from cavalcade.cli import main; main(['scenarios']); "
        "heavy = {'numpy', 'numba', 'scipy', 'matplotlib', 'rosbags', 'PIL'}; "
        "sys.exit(', '.join(sorted(heavy & set(sys.modules))) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr


def test_exit_codes_reach_the_shell(tmp_path: Path) -> None:
    done = _command("run", "no-such", "--out", str(tmp_path / "a"))
    assert done.returncode == 2
    assert done.stderr.startswith("cavalcade: no-such: no such file or shipped scenario")
    assert "Traceback" not in done.stderr
    assert os.listdir(tmp_path) == []


def test_a_reader_who_has_seen_enough_is_no_error() -> None:
    writer = subprocess.Popen(
        [sys.executable, "-m", "cavalcade", "schema"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert writer.stdout is not None
    assert writer.stderr is not None
    writer.stdout.close()
    error = writer.stderr.read()
    writer.stderr.close()
    writer.wait(timeout=60)
    assert "Traceback" not in error
