"""Worlds: occupancy maps, exact obstacle shapes, map files, terrain and seeded generators."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from cavalcade.world.barn import BarnWorld, load_barn
from cavalcade.world.generators import GENERATORS, GeneratedWorld, generate, is_connected
from cavalcade.world.movingai import load_movingai
from cavalcade.world.occupancy import OccupancyMap
from cavalcade.world.raster import rasterise
from cavalcade.world.ros_map import MapWarning, load_map, save_map
from cavalcade.world.shape_files import shape_from_mapping, shape_to_mapping
from cavalcade.world.shapes import Box, Circle, Polygon, Shape, distance_to_shapes

if TYPE_CHECKING:
    from cavalcade.world.terrain import (
        TERRAINS,
        Terrain,
        generate_terrain,
        load_terrain,
        terrain_options,
    )

__all__ = [
    "GENERATORS",
    "TERRAINS",
    "BarnWorld",
    "Box",
    "Circle",
    "GeneratedWorld",
    "MapWarning",
    "OccupancyMap",
    "Polygon",
    "Shape",
    "Terrain",
    "distance_to_shapes",
    "generate",
    "generate_terrain",
    "is_connected",
    "load_barn",
    "load_map",
    "load_movingai",
    "load_terrain",
    "rasterise",
    "save_map",
    "shape_from_mapping",
    "shape_to_mapping",
    "terrain_options",
]

_TERRAIN = ("TERRAINS", "Terrain", "generate_terrain", "load_terrain", "terrain_options")


def __getattr__(name: str) -> Any:
    # Terrain needs the compiler, which takes longer to import than all the rest.
    if name not in _TERRAIN:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from cavalcade.world import terrain

    return getattr(terrain, name)
