"""Figures and replay of a run in physics, as far as its recording holds such a run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cavalcade.recording.frames import Recording
from cavalcade.scenario import Scenario, World


def add_figures(scenario: Scenario, recording: Recording, directory: Path) -> None:
    """Draw what the legs did; nothing for robots without."""
    if recording.physics is None:
        return
    from cavalcade.drawing.physics.figures import make_physics_figures

    make_physics_figures(scenario, recording.physics, recording.time, recording.commands, directory)


def replay_in_physics(
    scenario: Scenario,
    world: World,
    recording: Recording,
    summary: Mapping[str, Any],
    path: Path,
) -> bool:
    """Write the replay with moving legs; False for robots without, of which none is written."""
    if recording.physics is None:
        return False
    from cavalcade.drawing.replay.physics import write_physics_replay

    write_physics_replay(scenario, world, recording, recording.physics, summary, path)
    return True
