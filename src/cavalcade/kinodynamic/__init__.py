"""Motion of one robot's body over rough ground, on foot and by leaps: kinodynamic RRT-Connect."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
