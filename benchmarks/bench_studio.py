"""How fast the studio's page is: updates of the scene per second that a browser draws, with a team
of ten, and what an open page costs the planner.

    python benchmarks/bench_studio.py [--seconds 20] [--out results.json]

The page runs in Chromium without a window, drawn in software. What it has drawn is counted in the
page itself: pictures between which the scene has changed.
"""

from __future__ import annotations

import argparse
import json
import shutil
import statistics
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import cavalcade as cv
from cavalcade.recording.frames import Frame
from cavalcade.scenario import build_world, load_scenario, resolve_scenario
from cavalcade.studio.app import Studio
from cavalcade.studio.snapshot import Snapshot

SCENARIO = "tour-ten"
RATE = 25.0
"""Updates per second that are offered to the page."""

_ARGUMENTS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)

# Messages of moved robots that have come in, and animation frames after at least one of them.
_COUNT = """() => {
  const seen = { frames: 0, drawn: 0, dirty: false };
  const gl = WebGL2RenderingContext.prototype;
  const fill = gl.bufferSubData;
  for (const name of ["bufferData", "bufferSubData", "texSubImage2D", "texImage2D"]) {
    const original = gl[name];
    gl[name] = function (...given) { seen.dirty = true; return original.apply(this, given); };
  }
  const step = () => {
    seen.frames += 1;
    if (seen.dirty) { seen.drawn += 1; seen.dirty = false; }
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
  window.seen = seen;
}"""


class Newest:
    """A sink of frames that keeps the last one; it never waits."""

    def __init__(self) -> None:
        self.snapshot: Snapshot | None = None
        self.planning: list[float] = []

    def __call__(self, frame: Frame) -> None:
        """Keep it."""
        self.planning.append(frame.planning)
        self.snapshot = Snapshot(frame.time, frame.poses, frame.commands, frame.status)


def run(sink: Newest, seconds: float) -> None:
    """Drive at real time until it has taken so long."""
    steering = cv.Steering(speed=1.0)
    scenario = load_scenario(SCENARIO)
    timer = threading.Timer(seconds, steering.finish)
    timer.start()
    cv.run(scenario, sinks=[sink], steering=steering)
    timer.cancel()


def show(studio: Studio, sink: Newest, ended: threading.Event, shown: list[float]) -> None:
    """Show the newest moment at `RATE`, as drives do."""
    before = None
    while not ended.wait(1.0 / RATE):
        snapshot = sink.snapshot
        if snapshot is not None and snapshot is not before:
            before = snapshot
            begun = time.perf_counter()
            studio.session.stage.show(snapshot)
            shown.append(time.perf_counter() - begun)


def watched(seconds: float, folder: Path) -> dict[str, Any]:
    """Drive with a page open."""
    from playwright.sync_api import sync_playwright

    found = shutil.which("chromium")
    assert found is not None, "there is no Chromium here"
    sink, ended, shown = Newest(), threading.Event(), []
    with Studio(port=0, folder=folder / "studio") as studio, sync_playwright() as playwright:
        scenario = resolve_scenario(load_scenario(SCENARIO))
        stage = studio.session.stage
        stage.set_world(scenario, build_world(scenario))
        stage.set_team(scenario.models, scenario.starts)
        stage.frame_team()
        browser = playwright.chromium.launch(executable_path=found, args=list(_ARGUMENTS))
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(studio.session.address)
        page.wait_for_selector("canvas")
        page.wait_for_timeout(3000)
        page.evaluate(_COUNT)
        painter = threading.Thread(target=show, args=(studio, sink, ended, shown))
        driver = threading.Thread(target=run, args=(sink, seconds + 4.0))
        painter.start()
        driver.start()
        while sink.snapshot is None:
            page.wait_for_timeout(20)
        page.wait_for_timeout(1000)
        first, begun = page.evaluate("window.seen"), time.perf_counter()
        sent = len(shown)
        page.wait_for_timeout(1e3 * seconds)
        last, lasted = page.evaluate("window.seen"), time.perf_counter() - begun
        sent = len(shown) - sent
        page.screenshot(path=str(folder / "page.png"))
        driver.join()
        ended.set()
        painter.join()
        browser.close()
    return {
        "updates_sent_per_second": sent / lasted,
        "updates_drawn_per_second": (last["drawn"] - first["drawn"]) / lasted,
        "pictures_per_second": (last["frames"] - first["frames"]) / lasted,
        "show_ms": 1e3 * statistics.median(shown),
        "planning_ms": 1e3 * statistics.mean(sink.planning),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        alone = Newest()
        run(alone, given.seconds + 4.0)
        result = watched(given.seconds, folder)
        result["planning_alone_ms"] = 1e3 * statistics.mean(alone.planning)
        result["planning_ratio"] = result["planning_ms"] / result["planning_alone_ms"]
        if given.out is not None:
            given.out.write_text(json.dumps(result, indent=2) + "\n")
            shutil.copy(folder / "page.png", given.out.with_suffix(".png"))
    for key, value in result.items():
        print(f"{key:28s} {value:8.2f}")


if __name__ == "__main__":
    main()
