"""Worlds: occupancy maps, exact obstacle shapes, map files and seeded generators."""

from cavalcade.world.barn import BarnWorld, load_barn
from cavalcade.world.generators import GENERATORS, GeneratedWorld, generate, is_connected
from cavalcade.world.movingai import load_movingai
from cavalcade.world.occupancy import OccupancyMap
from cavalcade.world.raster import rasterise
from cavalcade.world.ros_map import MapWarning, load_map, save_map
from cavalcade.world.shape_files import shape_from_mapping, shape_to_mapping
from cavalcade.world.shapes import Box, Circle, Polygon, Shape, distance_to_shapes

__all__ = [
    "GENERATORS",
    "BarnWorld",
    "Box",
    "Circle",
    "GeneratedWorld",
    "MapWarning",
    "OccupancyMap",
    "Polygon",
    "Shape",
    "distance_to_shapes",
    "generate",
    "is_connected",
    "load_barn",
    "load_map",
    "load_movingai",
    "rasterise",
    "save_map",
    "shape_from_mapping",
    "shape_to_mapping",
]
