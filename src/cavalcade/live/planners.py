"""The planners of a team, as its file says: of its formation and of goals of single robots."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, runtime_checkable

from cavalcade.errors import InputError
from cavalcade.execution import Degradable
from cavalcade.execution.formation_policy import formation_of, settings_of
from cavalcade.execution.individual_navigator import PLANNING, IndividualNavigator
from cavalcade.formation import FormationPlanner
from cavalcade.jobs import warming
from cavalcade.live.status import Pose
from cavalcade.live.team_file import Team
from cavalcade.world import OccupancyMap


@runtime_checkable
class IndividualPolicy(Degradable, Protocol):
    """A policy for robots with goals of their own, which may change at any time.

    Every method may be called from any thread. While it is paused its `step` lets robots brake
    or stand, and its status says `paused`.
    """

    def set_goal(self, robot: int, pose: Pose | None) -> None:
        """Drive a robot to a pose, or let it stay where it is."""

    def set_map(self, map: OccupancyMap) -> None:
        """Replace the map."""

    def close(self) -> None:
        """End its threads."""


def kernels_of(team: Team) -> list[warming.Needs]:
    """What has to be compiled before a team is driven."""
    found = [warming.Needs("individual", None, live=True)]
    if team.formation is not None:
        found.append(warming.Needs("formation", None, team.planner.variant, moving=True))
    return found


def make_individual(team: Team, map: OccupancyMap) -> IndividualNavigator:
    """The planner of a team's goals of single robots.

    Raises:
        InputError: It refuses the team's values.
    """
    said = team.planner
    settings = replace(
        PLANNING,
        margin=PLANNING.margin if said.margin is None else said.margin,
        constraints=said.constraints or PLANNING.constraints,
        conflict=said.conflict or PLANNING.conflict,
        improve=PLANNING.improve if said.improve is None else said.improve,
        iterations=said.budget.iterations or PLANNING.iterations,
        seconds=said.budget.seconds,
    )
    return IndividualNavigator(team.models, map, team.rate, settings, team.seed)


def make_team_planner(team: Team, map: OccupancyMap) -> FormationPlanner:
    """The planner of a team with a formation, without goals.

    Raises:
        InputError: The planner refuses the team's values, or there is no formation.
    """
    if team.formation is None:
        raise InputError("missing", file=team.file, key="formation")
    try:
        return FormationPlanner(
            map,
            formation_of(team.formation, len(team.robots), team.planner),
            robots=len(team.robots),
            model=max(team.models, key=lambda model: model.length * model.width),
            settings=settings_of(team.planner),
            variant=team.planner.variant,
            rate=team.rate,
            seed=team.seed,
            lookahead=team.planner.lookahead,
            expected=team.expected,
            live=True,
        )
    except InputError as error:
        key = ".".join(part for part in ("planner", error.key) if part)
        raise InputError(error.message, file=team.file, key=key, choices=error.choices) from None
