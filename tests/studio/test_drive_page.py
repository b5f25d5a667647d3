"""The tab Drive in a real browser: what the page shows, and what Python did."""

from __future__ import annotations

import contextlib
import json
import math
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.studio.app import Studio
from cavalcade.studio.drive.result import DOWNLOAD, EXPORT, STUDY
from cavalcade.studio.drive.tools import AWAY, BACK, BOX, DELETE, WAYPOINT
from cavalcade.studio.drive.transport import EMERGENCY

sys.path.insert(0, str(Path(__file__).parents[1] / "live"))
from fake_fleet import FakeFleet

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
TIMES = {"wall_time_s", "planning_time_s", "cycle_ms", "real_time_factor"}


@pytest.fixture
def driving(studio: Studio) -> Studio:
    """A studio with a scenario, in the tab Drive."""
    studio.build.draft.replace(WORDS)
    studio.choose("Drive")
    return studio


def press(page: Any, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def key(page: Any, name: str) -> None:
    page.locator("body").press(name)


def unfold(page: Any, name: str) -> None:
    page.get_by_text(name, exact=True).click()


def choose(page: Any, label: str, option: str) -> None:
    page.get_by_label(label, exact=True).first.click()
    page.get_by_role("option", name=option, exact=True).click()


def use(page: Any, studio: Studio, until: Any, tool: str) -> None:
    """Let clicks do something else, and the page know it."""
    choose(page, "A click", tool)
    until(page, lambda: studio.drive._tools._tool == tool, "the tool")
    page.wait_for_timeout(500)


def type_in(page: Any, label: str, value: str) -> None:
    box = page.get_by_label(label, exact=True).first
    box.fill(value)
    box.press("Enter")


def shown(page: Any, text: str) -> Callable[[], bool]:
    return lambda: page.get_by_text(text).first.is_visible()


def begun(page: Any, studio: Studio, until: Any, faster: float | None = None) -> Any:
    """Start it and see it run."""
    if faster is not None:
        studio.drive._transport._speed.value = faster
    press(page, "Start")
    until(page, lambda: studio.drive.drive is not None, "the drive")
    drive = studio.drive.drive
    until(page, lambda: drive.snapshot() is not None, "the first moment", 180.0)
    return drive


def on_screen(
    studio: Studio, page: Any, x: float, y: float, z: float = 0.06
) -> tuple[float, float]:
    """Where a point of the map is on the page, px."""
    client = next(iter(studio.session.server.get_clients().values()))
    camera, box = client.camera, page.locator("canvas").first.bounding_box()
    eye = np.array(camera.position)
    ahead = np.array(camera.look_at) - eye
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, camera.up_direction)
    right /= np.linalg.norm(right)
    away = np.array([x, y, z]) - eye
    half = math.tan(camera.fov / 2.0) * (away @ ahead)
    across = (away @ right) / (half * box["width"] / box["height"])
    up = (away @ np.cross(right, ahead)) / half
    return (
        box["x"] + (1.0 + across) / 2.0 * box["width"],
        box["y"] + (1.0 - up) / 2.0 * box["height"],
    )


def drag(
    studio: Studio,
    page: Any,
    start: tuple[float, float],
    way: tuple[float, float],
    moved: Callable[[], Any],
) -> None:
    """Drag from a place so far, until it has come about; a handle that is missed turns the view."""
    for _ in range(5):
        page.mouse.move(*on_screen(studio, page, *start))
        page.wait_for_timeout(400)
        page.mouse.down()
        for part in np.linspace(0.1, 1.0, 10):
            x, y = (a + part * b for a, b in zip(start, way, strict=True))
            page.mouse.move(*on_screen(studio, page, x, y))
            page.wait_for_timeout(30)
        page.mouse.up()
        for _ in range(50):
            if moved():
                return
            page.wait_for_timeout(20)
    raise AssertionError("it cannot be dragged")


ARROW = 0.7
"""From a pose to the arrow by which it is moved along x or y, m."""

HANDLE = 0.22
"""From a pose to the middle of the square by which it is moved along x and y, m."""


def test_keys_start_pause_step_and_stop(driving: Studio, page: Any, until: Any) -> None:
    until(page, shown(page, "Ready"), "what can be done")
    key(page, " ")
    until(page, lambda: driving.drive.drive is not None, "the drive")
    drive = driving.drive.drive
    until(page, lambda: drive.phase == "running", "the run", 180.0)
    until(page, shown(page, "× real time"), "the pace")
    key(page, " ")
    until(page, lambda: drive.phase == "paused", "the pause")
    until(page, shown(page, "Paused"), "the word")
    time = drive.time
    key(page, "ArrowRight")
    until(page, lambda: drive.time == pytest.approx(time + 0.05), "the step")
    assert drive.phase == "paused"
    key(page, " ")
    until(page, lambda: drive.phase == "running" and drive.time > time + 0.2, "going on")
    key(page, "Escape")
    until(page, lambda: drive.phase == "ended", "the end")
    until(page, shown(page, "finished by hand"), "the reason")
    until(page, shown(page, STUDY), "the result")


def test_the_goal_is_dragged_on_the_way_and_at_the_end(
    driving: Studio, page: Any, until: Any
) -> None:
    drive = begun(page, driving, until, 5.0)
    until(page, lambda: len(driving.drive._tools._gizmos) == 1, "the goal's handle")
    page.wait_for_timeout(500)
    start = (8.0 + HANDLE, 4.0 + HANDLE)
    drag(driving, page, start, (-2.0, -1.0), lambda: drive.goals[0] != (8.0, 4.0, 0.0))
    until(page, lambda: drive.goals[0][:2] == pytest.approx((6.0, 3.0), abs=0.25), "its place")
    until(page, lambda: drive.phase == "waiting", "arrival")
    until(page, shown(page, "Arrived. Drag the goal"), "the word")
    x, y, _ = drive.goals[0]
    # By the arrow: robots stand beside.
    drag(driving, page, (x, y + ARROW), (0.0, 1.5), lambda: drive.goals[0][1] > y + 1.0)
    until(page, lambda: drive.phase == "waiting", "arrival")
    assert drive.snapshot().poses[:, 1].mean() == pytest.approx(drive.goals[0][1], abs=0.3)
    kinds = {event.kind for event in drive.scenario.execution.events}
    assert kinds == {"goals"}


def test_played_exported_and_run_on_the_command_line(
    driving: Studio, page: Any, until: Any, tmp_path: Path
) -> None:
    drive = begun(page, driving, until, 0.5)
    use(page, driving, until, BOX)
    page.mouse.click(*on_screen(driving, page, 5.0, 3.2, 0.0))
    until(page, lambda: len(drive.snapshot().obstacles) == 1, "the obstacle")
    use(page, driving, until, WAYPOINT)
    page.mouse.click(*on_screen(driving, page, 7.0, 5.0, 0.0))
    until(page, lambda: len(drive.goals) == 2, "the waypoint")
    unfold(page, "Robots")
    choose(page, "Robot", "1")
    press(page, AWAY)
    until(page, lambda: drive.lost == (1,), "its loss")
    until(page, shown(page, "without robot 1"), "the word")
    press(page, BACK)
    until(page, lambda: drive.lost == (), "its return")
    driving.drive._transport._speed.value = 10.0
    drive.set_speed(10.0)
    until(page, lambda: drive.phase == "waiting", "arrival", 90.0)
    press(page, "Stop")
    until(page, lambda: drive.phase == "ended", "the end")
    until(page, shown(page, "simulated time"), "the table")
    with page.expect_download() as loading:
        press(page, EXPORT)
    file = tmp_path / loading.value.suggested_filename
    assert file.name == "driven.yaml"
    loading.value.save_as(file)
    command = [sys.executable, "-m", "cavalcade", "run", str(file), "--out", str(tmp_path / "out")]
    subprocess.run([*command, "--quiet"], check=True)
    again = json.loads((tmp_path / "out" / "summary.json").read_text())
    mine = drive.summary.to_dict()
    assert [event.kind for event in drive.played.execution.events] == [
        "add", "goals", "lose", "rejoin",
    ]  # fmt: skip
    assert {k: v for k, v in again.items() if k not in TIMES} == {
        k: v for k, v in mine.items() if k not in TIMES
    }
    with page.expect_download() as loading:
        press(page, DOWNLOAD)
    assert loading.value.suggested_filename == "driven-1.html"
    press(page, STUDY)
    until(page, lambda: driving.chosen == "Study", "the tab")


def test_an_obstacle_is_picked_moved_and_deleted(driving: Studio, page: Any, until: Any) -> None:
    drive = begun(page, driving, until, 0.2)
    unfold(page, "Obstacles")

    def click(x: float, y: float) -> Callable[[], bool]:
        def act() -> bool:
            page.mouse.click(*on_screen(driving, page, x, y, 0.3))
            page.wait_for_timeout(200)
            return driving.drive._tools._selected is not None

        return act

    until(page, click(5.0, 6.0), "the pick")
    until(page, shown(page, "at (5.00, 6.00) m"), "the word")
    type_in(page, "Moves at (m/s)", "0")
    until(page, lambda: driving.drive._tools._obstacle_speed.value == 0.0, "at once")
    moved = (5.0 + ARROW, 6.0), (1.0, 0.0), lambda: len(drive.snapshot().obstacles) == 1
    drag(driving, page, *moved)

    def there() -> bool:
        return drive.snapshot().obstacles[0].center == pytest.approx((6.0, 6.0), abs=0.25)

    until(page, there, "the new place")
    until(page, click(*drive.snapshot().obstacles[0].center), "the pick")
    press(page, DELETE)
    until(page, lambda: drive.snapshot().obstacles == (), "its end")


def test_wrong_clicks_end_in_words(studio: Studio, page: Any, until: Any) -> None:
    press(page, "Drive")
    until(page, lambda: studio.chosen == "Drive", "the tab")
    until(page, shown(page, "Nothing to drive yet"), "what is missing")
    press(page, "Start")
    until(page, shown(page, "there is nothing to drive yet"), "the words")
    unfold(page, "Robots")
    press(page, AWAY)
    until(page, shown(page, "nothing is driven yet"), "the words")
    studio.build.draft.replace(WORDS)
    drive = begun(page, studio, until)
    press(page, BACK)
    until(page, shown(page, "is not lost"), "the words")
    press(page, "Push")
    until(page, shown(page, "only robots in physics"), "the words")
    press(page, "Pause")
    until(page, lambda: drive.phase == "paused", "the pause")
    use(page, studio, until, BOX)
    words = page.get_by_text("That does not work")  # over the scene, for some seconds
    until(page, lambda: words.count() == 0, "the end of the words so far")
    x, y, _ = drive.snapshot().poses[0]
    page.mouse.click(*on_screen(studio, page, float(x), float(y), 0.0))
    until(page, shown(page, "stands there"), "the words")
    press(page, "Stop")
    until(page, lambda: drive.phase == "ended", "the end")
    press(page, AWAY)
    until(page, shown(page, "the run is over"), "the words")


def test_restart_begins_anew(driving: Studio, page: Any, until: Any) -> None:
    drive = begun(page, driving, until)
    until(page, lambda: drive.time > 0.3, "some time")
    press(page, "Restart")
    until(page, lambda: driving.drive.drive is not drive, "another drive")
    until(page, lambda: driving.drive.drive.snapshot() is not None, "its first moment")
    assert drive.phase == "ended"
    assert drive.folder.name == "driven-1"
    press(page, "Stop")
    until(page, lambda: driving.drive.drive.phase == "ended", "the end")
    assert driving.drive.drive.folder.name == "driven-2"


def test_two_tabs_see_one_session_and_one_drives(
    driving: Studio, open_page: Any, until: Any
) -> None:
    first = open_page()
    second = open_page()
    roles = driving.session.roles
    until(second, shown(second, "You watch"), "the second's line")
    until(first, shown(first, "1 other watches"), "the first's line")
    press(second, "Start")
    until(second, shown(second, "Another tab drives"), "the words")
    assert driving.drive.drive is None
    drive = begun(first, driving, until, 0.5)
    until(second, shown(second, "× real time"), "the pace on the second")
    before = roles.driver
    press(second, "Ask to drive")
    until(first, shown(first, "Somebody else wants to drive"), "the question")
    press(first, "Keep driving")
    until(second, shown(second, "keeps on driving"), "the answer")
    assert roles.driver == before
    press(second, "Ask to drive")
    until(first, shown(first, "Let them drive"), "the question")
    press(first, "Let them drive")
    until(second, lambda: roles.driver != before, "the change")
    press(second, "Pause")
    until(second, lambda: drive.phase == "paused", "the pause")
    key(first, " ")
    until(first, shown(first, "Another tab drives"), "the words")
    assert drive.phase == "paused"
    press(second, "Resume")
    until(second, lambda: drive.phase == "running", "going on")
    second.close()
    until(first, lambda: roles.driver == before, "the next one drives")
    assert drive.phase == "running"
    press(first, "Stop")
    until(first, lambda: drive.phase == "ended", "the end")


def test_a_closed_tab_stops_a_live_fleet(driving: Studio, open_page: Any, until: Any) -> None:
    fleet = FakeFleet([robot["start"] for robot in WORDS["robots"]])
    words = {**WORDS, "execution": {"backend": "ros2", "rate": 5, "timeout": 60}}
    driving.build.draft.replace(words)
    driving.drive.make_fleet = lambda team: fleet
    first, second = open_page(), open_page()
    drive = begun(first, driving, until)
    until(first, lambda: bool(np.any(fleet.sent[-1][1])), "motion")
    until(second, shown(second, EMERGENCY), "the button of one who watches")
    first.close()
    until(second, lambda: drive.phase == "stopped", "the stop")
    count = len(fleet.sent)
    until(second, lambda: len(fleet.sent) > count + 3, "some cycles")
    assert all(not np.any(sent) for _, sent in fleet.sent[count:])
    until(second, shown(second, "was closed or cut off"), "the words")
    press(second, "Resume")
    until(second, lambda: bool(np.any(fleet.sent[-1][1])), "motion")
    press(second, EMERGENCY)
    until(second, lambda: drive.phase == "stopped" and not np.any(fleet.sent[-1][1]), "the stop")
    press(second, "End")
    until(second, lambda: drive.phase == "ended", "the end")
    assert fleet.closed


class Cable:
    """A detour to a server that can be pulled: nothing is closed, and nothing arrives."""

    def __init__(self, port: int) -> None:
        self._to = port
        self._held = threading.Event()
        self._door = socket.create_server(("127.0.0.1", 0))
        self.port = self._door.getsockname()[1]
        self._ends: list[socket.socket] = [self._door]
        threading.Thread(target=self._accept, daemon=True).start()

    def pull(self) -> None:
        self._held.set()

    def close(self) -> None:
        self._held.set()
        for end in self._ends:
            end.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                inner, _ = self._door.accept()
                outer = socket.create_connection(("127.0.0.1", self._to))
                self._ends += [inner, outer]
                for one, other in ((inner, outer), (outer, inner)):
                    threading.Thread(target=self._pass, args=(one, other), daemon=True).start()

    def _pass(self, one: socket.socket, other: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while content := one.recv(65536):
                if self._held.is_set():
                    return
                other.sendall(content)
            other.shutdown(socket.SHUT_WR)


def test_a_pulled_cable_stops_a_live_fleet(driving: Studio, open_page: Any, until: Any) -> None:
    fleet = FakeFleet([robot["start"] for robot in WORDS["robots"]])
    words = {**WORDS, "execution": {"backend": "ros2", "rate": 5, "timeout": 60}}
    driving.build.draft.replace(words)
    driving.drive.make_fleet = lambda team: fleet
    cable = Cable(driving.session.server.get_port())
    try:
        first, second = open_page(port=cable.port), open_page()
        drive = begun(first, driving, until)
        until(first, lambda: bool(np.any(fleet.sent[-1][1])), "motion")
        cable.pull()
        # viser by itself notices after 20 to 40 s.
        until(second, lambda: drive.phase == "stopped", "the stop", 15.0)
        until(second, lambda: not np.any(fleet.sent[-1][1]), "zeros")
        until(second, shown(second, "was closed or cut off"), "the words")
        until(second, lambda: driving.session.driver is not None, "the other one drives")
        until(
            second,
            lambda: len(driving.drive._heartbeat._watches) == 1,
            "only who is there is watched",
        )
    finally:
        cable.close()


def test_a_simulation_goes_on_when_its_driver_leaves(
    driving: Studio, open_page: Any, until: Any
) -> None:
    first, second = open_page(), open_page()
    drive = begun(first, driving, until, 0.5)
    first.close()
    time = drive.time
    until(second, lambda: drive.time > time + 0.3, "going on")
    until(second, shown(second, "you drive now"), "the words")
    press(second, "Pause")
    until(second, lambda: drive.phase == "paused", "the pause")


def test_light_and_dark(driving: Studio, page: Any, until: Any) -> None:
    scheme = "() => document.documentElement.getAttribute('data-mantine-color-scheme')"
    until(page, lambda: page.evaluate(scheme) == "dark", "dark")
    page.get_by_role("checkbox", name="Dark").click()
    until(page, lambda: page.evaluate(scheme) == "light", "light")
    assert not driving.session.dark
