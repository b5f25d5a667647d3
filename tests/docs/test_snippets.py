"""What the documentation shows does what it says; see docs/project/documentation.md."""

from __future__ import annotations

import re
import shlex
import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

import cavalcade as cv
from cavalcade.campaign.report import worst
from cavalcade.campaign.suite import parse_suite
from cavalcade.cli import main
from cavalcade.live.team_file import parse_team
from cavalcade.robots import MODELS

from .pages import LESSONS, LIVE, PAGES, ROOT, Block, blocks, name_of

RUN = ("python", "sh")
ALONE = [
    page
    for page in PAGES
    if page not in LESSONS + LIVE and any(one.is_run for one in blocks(page, *RUN))
]


@pytest.fixture(autouse=True)
def few_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of a campaign's worst trials are repeated for its report."""
    monkeypatch.setattr(worst, "MOST", 2)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder but for the map that pages call theirs; models registered there are gone."""
    known = set(MODELS)
    monkeypatch.chdir(tmp_path)
    cv.save_map(cv.OccupancyMap.empty((14.0, 10.0)), "lab.yaml")
    yield tmp_path
    for name in set(MODELS) - known:
        MODELS.remove(name)


@pytest.fixture(scope="module")
def done() -> dict[str, Path]:
    """What commands left: one that several pages show is run once."""
    return {}


def run_page(page: Path, done: dict[str, Path]) -> None:
    """Everything on the page in its order; python blocks share their names."""
    names: dict[str, Any] = {}
    for number, block in enumerate(blocks(page)):
        if block.title:
            Path(block.title).write_text(block.code, encoding="utf-8")
        if not block.is_run:
            continue
        if block.language == "python":
            exec(compile(block.code, f"{name_of(page)}[{number}]", "exec"), names)
        elif block.language == "sh":
            run_commands(block, done)


def run_commands(block: Block, done: dict[str, Path]) -> None:
    for line in block.code.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if not words:
            continue
        if words[0] == "cavalcade":
            out, job = output_and_job(words)
            if out is None or any(Path(word).exists() for word in words):
                job = ""  # of files that are this page's
            if out is not None and job in done:
                shutil.copytree(done[job], out)
                continue
            assert main(briefly(words[1:])) == block.exit_code, line
            if job and out is not None and out.is_dir():
                done[job] = out.resolve()
        elif words[0] == "make":
            targets = re.findall(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text("utf-8"), re.M)
            assert set(words[1:]) <= set(" ".join(targets).split()), line
        elif words[:2] == ["pip", "install"]:
            project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
            asked = re.findall(r"[\w-]+", "".join(re.findall(r"\[(.*?)\]", line)))
            assert set(asked) <= set(project["optional-dependencies"]), line
        else:
            raise AssertionError(f"this cannot be run: {line}; say so in its first line")


def output_and_job(words: list[str]) -> tuple[Path | None, str]:
    """The folder that a command writes, and the command without it."""
    if "--out" not in words:
        return None, shlex.join(words)
    at = words.index("--out")
    return Path(words[at + 1]), shlex.join(words[:at] + words[at + 2 :])


def briefly(words: list[str]) -> list[str]:
    """A campaign with 20 s of the first world of each group; other commands as is.

    That is long enough for the trial that a page repeats, which has to succeed.
    The suite that the pages show is run as it is by `tests/campaign/test_smoke.py`.
    """
    if words[0] != "campaign":
        return words
    return [*words, "--seeds", "1", "--workers", "1", "--set", "execution.timeout=20"]


@pytest.mark.slow
@pytest.mark.parametrize("page", ALONE, ids=name_of)
def test_the_snippets_of_a_page_run(page: Path, folder: Path, done: dict[str, Path]) -> None:
    if any("mujoco" in one.code or "LegControl" in one.code for one in blocks(page, *RUN)):
        pytest.importorskip("mujoco")
    run_page(page, done)


@pytest.mark.slow
def test_the_tutorial_runs_from_the_first_to_the_last_page(
    folder: Path, done: dict[str, Path]
) -> None:
    pytest.importorskip("mujoco")
    for page in LESSONS:
        run_page(page, done)
    for run in ("first", "hall", "rovers"):
        assert cv.check(folder / "runs" / run).ok


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "yaml")], ids=name_of)
def test_files_on_a_page_can_be_read(page: Path, folder: Path) -> None:
    for lesson in LESSONS:
        for block in blocks(lesson, "yaml"):
            Path(block.title).write_text(block.code, encoding="utf-8")
    cv.save_map(cv.OccupancyMap.empty((10.0, 6.0)), "hall.yaml")
    for block in blocks(page, "yaml"):
        data = yaml.safe_load(block.code)
        if "suite" in data:
            parse_suite(data)
        elif "version" in data and "task" not in data and "world" not in data:
            parse_team(data)
        elif "version" in data:
            cv.parse_scenario(data)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_blocks_say_what_they_are(page: Path) -> None:
    for block in blocks(page):
        assert block.language in {"", "python", "sh", "yaml"}
        command = re.match(r"\$ |(cavalcade|make|pip|python3?|ros2) ", block.code)
        assert block.language or not command, "a block of commands is `sh`"
    fences = re.findall(r"^```", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(fences) == 2 * len(blocks(page)), "a block is not understood"
