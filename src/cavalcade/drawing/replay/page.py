"""One HTML file out of the page's parts and the data of a run or a plan."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cavalcade.drawing.replay.data import replay_data
from cavalcade.files import write_file

if TYPE_CHECKING:
    from cavalcade.metrics.plan_summary import PlanResult
    from cavalcade.recording.frames import Recording
    from cavalcade.scenario import Scenario, World

_SCRIPTS = (
    "data.js",
    "matrix.js",
    "webgl.js",
    "shapes.js",
    "ground.js",
    "motion.js",
    "robots.js",
    "strokes.js",
    "lines.js",
    "camera.js",
    "clock.js",
    "panels.js",
    "charts.js",
    "app.js",
)


def write_replay(
    path: str | Path,
    scenario: Scenario,
    world: World,
    *,
    recording: Recording | None = None,
    plan: PlanResult | None = None,
    summary: Mapping[str, Any],
) -> Path:
    """Write the replay of a run, a plan, or a plan that was carried out as one HTML file.

    The world is that of the start. Keys that the summary lacks or that are null are left out. The
    recording's track of a run in physics moves links and feet; where there is none, the plan's
    trajectories and footholds move the robots.

    Raises:
        OutputError: It cannot be written.
        RecordingError: The recording's track is empty, or not that of the scenario's robots.
    """
    target = Path(path)
    data = replay_data(scenario, world, recording=recording, plan=plan, summary=summary)
    write_file(target, replay_page(data))
    return target


def replay_page(data: Mapping[str, Any]) -> str:
    """The whole HTML text for what `replay_data` made."""
    assets = files("cavalcade.drawing.replay") / "assets"
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    parts = {
        "TITLE": html.escape(f"{data['name']} – Cavalcade replay"),
        "STYLE": (assets / "style.css").read_text(encoding="utf-8"),
        "SCRIPT": "\n".join((assets / name).read_text(encoding="utf-8") for name in _SCRIPTS),
        # Inside a script element only "<" can end or change the element.
        "DATA": text.replace("<", "\\u003c"),
    }
    pieces = (assets / "page.html").read_text(encoding="utf-8").split("%")
    # The page has its places as %NAME%, and no other percent signs.
    return "".join(parts[piece] if index % 2 else piece for index, piece in enumerate(pieces))
