"""True and false claims of having arrived."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.checking.arrival import check_arrival
from cavalcade.checking.tracks import Track

GOAL = (8.0, 5.0, np.pi / 2)
COLUMN = [(8.0, 6.0), (8.0, 5.0), (8.0, 4.0)]


def standing(places, yaw=np.pi / 2, drift=(0.0, 0.0)):
    time = 0.05 * np.arange(41)
    return tuple(
        Track(
            time,
            np.column_stack(
                (np.array(place) + np.outer(time - time[-1], drift), np.full(len(time), yaw))
            ),
        )
        for place in places
    )


@pytest.fixture
def claims(make_scenario):
    def give(tracks, moved=0.0, **changes):
        task = changes.pop(
            "task", {"formation": {"shape": "column", "spacing": 1.0}, "goals": [list(GOAL)]}
        )
        starts = [[1.0 + k, 1.0, 0.0] for k in range(len(tracks))]
        scenario = make_scenario(starts, task=task, **changes)
        return [v.message for v in check_arrival(scenario, tracks, moved)]

    return give


def test_in_the_slots_in_any_order(claims):
    assert claims(standing(COLUMN)) == []
    assert claims(standing(COLUMN[::-1])) == []
    assert claims(standing([COLUMN[1], COLUMN[2], COLUMN[0]])) == []


def test_one_robot_off_its_slot(claims):
    assert claims(standing([COLUMN[0], (8.09, 5.0), COLUMN[2]])) == []
    (message,) = claims(standing([COLUMN[0], (8.12, 5.0), COLUMN[2]]))
    assert "robot 1" in message
    assert "0.120 m" in message


def test_two_robots_cannot_share_a_slot(claims):
    assert len(claims(standing([COLUMN[0], COLUMN[1], (8.05, 5.0)]))) == 1


def test_a_moved_goal_counts_only_as_far_as_the_summary_says(claims):
    shifted = [(x + 0.3, y - 0.4) for x, y in COLUMN]
    assert claims(standing(shifted), moved=0.5) == []
    assert claims(standing(shifted), moved=0.45) == []  # 0.05 m of the 0.10 m are used
    assert len(claims(standing(shifted), moved=0.3)) == 3
    assert len(claims(standing(shifted))) == 3


def test_facing_elsewhere(claims):
    assert claims(standing(COLUMN, yaw=np.pi / 2 + 0.14)) == []
    assert len(claims(standing(COLUMN, yaw=np.pi / 2 - 0.2))) == 3
    assert claims(standing(COLUMN, yaw=np.pi / 2 + 2 * np.pi)) == []


def test_still_moving(claims):
    assert claims(standing(COLUMN, drift=(0.015, 0.0))) == []
    assert len(claims(standing(COLUMN, drift=(0.03, 0.0)))) == 3


def test_goals_and_shapes_that_events_replaced(claims):
    events = [
        {"at": 0.5, "goals": [[3.0, 3.0, 0.0], [8.0, 5.0, np.pi / 2]]},
        {"at": 1.0, "formation": {"shape": "line", "spacing": 1.0}},
        {"at": 99.0, "goals": [[1.0, 1.0, 0.0]]},
    ]
    line = [(9.0, 5.0), (8.0, 5.0), (7.0, 5.0)]
    execution = {"execution": {"events": events}}
    assert claims(standing(line), **execution) == []
    assert claims(standing(COLUMN), **execution) != []


def test_a_lost_robot_may_stand_anywhere(claims):
    events = [{"at": 1.0, "lose": 2}]
    places = [(8.0, 5.5), (8.0, 4.5), (2.0, 2.0)]
    assert claims(standing(places), execution={"events": events}) == []
    far = [(8.0, 5.5), (8.0, 2.5), (2.0, 2.0)]
    assert len(claims(standing(far), execution={"events": events})) == 1


@pytest.mark.parametrize(
    ("shape", "robots", "apart"),
    [
        ({"shape": "square", "side": 1.0}, 4, 1.0),
        ({"shape": "triangle", "side": 1.15}, 3, 1.15),
        ({"shape": "line", "spacing": 0.8}, 5, 0.8),
        ({"shape": "column", "spacing": 0.9}, 4, 0.9),
        ({"shape": "wedge", "spacing": 1.0}, 5, 1.0),
        ({"shape": "circle", "radius": 1.0}, 6, 1.0),
    ],
)
def test_neighbouring_slots_lie_as_far_apart_as_the_file_says(make_scenario, shape, robots, apart):
    from cavalcade.checking.arrival import slots_of

    starts = [[0.5 + 0.8 * k, 1.0, 1.57] for k in range(robots)]
    scenario = make_scenario(starts, task={"formation": shape, "goals": [[5, 5, 0]]})
    slots = slots_of(scenario.task.formation, robots)
    gaps = np.hypot(*(slots[:, None] - slots[None]).transpose(2, 0, 1))
    np.fill_diagonal(gaps, np.inf)
    assert slots.shape == (robots, 2)
    np.testing.assert_allclose(gaps.min(axis=1), apart)
    np.testing.assert_allclose(slots.mean(axis=0), 0.0, atol=1e-12)
