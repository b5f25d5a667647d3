"""Ground with heights: elevation grids, meshes and seeded generators."""

from cavalcade.world.terrain.generators import TERRAINS, generate_terrain, terrain_options
from cavalcade.world.terrain.loading import load_terrain
from cavalcade.world.terrain.terrain import Terrain

__all__ = ["TERRAINS", "Terrain", "generate_terrain", "load_terrain", "terrain_options"]
