"""The replay of a plan: one HTML file with a 3-D scene that any browser shows, offline.

The page (`plan_page/`, over `page3d`) draws with WebGL and loads nothing from anywhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cavalcade.drawing.plans.scene import plan_scene
from cavalcade.drawing.replay.page3d.page import join_page, write_page
from cavalcade.drawing.replay.plan_data import replay_data

if TYPE_CHECKING:
    from cavalcade.metrics.plan_result import PlanResult
    from cavalcade.scenario import Scenario, World


def write_plan_replay(scenario: Scenario, world: World, made: PlanResult, path: str | Path) -> Path:
    """Write the replay of a plan as one HTML file.

    Raises:
        OutputError: It cannot be written.
    """
    data = replay_data(plan_scene(scenario, world, made), world, made.summary)
    return write_page(plan_page(data), path)


def plan_page(data: Mapping[str, Any]) -> str:
    """The whole HTML text for what `replay_data` made."""
    return join_page(
        files("cavalcade.drawing.replay") / "plan_page",
        ("data.js", "lines.js", "feet.js", "robots.js"),
        ("panels.js", "app.js"),
        f"{data['name']} – Cavalcade plan",
        data,
    )
