"""The team of a sampler: its robots and the shape they keep."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr, Strict, ValidationError, model_validator

from cavalcade.campaign.samplers.feasibility import DiscRegions
from cavalcade.campaign.samplers.sampler import Area, Pose, rounded
from cavalcade.geometry import Array, transform_points
from cavalcade.robots import MODELS
from cavalcade.scenario.fields import Length, Point, Section, expected
from cavalcade.scenario.task import FormationSection, check_formation

Slots = Annotated[tuple[Point, ...], Field(min_length=1, max_length=64)]
"""Points of a custom shape in the formation's frame, m, the leader's first."""

OWN_COUNT = {"square": 4, "triangle": 3}
"""Robots of shapes that are for so many."""

BODY = 0.36
"""A go1 or a spirit may stand at any yaw where its centre keeps this distance, m; it is half the
diagonal of a go1 and a little, and of a spirit less its last 3 cm."""

_TRIES = 300
"""Poses that are tried for a team in its area."""


class TeamSection(Section):
    """A shape with its size in m, as in a scenario file, and how many robots keep it.

    Square, triangle and custom shapes, which are lists of slots, say by themselves how many they
    are.
    """

    shape: Literal["square", "line", "column", "wedge", "triangle", "circle", "custom"]
    side: Length | None = None
    spacing: Length | None = None
    radius: Length | None = None
    slots: Slots | None = None
    robots: Annotated[int, Strict(), Field(ge=1, le=64)] = 0

    _formation: FormationSection = PrivateAttr()

    @model_validator(mode="before")
    @classmethod
    def _count(cls, data: Any) -> Any:
        if not isinstance(data, dict) or data.get("robots") is not None:
            return data
        own = OWN_COUNT.get(str(data.get("shape")))
        if data.get("shape") == "custom" and isinstance(data.get("slots"), list | tuple):
            own = len(data["slots"])
        if own is None:
            raise expected("expected how many there are", key="robots")
        return {**data, "robots": own}

    @model_validator(mode="after")
    def _shape(self) -> Self:
        sizes = {key: getattr(self, key) for key in ("side", "spacing", "radius", "slots")}
        given = {key: value for key, value in sizes.items() if value is not None}
        try:
            self._formation = FormationSection.model_validate({"shape": self.shape, **given})
        except ValidationError as error:
            raise expected(error.errors()[0]["msg"]) from None
        check_formation(self._formation, self.robots, MODELS["go1"].width)
        return self

    @property
    def formation(self) -> dict[str, Any]:
        """The formation as a scenario file says it."""
        return self._formation.model_dump(mode="json", exclude_none=True)

    def places(self, pose: Pose | None = None) -> Array:
        """The slots `(N, 2)`, m: in the formation's frame, or with its centre at `pose`."""
        from cavalcade.execution.formation_policy import formation_of
        from cavalcade.scenario import PlannerSection

        slots = formation_of(self._formation, self.robots, PlannerSection()).slots
        return slots if pose is None else transform_points(pose, slots)

    def gets_across(self, ground: DiscRegions, start: Pose, goal: Pose) -> bool:
        """Whether a disc gets from every slot at the start to every one at the goal."""
        return ground.connect(self.places(start), self.places(goal))

    def scenario(
        self,
        name: str,
        world: Mapping[str, Any],
        start: Pose,
        goal: Pose,
        timeout: float,
        seed: int,
    ) -> dict[str, Any]:
        """A scenario as its file says it, without a planner section.

        `start` and `goal` are the formation's centre's, `timeout` is in s of simulated time.
        """
        yaw = round(float(start[2]), 6)
        return {
            "version": 1,
            "name": name,
            "world": dict(world),
            "robots": [
                {"model": "go1", "start": [round(x, 6), round(y, 6), yaw]}
                for x, y in self.places(start).tolist()
            ],
            "task": {"formation": self.formation, "goals": [[float(value) for value in goal]]},
            "execution": {"timeout": timeout, "seed": seed},
        }


def fits(ground: DiscRegions, pose: Pose, slots: Array, area: Area | None = None) -> bool:
    """Whether every robot can stand in its slot at any yaw, within the area if there is one."""
    places = transform_points(pose, slots)
    if area is not None:
        low, high = np.array(area[:2]) + BODY, np.array(area[2:]) - BODY
        if (places < low).any() or (places > high).any():
            return False
    return bool((ground.clearance(places) >= BODY).all())


def sample_pose(
    rng: np.random.Generator,
    ground: DiscRegions,
    slots: Array,
    area: Area,
    yaw: float | None = None,
) -> Pose | None:
    """A pose in the area at which the team's `slots` fit; None if none is found.

    Without a `yaw`, rad, it is sampled too.
    """
    for _ in range(_TRIES):
        x, y = rng.uniform(area[0], area[2]), rng.uniform(area[1], area[3])
        turned = rng.uniform(-math.pi, math.pi) if yaw is None else yaw
        pose = rounded((x, y, turned))
        if fits(ground, pose, slots, area):
            return pose
    return None
