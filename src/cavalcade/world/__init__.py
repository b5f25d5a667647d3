"""Worlds: occupancy maps, exact obstacle shapes, map files, terrain and seeded generators.

The names are imported when first used: terrain needs the compiler, which takes longer to import
than all the rest.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
