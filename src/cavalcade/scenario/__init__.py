"""Scenario files: their schema, how they are read and written, and the shipped ones.

The names are looked up when first used: listing the shipped scenarios needs no schema, and
reading a file no maps.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
