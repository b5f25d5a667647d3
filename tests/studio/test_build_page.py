"""The tab Build in a real browser: what the page shows, and what the draft holds."""

from __future__ import annotations

import math
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cavalcade.scenario import load_scenario
from cavalcade.studio.app import Studio
from cavalcade.studio.build.guide import QUICK

MOVINGAI = b"type octile\nheight 40\nwidth 60\nmap\n" + 40 * (60 * b"." + b"\n")

Until = Callable[..., None]


@pytest.fixture
def page(studio: Studio, open_page: Callable[..., Any]) -> Any:
    """The page with the tab Build chosen."""
    opened = open_page(1280, 900)
    opened.get_by_text("Next: add robots").wait_for()
    return opened


def _status(page: Any, words: str) -> None:
    page.locator("div[class^=cavalcade-]", has_text=words).first.wait_for()


def _button(page: Any, name: str) -> Any:
    return page.get_by_role("button", name=name, exact=True)


def _open(page: Any, folder: str) -> None:
    page.get_by_text(folder, exact=True).last.click()
    page.wait_for_timeout(300)


def _field(page: Any, label: str) -> Any:
    """The input beside a label; viser does not tie the two together."""
    found = f"xpath=//label[normalize-space()='{label}']/ancestor::*[.//input][1]//input"
    return page.locator(found).first


def _type(page: Any, label: str, text: str) -> Any:
    field = _field(page, label)
    field.scroll_into_view_if_needed()
    field.fill(text)
    return field


def _upload(page: Any, name: str, content: bytes) -> None:
    files = [{"name": name, "mimeType": "application/octet-stream", "buffer": content}]
    page.locator("input[type=file]").set_input_files(files)


def _ground(page: Any, studio: Studio, x: float, y: float) -> tuple[float, float]:
    """Where on the page a point of the ground is, with a camera that looks straight down."""
    client = next(iter(studio.session.server.get_clients().values()))
    client.camera.position, client.camera.look_at = (7.0, 4.99, 16.0), (7.0, 5.0, 0.0)
    page.wait_for_timeout(600)
    box = page.locator("canvas").first.bounding_box()
    scale = box["height"] / (2.0 * 16.0 * math.tan(client.camera.fov / 2.0))
    middle = (box["x"] + box["width"] / 2.0, box["y"] + box["height"] / 2.0)
    return middle[0] + scale * (x - 7.0), middle[1] - scale * (y - 5.0)


def test_from_an_empty_page_to_a_scenario_that_runs(
    studio: Studio, page: Any, until: Until, tmp_path: Path
) -> None:
    begun = time.monotonic()
    _button(page, QUICK).click()
    _status(page, "Ready to run: 4 go1, square, 1 goal, ideal")
    assert studio.build.draft.scenario is not None
    with page.expect_download() as coming:
        _button(page, "Download YAML").click()
    assert time.monotonic() - begun < 60.0
    file = tmp_path / coming.value.suggested_filename
    coming.value.save_as(file)
    assert file.name == "my-scenario.yaml"
    assert load_scenario(file) == studio.build.draft.scenario
    shown = subprocess.run(
        [sys.executable, "-m", "cavalcade", "show", str(file), "--out", str(tmp_path / "a.png")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert shown.returncode == 0, shown.stderr


def test_obstacles_and_goals_are_drawn_by_clicks(studio: Studio, page: Any, until: Until) -> None:
    draft = studio.build.draft
    _button(page, QUICK).click()
    _status(page, "Ready to run:")
    _button(page, "Box").click()
    _status(page, "Click one corner of the box")
    page.mouse.click(*_ground(page, studio, 6.0, 4.0))
    _status(page, "Now click the opposite corner")
    page.mouse.click(*_ground(page, studio, 7.0, 5.5))
    until(page, lambda: draft.data["world"].get("obstacles"), "the box")
    box = draft.data["world"]["obstacles"][0]["box"]
    assert box["center"] == pytest.approx([6.5, 4.75], abs=0.15)
    assert box["size"] == pytest.approx([1.0, 1.5], abs=0.15)
    _button(page, "Goal").click()
    page.mouse.click(*_ground(page, studio, 11.0, 8.0))
    until(page, lambda: len(draft.data["task"]["goals"]) == 2, "the goal")
    assert draft.data["task"]["goals"][1][:2] == pytest.approx([11.0, 8.0], abs=0.15)
    _status(page, "2 goals")
    _button(page, "Robot").click()
    page.mouse.click(*_ground(page, studio, 6.5, 4.7))
    _status(page, "Not taken")
    _status(page, "stands in world.obstacles[0]")
    assert len(draft.data["robots"]) == 4


def test_a_robot_is_selected_by_a_click_and_deleted(
    studio: Studio, page: Any, until: Until
) -> None:
    draft = studio.build.draft
    _button(page, QUICK).click()
    _status(page, "Ready to run:")
    place = _ground(page, studio, *draft.state.robots[1][1][:2])

    def click() -> bool:
        page.mouse.click(*place)
        page.wait_for_timeout(300)
        return bool(_button(page, "Delete robot 1").count())

    until(page, click, "the selection")
    assert _field(page, "Selected").input_value() == "robot 1"
    _button(page, "Delete robot 1").click()
    _status(page, "Ready to run: 3 go1, triangle")
    assert len(draft.state.robots) == 3


def test_wrong_values_are_refused_in_words_and_the_field_shows_what_holds(
    studio: Studio, page: Any, until: Until
) -> None:
    draft = studio.build.draft
    _button(page, QUICK).click()
    _status(page, "Ready to run:")
    _open(page, "Planner")
    field = _type(page, "lookahead (s)", "-3")
    _status(page, "planner.lookahead: expected greater than 0, got -3")
    until(page, lambda: field.input_value() == "5", "the old value")
    assert "planner" not in draft.data
    field = _type(page, "lookahead (s)", "soon")
    _status(page, "planner.lookahead: expected a number, got 'soon'")
    field = _type(page, "lookahead (s)", "3.5")
    until(page, lambda: draft.data.get("planner", {}).get("lookahead") == 3.5, "the value")
    _status(page, "Ready to run:")
    until(page, lambda: page.get_by_text("Not taken").count() == 0, "the end of the words")


def test_steps_are_undone_and_done_again(studio: Studio, page: Any, until: Until) -> None:
    draft = studio.build.draft
    _button(page, QUICK).click()
    _status(page, "Ready to run:")
    _button(page, "Undo").click()
    _status(page, "Next: add robots")
    assert not draft.state.robots
    _button(page, "Redo").click()
    _status(page, "Ready to run:")
    page.keyboard.press("Control+z")
    _status(page, "Next: add robots")
    page.keyboard.press("Control+Shift+z")
    _status(page, "Ready to run:")
    assert len(draft.state.robots) == 4


def test_a_map_is_uploaded_and_a_team_placed_on_it(studio: Studio, page: Any, until: Until) -> None:
    draft = studio.build.draft
    _button(page, QUICK).click()
    _status(page, "Ready to run:")
    _upload(page, "../my arena.map", MOVINGAI)
    until(page, lambda: "movingai" in draft.data["world"], "the map")
    _status(page, "Ready to run:")
    assert draft.state.world.base.size == (15.0, 10.0)
    assert (studio.session.folder / "uploads" / "my_arena.map").is_file()


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("garbage.yaml", b"\x00\xff\x17", "garbage.yaml: not valid YAML"),
        ("notes.txt", b"hello", "is none of the files that can be used"),
        ("photo.png", b"no picture", "expected a PGM (P2, P5) or PNG picture"),
        ("big.map", b"." * 65_000_000, "big.map: has 65 MB; expected at most 64 MB"),
    ],
)
def test_wrong_uploads_are_refused_in_words(
    studio: Studio, page: Any, name: str, content: bytes, words: str
) -> None:
    before = studio.build.draft.data
    if len(content) > 50_000_000:  # more than Playwright passes on without a file
        file = studio.session.folder / name
        studio.session.folder.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
        page.locator("input[type=file]").set_input_files(file)
    else:
        _upload(page, name, content)
    _status(page, words)
    assert studio.build.draft.data is before
    assert not list((studio.session.folder / "uploads").glob("*.*"))
    _button(page, QUICK).click()
    _status(page, "Ready to run:")


def test_a_shipped_scenario_is_changed_and_saved(studio: Studio, page: Any, until: Until) -> None:
    draft = studio.build.draft
    _field(page, "Begin with").click()
    page.get_by_role("option", name="triangle-lab").click()
    _status(page, "Ready to run: 3 go1, triangle")
    _type(page, "Name", "mine")
    until(page, lambda: draft.data["name"] == "mine", "the name")
    _button(page, "Save in the studio's folder").click()
    file = studio.session.folder / "scenarios" / "mine.yaml"
    until(page, file.is_file, "the file")
    assert load_scenario(file) == draft.scenario
