"""Seeded draws of worlds with a team and its task, and whether the task can be done at all."""

from typing import Annotated

from pydantic import Field

from cavalcade.campaign.draws.barn import BarnDraw
from cavalcade.campaign.draws.crowd import CrowdDraw
from cavalcade.campaign.draws.data import DataFolder
from cavalcade.campaign.draws.events import EventsDraw
from cavalcade.campaign.draws.generated import GeneratedDraw
from cavalcade.campaign.draws.maps import MapsDraw
from cavalcade.campaign.draws.model import Draw, Drawn
from cavalcade.campaign.draws.shipped import ShippedDraw

DrawSection = Annotated[
    GeneratedDraw | BarnDraw | MapsDraw | CrowdDraw | EventsDraw | ShippedDraw,
    Field(discriminator="draw"),
]
"""What a group of a suite says of its worlds; `draw` tells which it is."""

__all__ = ["DataFolder", "Draw", "DrawSection", "Drawn"]
