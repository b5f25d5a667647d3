"""Coordination of robots that have goals of their own: sequential, joint, conflict-based, auto."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
