"""Figures of a run in physics, as far as its recording holds such a run."""

from __future__ import annotations

from pathlib import Path

from cavalcade.recording.frames import Recording
from cavalcade.scenario import Scenario


def add_figures(scenario: Scenario, recording: Recording, directory: Path) -> None:
    """Draw what the legs did; nothing for robots without."""
    if recording.physics is None:
        return
    from cavalcade.drawing.physics.figures import make_physics_figures

    make_physics_figures(scenario, recording.physics, recording.time, recording.commands, directory)
