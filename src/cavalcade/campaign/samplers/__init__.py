"""Seeded samplers of worlds with a team and its task, and whether the task can be done at all."""

from cavalcade.campaign.samplers.barn import BarnSampler
from cavalcade.campaign.samplers.crowd import CrowdSampler
from cavalcade.campaign.samplers.events import EventsSampler
from cavalcade.campaign.samplers.generated import GeneratedSampler
from cavalcade.campaign.samplers.infeasible import InfeasibleSampler
from cavalcade.campaign.samplers.maps import MapsSampler
from cavalcade.campaign.samplers.sampler import EXPECTED, SOLVED, DataFolder, Instance, Sampler
from cavalcade.campaign.samplers.scattered import BoxesSampler, TerrainSampler
from cavalcade.campaign.samplers.shipped import ShippedSampler
from cavalcade.campaign.samplers.two_robots import PairsSampler, PassingSampler
from cavalcade.campaign.samplers.walk import WalkSampler

SAMPLERS: dict[str, type[Sampler]] = {
    "generated": GeneratedSampler,
    "barn": BarnSampler,
    "maps": MapsSampler,
    "crowd": CrowdSampler,
    "events": EventsSampler,
    "shipped": ShippedSampler,
    "pairs": PairsSampler,
    "passing": PassingSampler,
    "boxes": BoxesSampler,
    "terrain": TerrainSampler,
    "infeasible": InfeasibleSampler,
    "walk": WalkSampler,
}
"""What a group of a suite may say as its `sampler`, and the section that goes with it."""


def unplanned(sampler: Sampler) -> Sampler:
    """The same, but for what takes a planner to sample: good enough to see whether values fit."""
    if isinstance(sampler, PairsSampler):
        return sampler.model_copy(update={"keep": "any"})
    return sampler


__all__ = ["EXPECTED", "SAMPLERS", "SOLVED", "DataFolder", "Instance", "Sampler", "unplanned"]
