"""Planar motion of one robot among others: search in space and time over motion primitives."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
