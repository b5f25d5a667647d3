"""What is kept of a run or a plan: in memory, as MCAP for RViz and Foxglove, and as `plan.npz`."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
