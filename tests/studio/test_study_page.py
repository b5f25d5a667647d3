"""The tab Study in a real browser: what the page shows and what Python does are the same."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="viser is not installed")

import cavalcade as cv
from cavalcade.scenario import parse_scenario
from cavalcade.studio.app import Studio
from cavalcade.studio.study.curves import curves_of
from cavalcade.studio.study.results import read_result

SCENARIO = {
    "version": 1,
    "name": "told",
    "world": {"empty": {"size": [6.0, 4.0]}},
    "robots": [
        {"model": "go1", "start": [1.0, 1.0, 0.0]},
        {"model": "go1", "start": [1.0, 3.0, 0.0]},
    ],
    "task": {
        "commands": [{"at": 0.0, "robot": k, "velocity": [0.5, 0.0, 0.0]} for k in (0, 1)],
        "duration": 6.0,
    },
    "execution": {
        "events": [{"at": 3.0, "add": {"circle": {"center": [5.5, 2.0], "radius": 0.1}}}]
    },
}


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of six seconds."""
    folder = tmp_path_factory.mktemp("kept") / "told"
    cv.run(parse_scenario(SCENARIO), folder, figures=False, replay=False)
    return folder


@pytest.fixture
def run(kept: Path, tmp_path: Path) -> Path:
    """The same in a folder that may be broken."""
    return Path(shutil.copytree(kept, tmp_path / "results" / "told"))


def field(page: Any, label: str) -> Any:
    """The input beside a label."""
    row = "ancestor::*[contains(@class, 'mantine-Flex-root')][1]"
    return page.locator(f"xpath=//label[normalize-space()='{label}']/{row}//input").first


def open_folder(page: Any, folder: Path | str) -> None:
    field(page, "Folder").fill(str(folder))
    page.wait_for_timeout(300)
    page.get_by_role("button", name="Open this folder").click()


def to_study(page: Any, studio: Studio, until: Callable[..., None]) -> None:
    page.get_by_role("button", name="Study", exact=True).click()
    until(page, lambda: studio.chosen == "Study", "the tab")


def shown_time(page: Any) -> float:
    """What stands beside the slider, s."""
    slider = page.locator(".mantine-Slider-root:visible").first
    return float(slider.locator("xpath=..").locator("input[inputmode]").input_value())


def test_a_run_is_opened_and_scrubbed(
    studio: Studio, page: Any, until: Callable[..., None], run: Path
) -> None:
    to_study(page, studio, until)
    open_folder(page, run)
    until(page, lambda: studio.study.view is not None, "the run")
    view = studio.study.view
    assert view is not None
    page.get_by_text("a run of 6.0 s").wait_for()
    page.get_by_text("simulated time").wait_for()
    track = page.locator(".mantine-Slider-root:visible").first.bounding_box()
    page.mouse.click(track["x"] + 0.5 * track["width"], track["y"] + track["height"] / 2)
    until(page, lambda: 2.0 < view.snapshot.time < 4.0, "the time that was clicked")
    until(page, lambda: abs(shown_time(page) - view.snapshot.time) < 0.011, "the same time")
    expected = 1.0 + 0.5 * view.snapshot.time
    assert abs(view.snapshot.poses[0, 0] - expected) < 0.2


def test_keys_play_and_pause(
    studio: Studio, page: Any, until: Callable[..., None], run: Path
) -> None:
    studio.open(run)
    view = studio.study.view
    assert view is not None
    page.get_by_text("a run of 6.0 s").wait_for()
    box = page.locator("canvas[data-engine]").bounding_box()
    page.mouse.click(box["x"] + 20, box["y"] + box["height"] - 20)
    page.keyboard.press("Space")
    until(page, lambda: view.snapshot.time > 0.3, "play")
    page.get_by_role("button", name="Pause", exact=True).filter(visible=True).wait_for()
    page.keyboard.press("Space")
    play = page.get_by_role("button", name="Play", exact=True).filter(visible=True)
    play.wait_for()
    until(page, lambda: not view.timeline.playback.playing, "the pause")
    stopped = view.timeline.time
    until(page, lambda: abs(shown_time(page) - stopped) < 0.011, "the time")
    page.keyboard.press("ArrowRight")
    until(page, lambda: abs(view.timeline.time - stopped - 0.05) < 1e-6, "a step")


def test_the_end_stops_and_play_begins_anew(
    studio: Studio, page: Any, until: Callable[..., None], run: Path
) -> None:
    studio.open(run)
    view = studio.study.view
    assert view is not None
    page.get_by_role("button", name="End", exact=True).click()
    until(page, lambda: view.timeline.time == view.timeline.playback.end, "the end")
    page.get_by_role("button", name="Play", exact=True).filter(visible=True).click()
    until(page, lambda: 0.0 < view.timeline.time < 3.0, "the start again")


def test_two_runs_on_one_timeline(
    studio: Studio, page: Any, until: Callable[..., None], run: Path, tmp_path: Path
) -> None:
    other = Path(shutil.copytree(run, tmp_path / "results" / "other"))
    summary = json.loads((other / "summary.json").read_text())
    summary["min_robot_distance_m"] += 0.5
    (other / "summary.json").write_text(json.dumps(summary))
    studio.open(run)
    studio.study.compare(other)
    page.get_by_text("+0.50 m").wait_for()
    view = studio.study.view
    assert view is not None
    view.timeline.jump(3.0)
    until(page, lambda: view.snapshot.time == 3.0, "the time")
    studio.study.open(run)
    assert studio.study.view is not view


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nowhere", "there is no such folder"),
        ("empty", "expected the folder of a run"),
        ("broken", "recording.mcap"),
    ],
)
def test_what_is_no_result_is_told_on_the_page(
    studio: Studio, page: Any, until: Callable[..., None], run: Path, name: str, words: str
) -> None:
    (run.parent / "empty").mkdir()
    shutil.copytree(run, run.parent / "broken")
    (run.parent / "broken" / "recording.mcap").write_bytes(b"garbage")
    to_study(page, studio, until)
    open_folder(page, run.parent / name)
    page.get_by_text(words).first.wait_for()
    assert studio.study.view is None
    open_folder(page, run)  # and nothing is lost
    until(page, lambda: studio.study.view is not None, "the run")


def test_a_listed_folder_that_has_vanished_is_told(
    studio: Studio, page: Any, until: Callable[..., None], kept: Path
) -> None:
    inside = Path(shutil.copytree(kept, studio.session.folder / "runs" / "gone"))
    to_study(page, studio, until)
    shutil.rmtree(inside)
    field(page, "Open").click()
    page.get_by_role("option", name="runs/gone").click()
    page.get_by_text("there is no such folder").first.wait_for()


def test_a_campaigns_trials(
    studio: Studio, page: Any, until: Callable[..., None], tmp_path: Path
) -> None:
    folder = tmp_path / "crowds"
    folder.mkdir()
    rows = [
        {"trial": f"crowd.{k:04d}", "outcome": "stuck" if k % 5 == 0 else "arrived",
         "scenario": "crowd", "variant": "cavalcade", "seed": k, "success": k % 5 != 0,
         "summary": {"makespan_s": 30.0 - k}}
        for k in range(23)
    ]  # fmt: skip
    (folder / "trials.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    to_study(page, studio, until)
    open_folder(page, folder)
    page.get_by_text("a campaign of 23 trials").wait_for()
    campaign = studio.study.campaign
    assert campaign is not None
    field(page, "Filter").fill("makespan>")
    page.get_by_text("did you mean makespan_s").wait_for()
    assert len(campaign.shown) == 10
    field(page, "Filter").fill("outcome=stuck")
    until(page, lambda: len(campaign.shown) == 5, "the filter")
    page.get_by_text("5 trials: 5 stuck").wait_for()
    page.get_by_role("button", name="crowd.0015").click()
    page.get_by_text("was kept. It can be run again").wait_for()
    page.get_by_role("button", name="Run it again").click()
    page.get_by_text("campaign.json").first.wait_for()  # this folder has none


def test_curves_of_commands_alone(kept: Path) -> None:
    speeds = {curve.name: curve for curve in curves_of(read_result(kept))}["fastest robot (m/s)"]
    assert abs(speeds.values.max() - 0.5) < 0.1


def test_what_is_taken_along(studio: Studio, page: Any, run: Path, tmp_path: Path) -> None:
    studio.open(run)
    for button, name in (("Scenario (YAML)", "told.yaml"), ("Replay (HTML)", "told.html")):
        with page.expect_download() as got:
            page.get_by_role("button", name=button).click()
        assert got.value.suggested_filename == name
        got.value.save_as(tmp_path / name)
    again = cv.run(tmp_path / "told.yaml")
    kept = json.loads((run / "summary.json").read_text())
    assert list(again.summary["path_length_m"]) == kept["path_length_m"]
    assert "told" in (tmp_path / "told.html").read_text()
