"""How fast the studio's page is: updates of the scene per second that a browser draws, what an open
page costs the planner, whether physics keeps real time, and how soon large things are open.

    python benchmarks/bench_studio.py [--seconds 20] [--open FOLDER ...] [--out results.json]

The page is that of `cavalcade studio`, in Chromium without a window, drawn in software. What it
has drawn is counted in the page itself: pictures between which the scene has changed. The planner
is measured in the same drive with and without the page. `--open` adds folders of runs.
"""

from __future__ import annotations

import argparse
import json
import resource
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import cavalcade as cv
from cavalcade.scenario import load_scenario
from cavalcade.studio.app import Studio
from cavalcade.studio.drive.simulated_drive import SimulatedDrive
from cavalcade.world import OccupancyMap

TEAMS = {"ten robots": ("tour-ten", "ideal"), "four walking": ("square-clutter", "mujoco")}
"""A name, the scenario and what simulates it."""

SETTLING = 3.0
"""Nothing is counted before so many seconds of a drive."""

_ARGUMENTS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)

# Animation frames, and those of them since whose predecessor something was given to the graphics.
_COUNT = """() => {
  const seen = { frames: 0, drawn: 0, dirty: false };
  const gl = WebGL2RenderingContext.prototype;
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


def scenario_of(team: str) -> Any:
    """What a team drives."""
    name, backend = TEAMS[team]
    scenario = load_scenario(name)
    execution = scenario.execution.model_copy(update={"backend": backend})
    return scenario.model_copy(update={"execution": execution})


def wait(condition: Callable[[], Any], nap: Callable[[float], None] = time.sleep) -> None:
    """Until it holds."""
    while not condition():
        nap(0.02)


def alone(team: str, seconds: float, folder: Path) -> dict[str, float]:
    """Drive with nobody looking."""
    drive = SimulatedDrive(scenario_of(team), folder / "alone")
    drive.start()
    wait(lambda: drive.time >= SETTLING + seconds or drive.phase == "ended")
    drive.close()
    assert drive.summary is not None, drive.trouble
    return {"cycle_p50_ms": drive.summary["cycle_ms"]["p50"]}


@contextmanager
def opened(folder: Path) -> Iterator[tuple[Studio, Any]]:
    """A studio, and a browser's page that shows it."""
    from playwright.sync_api import sync_playwright

    found = shutil.which("chromium")
    assert found is not None, "there is no Chromium here"
    with Studio(port=0, folder=folder / "studio") as studio, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=list(_ARGUMENTS))
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(studio.session.address)
        page.wait_for_selector("canvas")
        yield studio, page
        browser.close()


def watched(team: str, seconds: float, folder: Path) -> dict[str, float]:
    """Drive with a page open."""
    with opened(folder) as (studio, page):
        shown: list[float] = []
        stage_show = studio.session.stage.show

        def show(snapshot: Any) -> None:
            begun = time.perf_counter()
            stage_show(snapshot)
            shown.append(time.perf_counter() - begun)

        studio.session.stage.show = show  # type: ignore[method-assign]
        studio.build.draft.replace(scenario_of(team).model_dump(mode="json", exclude_unset=True))
        studio.choose("Drive")
        page.wait_for_timeout(3000)
        page.evaluate(_COUNT)
        studio.drive.act("Start")
        drive = studio.drive.drive
        assert isinstance(drive, SimulatedDrive)
        wait(
            lambda: drive.time >= SETTLING or drive.phase == "ended",
            lambda s: page.wait_for_timeout(1e3 * s),
        )
        first, sent, began, went = (
            page.evaluate("({...seen})"),
            len(shown),
            time.perf_counter(),
            drive.time,
        )
        page.wait_for_timeout(1e3 * seconds)
        last, lasted = page.evaluate("({...seen})"), time.perf_counter() - began
        sent, went = len(shown) - sent, drive.time - went
        page.screenshot(path=str(folder / f"{team}.png"))
        drive.close()
        assert drive.summary is not None, drive.trouble
        return {
            "sent_per_second": sent / lasted,
            "drawn_per_second": (last["drawn"] - first["drawn"]) / lasted,
            "pictures_per_second": (last["frames"] - first["frames"]) / lasted,
            "show_ms": 1e3 * float(np.median(shown)),
            "pace": went / lasted,
            "cycle_p50_watched_ms": drive.summary["cycle_ms"]["p50"],
        }


def opening(folders: list[Path], folder: Path) -> dict[str, float]:
    """Seconds until a page shows a map of 1,000 x 1,000 cells, and each of these runs."""
    cells = np.random.default_rng(0).random((1000, 1000)) < 0.02
    cells[480:520, 480:520] = False
    cv.save_map(OccupancyMap(cells, 0.05), folder / "large.yaml")
    found = {}
    with opened(folder) as (studio, page):

        def took(act: Callable[[], None]) -> float:
            began = time.perf_counter()
            act()
            studio.session.server.flush()
            # The page answers once it has taken in all that it was sent before.
            answers: list[Any] = []
            (client,) = studio.session.server.get_clients().values()
            asked = threading.Thread(target=lambda: answers.append(client.get_render(72, 128)))
            asked.start()
            wait(lambda: answers, lambda s: page.wait_for_timeout(1e3 * s))
            return time.perf_counter() - began

        words: dict[str, Any] = {
            "version": 1,
            "name": "large",
            "world": {"map": str(folder / "large.yaml")},
            "robots": [{"model": "go1", "start": [25.0, 25.0, 0.0]}],
            "task": {"formation": {"shape": "column", "spacing": 1.0}},
        }
        found["map of 1000 x 1000"] = took(lambda: studio.build.draft.replace(words))
        for run in folders:
            found[str(run)] = took(lambda run=run: studio.open(run))  # type: ignore[misc]
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--open", type=Path, nargs="*", default=[])
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    results: dict[str, dict[str, float]] = {}
    cv.warm_up()
    for team in TEAMS:
        with tempfile.TemporaryDirectory() as name:
            result = alone(team, given.seconds, Path(name))
            result |= watched(team, given.seconds, Path(name))
            result["cycle_ratio"] = result["cycle_p50_watched_ms"] / result["cycle_p50_ms"]
            if given.out is not None:
                shutil.copy(Path(name) / f"{team}.png", given.out.parent)
        results[team] = result
    with tempfile.TemporaryDirectory() as name:
        results["opened after (s)"] = opening(given.open, Path(name))
    results["memory"] = {"MiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0}
    for title, figures in results.items():
        print(title)
        for key, value in figures.items():
            print(f"  {key:28s} {value:8.2f}")
    if given.out is not None:
        given.out.write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
