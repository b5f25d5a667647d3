"""Who takes part, and in which shape."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.errors import InputError
from cavalcade.formation import Formation
from cavalcade.formation.team import Team


def test_losing_and_rejoining_gives_the_old_shape_back():
    square = Formation.square()
    team = Team(4, square)
    team.lose(2)
    assert team.active.tolist() == [0, 1, 3]
    assert team.formation.name == "triangle"
    team.lose(0)
    assert (team.formation.name, team.formation.size) == ("column", 2)
    team.rejoin(2)
    team.rejoin(0)
    assert team.formation is square


def test_losing_a_robot_twice_is_losing_it_once():
    team = Team(3, Formation.line(3))
    team.lose(1)
    team.lose(1)
    assert team.formation.size == 2
    team.rejoin(1)
    team.rejoin(1)
    assert team.formation.size == 3


def test_when_all_are_lost_nobody_is_active():
    team = Team(2, Formation.column(2))
    team.lose(0)
    team.lose(1)
    assert len(team.active) == 0
    team.rejoin(1)
    assert team.formation.size == 1


@pytest.mark.parametrize("robot", [-1, 3])
def test_unknown_robots(robot):
    team = Team(3, Formation.line(3))
    for change in (team.lose, team.rejoin):
        with pytest.raises(InputError, match=r"robot: there is no robot"):
            change(robot)


def test_a_new_shape_may_be_for_those_present_or_for_all():
    team = Team(4, Formation.square())
    team.lose(1)
    team.set_formation(Formation.line(3))
    assert (team.formation.name, team.formation.size) == ("line", 3)
    team.set_formation(Formation.wedge(4))
    assert (team.formation.name, team.formation.size) == ("wedge", 3)
    team.rejoin(1)
    assert (team.formation.name, team.formation.size) == ("wedge", 4)
    with pytest.raises(InputError, match="5 slots"):
        team.set_formation(Formation.line(5))


@pytest.mark.parametrize(
    "shape",
    [
        Formation.triangle(),
        Formation.line(3),
        Formation.circle(3),
        Formation.custom([[0.5, 0.0], [-0.5, 0.5], [-0.5, -0.6]]),
    ],
)
def test_who_rejoins_finds_a_slot_in_a_shape_made_without_it(shape):
    team = Team(4, Formation.square())
    team.lose(1)
    team.set_formation(shape)
    team.rejoin(1)
    assert team.formation.size == 4


def test_pairs_follow_the_roles():
    team = Team(4, Formation.column(4))
    roles = np.array([2, 0, 3, 1])
    joined = {frozenset(pair) for pair in team.joined(roles).tolist()}
    assert joined == {frozenset((1, 3)), frozenset((3, 0)), frozenset((0, 2))}


def test_a_robot_without_a_slot_has_no_springs():
    team = Team(3, Formation.column(3))
    team.lose(1)
    assert team.joined(np.array([1, -1, 0])).tolist() == [[2, 0]]
    assert team.pairs(np.array([-1, -1, 0])).tolist() == [[2, -1]]
