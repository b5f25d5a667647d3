"""The replay of a run in physics: one HTML file, 3-D, with moving legs, in any browser, offline.

The page (`physics_page/`, over `page3d`) moves the links as `skeleton` says.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cavalcade.drawing.replay.page3d.page import join_page, write_page
from cavalcade.drawing.replay.physics_data import physics_data

if TYPE_CHECKING:
    from cavalcade.recording.frames import Recording
    from cavalcade.recording.physics_track import PhysicsTrack
    from cavalcade.scenario import Scenario, World


def write_physics_replay(
    scenario: Scenario,
    world: World,
    recording: Recording | None,
    track: PhysicsTrack,
    summary: Mapping[str, Any],
    path: str | Path,
) -> Path:
    """Write the replay of a run in physics as one HTML file.

    Args:
        scenario: The scenario that was run.
        world: Its `World`: the map and the exact shapes, as they were at the start.
        recording: What the planner did, on the track's clock; None where there is none.
        track: What the robots did; at least one sample.
        summary: The content of `summary.json`; keys that are missing or null are left out.
        path: The file to write.

    Returns:
        The file written.

    Raises:
        OutputError: It cannot be written.
        RecordingError: The track is empty, or not that of the scenario's robots.
    """
    return write_page(physics_page(physics_data(scenario, world, recording, track, summary)), path)


def physics_page(data: Mapping[str, Any]) -> str:
    """The whole HTML text for what `physics_data` made."""
    return join_page(
        files("cavalcade.drawing.replay") / "physics_page",
        ("data.js", "motion.js", "bodies.js", "planner.js", "lines.js"),
        ("events.js", "panels.js", "app.js"),
        f"{data['name']} – Cavalcade physics replay",
        data,
    )
