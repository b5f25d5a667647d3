from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cavalcade.errors import OutputError
from cavalcade.jobs.output_folder import OutputFolder
from cavalcade.scenario import load_scenario

SUMMARY = {"name": "x", "success": True}


def fill(folder: OutputFolder) -> None:
    (folder.stage / "recording.mcap").write_bytes(b"1")
    (folder.stage / "replay.html").write_text("2")
    (folder.stage / "figures").mkdir()
    (folder.stage / "figures" / "sequence.png").write_bytes(b"3")


def names(folder: Path) -> list[str]:
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file())


ALL = ["figures/sequence.png", "recording.mcap", "replay.html", "scenario.yaml", "summary.json"]


@pytest.mark.parametrize("exists", [True, False])
def test_everything_is_put_in_place(
    tmp_path: Path, exists: bool, make_scenario: Callable[..., Any]
) -> None:
    target = tmp_path / "a" / "b"
    if exists:
        target.mkdir(parents=True)
    with OutputFolder(target) as folder:
        fill(folder)
        files = folder.commit(make_scenario(), SUMMARY)
    assert names(target) == ALL
    assert sorted(str(file.relative_to(target)) for file in files) == ALL
    assert [entry.name for entry in target.iterdir() if entry.name.startswith(".")] == []
    assert json.loads((target / "summary.json").read_text()) == SUMMARY
    assert load_scenario(target / "scenario.yaml") == make_scenario()


@pytest.mark.parametrize("exists", [True, False])
@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_nothing_is_left_when_it_is_cut_short(
    tmp_path: Path, exists: bool, error: type[BaseException]
) -> None:
    target = tmp_path / "a" / "b"
    if exists:
        target.mkdir(parents=True)

    def cut_short() -> None:
        with OutputFolder(target) as folder:
            fill(folder)
            raise error

    with pytest.raises(error):
        cut_short()
    assert list(tmp_path.rglob("*")) == ([tmp_path / "a", target] if exists else [])


def test_a_folder_that_holds_something_is_refused(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(OutputError, match="not empty"):
        OutputFolder(tmp_path)
    assert names(tmp_path) == ["thesis.tex"]


def test_force_replaces_results_and_nothing_else(
    tmp_path: Path, make_scenario: Callable[..., Any]
) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    (tmp_path / "summary.json").write_text("old")
    (tmp_path / "plan.npz").write_text("old")
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "old.png").write_text("old")
    (tmp_path / "figures" / "mine.svg").write_text("mine")
    with OutputFolder(tmp_path, force=True) as folder:
        fill(folder)
        folder.commit(make_scenario(), SUMMARY)
    assert names(tmp_path) == sorted([*ALL, "figures/mine.svg", "thesis.tex"])


def test_force_keeps_the_old_results_until_the_new_are_whole(tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text("old")

    def fail() -> None:
        with OutputFolder(tmp_path, force=True) as folder:
            fill(folder)
            raise ValueError

    with pytest.raises(ValueError):
        fail()
    assert names(tmp_path) == ["summary.json"]


def test_what_a_killed_run_left_is_no_result(
    tmp_path: Path, make_scenario: Callable[..., Any]
) -> None:
    (tmp_path / ".cavalcade-abc").mkdir()
    with OutputFolder(tmp_path) as folder:
        fill(folder)
        folder.commit(make_scenario(), SUMMARY)
    assert "summary.json" in names(tmp_path)


def test_a_file_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="expected a folder"):
        OutputFolder(tmp_path / "file")
    with pytest.raises(OutputError, match="cannot be written"):
        OutputFolder(tmp_path / "file" / "below")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission(tmp_path: Path) -> None:
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    with pytest.raises(OutputError, match="cannot be written"):
        OutputFolder(closed / "run")


def test_a_folder_that_the_system_refuses() -> None:
    with pytest.raises(OutputError, match="cannot be written"):
        OutputFolder("/proc/cavalcade/run")


def test_numbers_that_json_does_not_know_never_get_out(
    tmp_path: Path, make_scenario: Callable[..., Any]
) -> None:
    with pytest.raises(ValueError), OutputFolder(tmp_path / "r") as folder:
        folder.commit(make_scenario(), {"value": float("nan")})
    assert list(tmp_path.iterdir()) == []
