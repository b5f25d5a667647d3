"""`cavalcade import`: a scenario file, or one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from cavalcade.cli import main
from cavalcade.scenario import load_scenario

_PROBLEM = """
environment:
  min: [0, 0]
  max: [5, 5]
  obstacles: []
robots:
  - type: unicycle_first_order_0
    start: [1, 2.5, 0]
    goal: [4, 2.5, 0]
"""


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    path = tmp_path / "swap.yaml"
    path.write_text(_PROBLEM, encoding="utf-8")
    return path


def test_a_problem_becomes_a_scenario(
    problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "s.yaml"
    assert main(["import", str(problem), "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    scenario = load_scenario(out)
    assert (scenario.name, scenario.goals) == ("swap", ((4.0, 2.5, 0.0),))
    assert main(["import", str(problem), "--out", str(out), "--force", "--quiet"]) == 0
    assert capsys.readouterr().out == ""


def test_what_is_there_is_kept(
    problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "s.yaml"
    out.write_text("mine", encoding="utf-8")
    assert main(["import", str(problem), "--out", str(out)]) == 2
    assert "is there already; --force replaces it" in capsys.readouterr().err
    assert out.read_text(encoding="utf-8") == "mine"
    assert main(["import", str(problem), "--out", str(tmp_path)]) == 2
    assert "is a folder" in capsys.readouterr().err
    assert main(["import", str(problem), "--out", str(tmp_path / "no" / "s.yaml")]) == 2
    assert "cannot be written" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("unicycle_first_order_0", "car_first_order_with_1_trailers_0", "has a trailer"),
        ("[1, 2.5, 0]", "[1, 9.5, 0", "not valid YAML"),
        ("environment", "surroundings", "unknown format; known are db-CBS problems"),
        (
            "obstacles: []",
            "obstacles: [{type: box, center: [1, 2], size: [1, 2]}]",
            "stands in wor",
        ),
    ],
)
def test_what_cannot_be_imported_is_two_and_one_line(
    problem: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    old: str,
    new: str,
    message: str,
) -> None:
    problem.write_text(_PROBLEM.replace(old, new), encoding="utf-8")
    out = tmp_path / "s.yaml"
    assert main(["import", str(problem), "--out", str(out)]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.startswith(f"cavalcade: {problem}: ")
    assert said.count("\n") == 1
    assert not out.exists()
