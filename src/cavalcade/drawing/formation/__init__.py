"""Figures of a run, fit to be printed in a paper.

Importing this package is cheap: matplotlib is loaded by the first figure that is drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cavalcade.recording.frames import Recording
    from cavalcade.scenario import Scenario, World

__all__ = ["draw_scenario", "make_figures"]


def make_figures(
    scenario: Scenario,
    world: World,
    recording: Recording,
    summary: Mapping[str, Any],
    directory: str | Path,
) -> list[Path]:
    """Draw all figures of a run into `directory`, which is made if it is missing.

    Args:
        scenario: The scenario that was run.
        world: Its `World`: the map and the exact shapes, as they were at the start.
        recording: What happened.
        summary: The content of `summary.json`; nothing is drawn from it so far.
        directory: Where the pictures go.

    Returns:
        The files written, in the order a reader wants them: `sequence.png`,
        `obstacle_distance.png`, `pair_distance.png` (two robots or more), `arrival_field.png`
        (if the team had a goal). A recording without a single cycle gives an empty list.

    Raises:
        OutputError: A picture cannot be written.
    """
    from cavalcade.drawing.formation.arrival_field import draw_arrival_field
    from cavalcade.drawing.formation.over_time import draw_obstacle_distance, draw_pair_distance
    from cavalcade.drawing.formation.sequence import draw_sequence
    from cavalcade.drawing.scene import scene_of
    from cavalcade.drawing.style import make_directory

    if len(recording.time) == 0:
        return []
    folder = make_directory(directory)
    scene = scene_of(scenario, world, recording)
    files = [
        draw_sequence(scene, folder / "sequence.png"),
        draw_obstacle_distance(scene, world, folder / "obstacle_distance.png"),
        draw_pair_distance(scene, folder / "pair_distance.png"),
        draw_arrival_field(scene, world, folder / "arrival_field.png", scenario.planner.d_safe_a),
    ]
    return [file for file in files if file is not None]


def draw_scenario(scenario: Scenario, world: World, path: str | Path) -> Path:
    """Draw a scenario that has not been run: arena, robots at their starts, goals, events.

    Returns:
        The file written.

    Raises:
        OutputError: The picture cannot be written.
    """
    from cavalcade.drawing.overview import draw_overview

    return draw_overview(scenario, world, Path(path))
