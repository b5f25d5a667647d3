"""The pictures of the studio in the documentation, taken of real pages in Chromium.

    python tools/studio_pictures.py [--out docs/images/studio] [NAME ...]

Building, driving in the arena, four robots walking in physics, studying a run, comparing two, a
campaign; each by day and by night. Needs the extra `test` and Chromium.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import sync_playwright

import cavalcade as cv
from cavalcade.campaign.definition import define_campaign
from cavalcade.campaign.engines import make_engine
from cavalcade.campaign.runner import run_campaign
from cavalcade.geometry import Array
from cavalcade.studio.app import Studio

SIZE = (1440, 810)
PATIENCE = 240.0
"""Longest that something may take, s; a browser without a graphics card is slow."""

_BROWSERS = ("chromium", "chromium-browser", "google-chrome")
_ARGUMENTS = (
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-gl=angle",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
)  # fmt: skip
_QUIET = ".mantine-Notification-root { display: none !important }"
"""viser's own hint that there is no graphics card."""


class Photographer:
    """A studio, a page of it, and what they are asked for."""

    def __init__(self, browser: Any, work: Path) -> None:
        self.work = work
        self.studio = Studio(port=0, folder=work / "studio")
        self.page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        self.page.goto(self.studio.session.address)
        self.page.wait_for_selector("canvas")
        self.page.add_style_tag(content=_QUIET)
        self.wait(lambda: self.studio.session.server.get_clients())

    def close(self) -> None:
        """End both."""
        self.page.close()
        self.studio.close()

    def wait(self, condition: Callable[[], Any], settle: float = 0.0) -> None:
        """Until something holds, and a little more, s."""
        end = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError("what was to be photographed has not come about")
            self.page.wait_for_timeout(50)
        self.page.wait_for_timeout(1e3 * settle)

    def show(self, label: str) -> None:
        """Bring a part of the panel that has this text into view, if there is one."""
        place = self.page.get_by_text(label, exact=True)
        if place.count():
            place.first.scroll_into_view_if_needed()

    def look(self, place: Array, east: float, north: float, up: float) -> None:
        """Look at a place `(2,)` from so far, m."""
        x, y = map(float, place)
        for client in self.studio.session.server.get_clients().values():
            with client.atomic():
                client.camera.position = (x + east, y + north, up)
                client.camera.look_at = (x, y, 0.1)


def build(on: Photographer) -> None:
    """A team in the arena, with its goal, before it starts."""
    on.studio.build.draft.load("square-clutter")
    on.studio.choose("Build")
    on.studio.session.stage.frame_team()
    on.wait(lambda: True, 2.0)


def drive(on: Photographer) -> None:
    """Half-way through the arena, with a goal to drag and obstacles to put down."""
    on.studio.build.draft.load("square-clutter")
    _drive_until(on, 11.0)


def walk(on: Photographer) -> None:
    """Four Go1s on legs, in physics."""
    draft = on.studio.build.draft
    draft.load("square-clutter")
    draft.set("execution.backend", "mujoco")
    _drive_until(on, 5.0)
    on.look(on.studio.drive.drive.snapshot().poses[:, :2].mean(axis=0), 1.6, -2.3, 1.5)
    on.wait(lambda: True, 1.5)


def study(on: Photographer) -> None:
    """The same run afterwards, in its middle."""
    on.studio.open(_run(on.work, "arena", "square-clutter"))
    _at(on, 0.42)


def compare(on: Photographer) -> None:
    """The planner and the published one, on one timeline, with their differences."""
    on.studio.open(_run(on.work, "cavalcade", "square-clutter"))
    overrides = ("planner.variant=published",)
    other = _run(on.work, "published", "square-clutter", overrides)
    on.studio.study.compare(other)
    _at(on, 0.42)
    on.show("cycle, 99 %")
    on.wait(lambda: True, 0.5)


def campaign(on: Photographer) -> None:
    """The trials of a campaign, and one of them run again."""
    folder = on.work / "campaign" / "smoke"
    if not folder.exists():
        run_campaign(define_campaign("smoke"), folder, make_engine("local", 2), quiet=True)
    on.studio.open(folder)
    trial = on.studio.study.campaign.shown[0]
    on.studio.study.choose_trial(trial)
    on.studio.study.run_again()
    on.wait(lambda: on.studio.study.view is not None)
    _at(on, 0.5)


PICTURES: dict[str, Callable[[Photographer], None]] = {
    "build": build,
    "drive": drive,
    "walk": walk,
    "study": study,
    "compare": compare,
    "campaign": campaign,
}


def _run(work: Path, name: str, scenario: str, overrides: tuple[str, ...] = ()) -> Path:
    """The folder of a run, which is made if it is not there."""
    folder = work / name
    if not folder.exists():
        cv.run(scenario, folder, overrides=overrides, figures=False)
    return folder


def _drive_until(on: Photographer, moment: float) -> None:
    on.studio.choose("Drive")
    panel = on.studio.drive
    panel.act("Start")
    on.wait(lambda: (seen := panel.drive.snapshot()) is not None and seen.time >= moment)
    panel.act("Pause")
    on.wait(lambda: panel.drive.phase == "paused", 2.0)


def _at(on: Photographer, share: float) -> None:
    timeline = on.studio.study.view.timeline
    playback = timeline.playback
    timeline.jump(playback.begin + share * (playback.end - playback.begin))
    on.wait(lambda: True, 2.5)


def main(out: Path, names: list[str]) -> None:
    """Take the pictures of these names, by day and by night."""
    found = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if found is None:
        raise SystemExit("there is no Chromium here; on Debian: apt-get install chromium")
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=found, args=list(_ARGUMENTS))
        for name in names or list(PICTURES):
            on = Photographer(browser, Path(folder))
            try:
                PICTURES[name](on)
                for theme in ("dark", "light"):
                    on.studio.session.dark = theme == "dark"
                    on.wait(lambda: True, 2.5)
                    file = out / f"{name}-{theme}.png"
                    on.page.screenshot(path=file)
                    Image.open(file).convert("RGB").save(file, optimize=True)
                    print(file, flush=True)
            finally:
                on.close()
        browser.close()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("docs/images/studio"))
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PICTURES))
    given = parser.parse_args()
    if unknown := set(given.names) - set(PICTURES):
        parser.error(f"there is no picture {', '.join(sorted(unknown))}")
    main(given.out, given.names)
