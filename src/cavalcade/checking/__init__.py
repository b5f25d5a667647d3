"""The independent checker: what a run or a plan left behind is judged here, and by nothing else.

It reads the recorded true poses or the planned motion, the scenario's own obstacle shapes and the
map file; its distances, its map decoder, its idea of a formation and of legs are its own.
"""

from cavalcade.checking.arrays import check_motion
from cavalcade.checking.check import check
from cavalcade.checking.plans import judge_plan
from cavalcade.checking.report import Report, Violation

__all__ = ["Report", "Violation", "check", "check_motion", "judge_plan"]
