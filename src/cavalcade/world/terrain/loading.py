"""Terrain files: a description in YAML, or a mesh by itself."""

from __future__ import annotations

from pathlib import Path

from cavalcade.errors import MapError
from cavalcade.world.terrain.terrain import RESOLUTION, Terrain


def load_terrain(path: str | Path, resolution: float = RESOLUTION) -> Terrain:
    """Read a terrain.

    Raises:
        MapError: The file cannot be used; the message is one line.
    """
    raise MapError("not yet", file=path)
