"""The worlds of the BARN data set, crossed by small teams as the BARN challenge does it.

Every field is a yard 4.5 m wide, closed on three sides, whose upper half is full of cylinders.
The challenge starts at 3 m from its lower wall and ends 10 m ahead, beyond the open side.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from cavalcade.campaign.samplers.feasibility import DiscRegions
from cavalcade.campaign.samplers.sampler import DataFolder, Instance, Sampler, open_world
from cavalcade.campaign.samplers.teams import TeamSection, fits
from cavalcade.errors import InputError
from cavalcade.scenario.fields import Length, Positive
from cavalcade.world import OccupancyMap, load_barn

FOLDER = Path("barn") / "circles"
_FILE = re.compile(r"world_\d{1,6}\.csv")
_UP = round(math.pi / 2.0, 4)


class BarnSampler(Sampler):
    """Each world once per round of the seeds, in every round with the next of the teams.

    After as many rounds as there are teams, every world has been crossed by every team. The
    ground beyond the open side is added, `beyond` m of it. The worlds' cylinders are written
    out, so that a trial is repeated without the data set.
    """

    LEVEL_NAME: ClassVar = "robots"

    sampler: Literal["barn"]
    teams: Annotated[tuple[TeamSection, ...], Field(min_length=1)]
    start: Length = 3.0
    ahead: Length = 10.0
    beyond: Length = 5.0
    timeout: Positive = 180.0

    def limit(self, data: DataFolder) -> int | None:
        """Every world with every team."""
        return len(_files(data)) * len(self.teams)

    def missing(self, data: DataFolder) -> str | None:
        """Whether the data set is there."""
        return None if _files(data) else data.lack(FOLDER / "world_*.csv")

    def sample(self, seed: int, data: DataFolder) -> Instance:
        """World number `seed`."""
        files = _files(data)
        if not files:
            raise InputError(data.lack(FOLDER / "world_*.csv"))
        turn, index = divmod(seed, len(files))
        team = self.teams[(index + turn) % len(self.teams)]
        field = load_barn(files[index], self.beyond)
        ground = DiscRegions(OccupancyMap.empty(field.size), field.circles)
        middle = round(field.size[0] / 2.0, 4)
        start, goal = (middle, self.start, _UP), (middle, self.start + self.ahead, _UP)
        for pose, key in ((start, "start"), (goal, "ahead")):
            if not fits(ground, pose, team.places()):
                raise InputError(f"a {team.shape} does not fit there", file=files[index], key=key)
        name = f"barn-{_number(files[index])}-{team.robots}"
        world = open_world(field.size, field.circles)
        return Instance(
            team.scenario(name, world, start, goal, self.timeout, seed),
            team.gets_across(ground, start, goal),
            float(team.robots),
        )


def _files(data: DataFolder) -> list[Path]:
    """The worlds in the order of their numbers."""
    if data.path is None or not (data.path / FOLDER).is_dir():
        return []
    found = [path for path in (data.path / FOLDER).iterdir() if _FILE.fullmatch(path.name)]
    return sorted(found, key=_number)


def _number(path: Path) -> int:
    """Of a file whose name `_FILE` matches."""
    return int(path.stem.removeprefix("world_"))
