"""The independent checker: what a run left behind is judged here, and by nothing else.

It reads the recorded true poses, the scenario's own obstacle shapes and the map file; its
distances, its map decoder and its idea of a formation are its own.
"""

from cavalcade.checking.check import check
from cavalcade.checking.report import Report, Violation

__all__ = ["Report", "Violation", "check"]
