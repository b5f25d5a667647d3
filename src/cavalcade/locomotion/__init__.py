"""From bodies' motion to feet: when and where each of them stands."""

from cavalcade.locomotion.footholds import leg_lengths, longest_leg, plan_footholds
from cavalcade.locomotion.gait import FRONT_LEFT, FRONT_RIGHT, REAR_LEFT, REAR_RIGHT, stances

__all__ = [
    "FRONT_LEFT",
    "FRONT_RIGHT",
    "REAR_LEFT",
    "REAR_RIGHT",
    "leg_lengths",
    "longest_leg",
    "plan_footholds",
    "stances",
]
