"""Seeded draws of worlds with a team and its task, and whether the task can be done at all."""

from typing import Annotated

from pydantic import Field

from cavalcade.campaign.draws.barn import BarnDraw
from cavalcade.campaign.draws.boxes import BoxesDraw
from cavalcade.campaign.draws.crowd import CrowdDraw
from cavalcade.campaign.draws.data import DataFolder
from cavalcade.campaign.draws.events import EventsDraw
from cavalcade.campaign.draws.generated import GeneratedDraw
from cavalcade.campaign.draws.hopeless import HopelessDraw
from cavalcade.campaign.draws.maps import MapsDraw
from cavalcade.campaign.draws.model import Draw, Drawn
from cavalcade.campaign.draws.pairs import PairsDraw
from cavalcade.campaign.draws.passing import PassingDraw
from cavalcade.campaign.draws.shipped import ShippedDraw
from cavalcade.campaign.draws.terrain import TerrainDraw
from cavalcade.campaign.draws.walk import WalkDraw

DrawSection = Annotated[
    GeneratedDraw
    | BarnDraw
    | MapsDraw
    | CrowdDraw
    | EventsDraw
    | ShippedDraw
    | PairsDraw
    | PassingDraw
    | BoxesDraw
    | TerrainDraw
    | HopelessDraw
    | WalkDraw,
    Field(discriminator="draw"),
]
"""What a group of a suite says of its worlds; `draw` tells which it is."""


def unplanned(draw: Draw) -> Draw:
    """The same, but for what takes a planner to draw: good enough to see whether values fit."""
    if isinstance(draw, PairsDraw):
        return draw.model_copy(update={"keep": "any"})
    return draw


__all__ = ["DataFolder", "Draw", "DrawSection", "Drawn", "unplanned"]
