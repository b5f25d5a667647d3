"""All figures of a run, a plan, or a run in physics, fit to be printed in a paper.

Importing this module is cheap: matplotlib is loaded by the first figure that is drawn.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cavalcade.drawing.formation.arrival_field import draw_arrival_field
from cavalcade.drawing.formation.over_time import draw_obstacle_distance, draw_pair_distance
from cavalcade.drawing.formation.sequence import draw_sequence
from cavalcade.drawing.physics.legs import draw_gait, draw_legs
from cavalcade.drawing.physics.signals import descriptions_of
from cavalcade.drawing.plans.footholds import draw_footholds
from cavalcade.drawing.plans.profile import draw_profile
from cavalcade.drawing.plans.timing import draw_timing
from cavalcade.drawing.plans.top_view import draw_top_view
from cavalcade.drawing.scene import PlanScene, Scene
from cavalcade.drawing.style import make_directory

if TYPE_CHECKING:
    from cavalcade.metrics.plan_summary import PlanResult
    from cavalcade.recording.frames import Recording
    from cavalcade.scenario import Scenario, World


def make_figures(
    scenario: Scenario,
    world: World,
    directory: str | Path,
    *,
    recording: Recording | None = None,
    plan: PlanResult | None = None,
) -> list[Path]:
    """Draw all figures of a run, a plan, or a plan that was carried out.

    The directory is made if it is missing; the world is that of the start.

    Returns:
        The files written, in the order a reader wants them:

        - of a plan `plan.png`; where there are trajectories also `timing.png`; where feet step
          also `footholds.png`; on terrain also `profile.png`,
        - of a run without one, of one cycle or more, `sequence.png`, `obstacle_distance.png`,
          `pair_distance.png` (two robots or more), `arrival_field.png` (if the team had a goal),
        - in physics, of two samples or more, `legs.png` (speeds, height of the trunk, torques) and
          `gait.png` (which feet carry how much over three seconds).

    Raises:
        OutputError: A picture cannot be written.
        RecordingError: The recording's track is not that of the scenario's robots.
    """
    folder = make_directory(directory)
    files: list[Path | None] = []
    if plan is not None:
        planned = PlanScene(scenario, world, plan)
        files += [
            draw_top_view(planned, folder / "plan.png"),
            draw_timing(planned, folder / "timing.png"),
            draw_footholds(planned, folder / "footholds.png"),
            draw_profile(planned, folder / "profile.png"),
        ]
    elif recording is not None and len(recording.time):
        scene = Scene(scenario, world, recording)
        files += [
            draw_sequence(scene, folder / "sequence.png"),
            draw_obstacle_distance(scene, folder / "obstacle_distance.png"),
            draw_pair_distance(scene, folder / "pair_distance.png"),
            draw_arrival_field(scene, folder / "arrival_field.png"),
        ]
    track = None if recording is None else recording.physics
    if recording is not None and track is not None and len(track.time) > 1:
        robots, name = descriptions_of(scenario, track), str(scenario.name)
        commands = (recording.time, recording.commands)
        files += [
            draw_legs(name, track, robots, commands, folder / "legs.png"),
            draw_gait(name, track, robots, folder / "gait.png"),
        ]
    return [file for file in files if file is not None]
