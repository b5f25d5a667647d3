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
from cavalcade.geometry import Array

if TYPE_CHECKING:
    from cavalcade.metrics.plan_summary import PlanResult
    from cavalcade.recording.frames import Recording
    from cavalcade.recording.physics_track import PhysicsTrack
    from cavalcade.scenario import Scenario, World


def make_figures(
    scenario: Scenario, world: World, recording: Recording, directory: str | Path
) -> list[Path]:
    """Draw all figures of a run into `directory`, which is made if it is missing.

    Returns:
        The files written, in the order a reader wants them: `sequence.png`,
        `obstacle_distance.png`, `pair_distance.png` (two robots or more), `arrival_field.png`
        (if the team had a goal). A recording without a single cycle gives an empty list.

    Raises:
        OutputError: A picture cannot be written.
    """
    if len(recording.time) == 0:
        return []
    folder = make_directory(directory)
    scene = Scene(scenario, world, recording)
    files = [
        draw_sequence(scene, folder / "sequence.png"),
        draw_obstacle_distance(scene, folder / "obstacle_distance.png"),
        draw_pair_distance(scene, folder / "pair_distance.png"),
        draw_arrival_field(scene, folder / "arrival_field.png"),
    ]
    return [file for file in files if file is not None]


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
    folder = make_directory(directory)
    scene = PlanScene(scenario, world, made)
    files = [
        draw_top_view(scene, folder / "plan.png"),
        draw_timing(scene, folder / "timing.png"),
        draw_footholds(scene, folder / "footholds.png"),
        draw_profile(scene, folder / "profile.png"),
    ]
    return [file for file in files if file is not None]


def make_physics_figures(
    scenario: Scenario,
    track: PhysicsTrack,
    commands: tuple[Array, Array] | None,
    directory: str | Path,
) -> list[Path]:
    """Draw what the legs did into `directory`, which is made if it is missing.

    `commands`: times `(K,)` s on the track's clock, and the body-frame velocities `(K, N, 3)`
    that hold from then on; None for none.

    Returns:
        `legs.png` (speeds, height of the trunk, torques) and `gait.png` (which feet carry how much
        over three seconds); nothing of a track with less than two samples.

    Raises:
        OutputError: A picture cannot be written.
        RecordingError: The track is not that of the scenario's robots.
    """
    if len(track.time) < 2:
        return []
    robots = descriptions_of(scenario, track)
    folder = make_directory(directory)
    name = str(scenario.name)
    return [
        draw_legs(name, track, robots, commands, folder / "legs.png"),
        draw_gait(name, track, robots, folder / "gait.png"),
    ]
