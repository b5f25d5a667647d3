"""Figures of a plan, fit to be printed in a paper.

Importing this package is cheap: matplotlib is loaded by the first figure that is drawn.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cavalcade.drawing.plans.scene import PlanScene
    from cavalcade.metrics.plan_summary import PlanResult
    from cavalcade.scenario import Scenario, World

__all__ = ["draw_plan_figures", "make_plan_figures"]


def make_plan_figures(
    scenario: Scenario, world: World, made: PlanResult, directory: str | Path
) -> list[Path]:
    """Draw all figures of a plan into `directory`, which is made if it is missing.

    Returns:
        The files written: `plan.png`; where there are trajectories also `timing.png`; where feet
        step also `footholds.png`; on terrain also `profile.png`.

    Raises:
        OutputError: A picture cannot be written.
    """
    from cavalcade.drawing.plans.scene import plan_scene

    return draw_plan_figures(plan_scene(scenario, world, made), directory)


def draw_plan_figures(scene: PlanScene, directory: str | Path) -> list[Path]:
    """The same from a scene."""
    from cavalcade.drawing.plans.footholds import draw_footholds
    from cavalcade.drawing.plans.profile import draw_profile
    from cavalcade.drawing.plans.timing import draw_timing
    from cavalcade.drawing.plans.top_view import draw_top_view
    from cavalcade.drawing.style import make_directory

    folder = make_directory(directory)
    files = [
        draw_top_view(scene, folder / "plan.png"),
        draw_timing(scene, folder / "timing.png"),
        draw_footholds(scene, folder / "footholds.png"),
        draw_profile(scene, folder / "profile.png"),
    ]
    return [file for file in files if file is not None]
