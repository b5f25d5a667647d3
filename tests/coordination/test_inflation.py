"""Bodies inflated for planning, by less where that leaves no plan."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from cavalcade.coordination import PlanSettings, TeamProblem, plan_team
from cavalcade.coordination.conflicts import conflicts_of
from cavalcade.coordination.plan import inflated
from cavalcade.errors import InputError
from cavalcade.lattice.ground import make_ground
from cavalcade.robots import MODELS
from cavalcade.world import OccupancyMap

GO1 = MODELS["go1"]
GROUND = make_ground(OccupancyMap.empty((9.0, 4.0)), None)
SWAP = TeamProblem(GROUND, (GO1, GO1), ((2, 2, 0), (7, 2, np.pi)), ((7, 2, 0), (2, 2, np.pi)))


def clear(problem, found, margin):
    """Whether bodies that are `margin` wider never meet on their way."""
    end = max(path.duration for path in found.trajectories)
    times = np.arange(0.0, end + 0.02, 0.02)
    tracks = [path.poses_at(times) for path in found.trajectories]
    models = [inflated(model, margin) for model in problem.models]
    return not any(
        conflicts_of([tracks[i], tracks[j]], (models[i], models[j]), 1)
        for i, j in combinations(range(len(tracks)), 2)
    )


def test_bodies_keep_the_margin_that_is_asked_for():
    bare = plan_team(SWAP)
    found = plan_team(SWAP, settings=PlanSettings(margin=0.15))
    assert found.solved
    assert found.margins == (0.15, 0.15)
    assert bare.margins == ()
    assert clear(SWAP, found, 0.15)
    assert not clear(SWAP, bare, 0.15)


def test_who_stands_close_gets_less_and_the_others_all():
    # Robots 0 and 1 begin with 6 cm between their sides, nobody else is near.
    starts = ((2.0, 2.0, 0.0), (2.0, 2.0 + GO1.width + 0.06, 0.0), (7.0, 1.0, 0.0))
    goals = ((6.0, 2.0, 0.0), (6.0, 3.0, 0.0), (3.0, 1.0, 0.0))
    problem = replace(SWAP, models=(GO1,) * 3, starts=starts, goals=goals)
    found = plan_team(problem, settings=PlanSettings(margin=0.05))
    assert found.solved
    assert found.margins == (0.025, 0.025, 0.05)


def test_a_plan_that_only_exists_without_is_found():
    # A wall with a door that the body alone passes.
    solid = np.zeros((80, 180), dtype=bool)
    solid[:, 90:92] = True
    solid[37:43, 90:92] = False
    ground = make_ground(OccupancyMap(solid, 0.05), None)
    problem = TeamProblem(ground, (GO1,), ((2, 2, 0),), ((7, 2, 0),))
    found = plan_team(problem, settings=PlanSettings(margin=0.2, iterations=50_000))
    assert found.solved
    assert found.margins == (0.0,)


def test_what_is_impossible_stays_so_and_is_soon_said():
    problem = replace(SWAP, goals=((7, 2, 0), (7.1, 2, 0)))
    found = plan_team(problem, settings=PlanSettings(margin=0.05))
    assert found.reason == "infeasible"
    assert found.involved == (0, 1)
    assert found.iterations == 0


def test_no_margin_is_no_change():
    bare, found = plan_team(SWAP), plan_team(SWAP, settings=PlanSettings(margin=0.0))
    for one, other in zip(bare.trajectories, found.trajectories, strict=True):
        assert one.position.tobytes() == other.position.tobytes()


def test_margins_out_of_range():
    with pytest.raises(InputError, match=r"planner\.margin: expected 0 to 1 m"):
        PlanSettings(margin=-0.1)
