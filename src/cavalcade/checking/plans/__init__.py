"""Plans of teams whose robots have goals of their own: `plan.npz`, judged by itself.

The motion is integrated and differenced afresh from the samples; heights, traversability and
forces are computed here, from raw heights and the robots' figures alone.
"""

from cavalcade.checking.plans.judge import judge_plan
from cavalcade.checking.plans.motion import read_plan

__all__ = ["judge_plan", "read_plan"]
