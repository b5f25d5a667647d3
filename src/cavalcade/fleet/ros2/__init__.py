"""Robots on a ROS 2 graph. Importing this package loads nothing of ROS; making a graph does."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
