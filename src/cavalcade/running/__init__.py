"""Carrying scenarios out: the control loop, recordings, figures and replay."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cavalcade.running.control import ControlLoop, Planner
    from cavalcade.running.frames import ObstacleTrack, Recording
    from cavalcade.running.loop import RunResult, run
    from cavalcade.running.progress import Progress
    from cavalcade.running.reading import read_recording
    from cavalcade.running.recording import write_recording
    from cavalcade.running.simulation import simulate

_HOME = {
    "ControlLoop": "control",
    "ObstacleTrack": "frames",
    "Planner": "control",
    "Progress": "progress",
    "Recording": "frames",
    "RunResult": "loop",
    "read_recording": "reading",
    "run": "loop",
    "simulate": "simulation",
    "write_recording": "recording",
}

__all__ = [
    "ControlLoop",
    "ObstacleTrack",
    "Planner",
    "Progress",
    "Recording",
    "RunResult",
    "read_recording",
    "run",
    "simulate",
    "write_recording",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
