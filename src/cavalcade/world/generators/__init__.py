"""Seeded worlds of several kinds: `generate("clutter", (14, 10), seed=3)`."""

from cavalcade.world.generators.generate import GENERATORS, generate, is_connected
from cavalcade.world.generators.model import GeneratedWorld

__all__ = ["GENERATORS", "GeneratedWorld", "generate", "is_connected"]
