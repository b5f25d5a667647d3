"""The replay of a plan: one HTML file with a 3-D scene that any browser shows, offline.

The page (`replay_page/`) draws with WebGL and loads nothing from anywhere.
"""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cavalcade.running.figures import style
from cavalcade.running.plans.replay_data import replay_data
from cavalcade.running.plans.scene import plan_scene

if TYPE_CHECKING:
    from cavalcade.running.plans.planning import PlanResult
    from cavalcade.scenario import Scenario, World

_SCRIPTS = (
    "data.js",
    "matrix.js",
    "shaders.js",
    "ground.js",
    "lines.js",
    "feet.js",
    "robots.js",
    "camera.js",
    "panels.js",
    "app.js",
)


def write_plan_replay(scenario: Scenario, world: World, made: PlanResult, path: str | Path) -> Path:
    """Write the replay of a plan as one HTML file.

    Raises:
        OutputError: It cannot be written.
    """
    target = Path(path)
    page = plan_page(replay_data(plan_scene(scenario, world, made), world, made.summary))
    with style.replacing(target) as temporary:
        temporary.write_text(page, encoding="utf-8", newline="\n")
    return target


def plan_page(data: Mapping[str, Any]) -> str:
    """The whole HTML text for what `replay_data` made."""
    folder = files("cavalcade.running.plans") / "replay_page"
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    # Inside a script element only "<" can end or change the element.
    text = text.replace("<", "\\u003c")
    parts = {
        "TITLE": html.escape(f"{data['name']} – Cavalcade plan"),
        "STYLE": (folder / "style.css").read_text(encoding="utf-8"),
        "SCRIPT": "\n".join((folder / name).read_text(encoding="utf-8") for name in _SCRIPTS),
        "PLAN": text,
    }
    pieces = (folder / "page.html").read_text(encoding="utf-8").split("%")
    # The page has its places as %NAME%, and no other percent signs.
    return "".join(parts[piece] if index % 2 else piece for index, piece in enumerate(pieces))
