"""What the live plots keep."""

from __future__ import annotations

import numpy as np
import pytest

from cavalcade.recording.status import PlannerStatus
from cavalcade.robots import robot_model
from cavalcade.scenario import Obstacle
from cavalcade.studio.drive import history
from cavalcade.studio.drive.history import POINTS, Ground, History
from cavalcade.studio.snapshot import Snapshot
from cavalcade.world import Box, OccupancyMap

GO1 = robot_model("go1")
GROUND = Ground(OccupancyMap.empty((20.0, 20.0), 0.1), (Box((10.0, 11.0), (4.0, 1.0)),))


def moment(time: float, *poses: tuple[float, float, float], **more: object) -> Snapshot:
    return Snapshot(time, np.array(poses), **more)  # type: ignore[arg-type]


def test_gaps_are_between_footprints() -> None:
    one, other = (10.0, 10.0, 0.0), (10.0, 9.5, 0.0)
    near, between = history.gaps(moment(0.0, one, other), GROUND, [GO1, GO1])
    assert near == pytest.approx(0.5 - GO1.width / 2.0)
    assert between == pytest.approx(0.5 - GO1.width)
    alone = history.gaps(moment(0.0, (10.0, 5.0, 0.0)), GROUND, [GO1])
    assert np.isnan(alone).all()
    came = Obstacle.model_validate({"circle": {"center": [10.0, 5.5], "radius": 0.1}})
    near, _ = history.gaps(moment(0.0, (10.0, 5.0, 0.0), obstacles=(came,)), GROUND, [GO1])
    assert near == pytest.approx(0.4 - GO1.width / 2.0)


def test_the_formation_error_is_that_of_the_worst_robot() -> None:
    status = PlannerStatus(
        state="partial",
        roles=np.array([0, 1, -1]),
        slots=np.array([[0.5, 0.0], [-0.5, 0.0]]),
        goals=np.zeros((3, 2)),
        paths=(),
        eta=np.zeros(3),
    )
    poses = (3.0, 3.0, 0.0), (3.0, 4.4, 0.0), (9.0, 9.0, 0.0)
    assert history.formation_error(moment(0.0, *poses, status=status)) == pytest.approx(0.2)
    assert np.isnan(history.formation_error(moment(0.0, *poses)))


def test_it_keeps_the_newest_in_memory_of_a_fixed_size() -> None:
    kept = History()
    for k in range(3 * POINTS):
        kept.add(moment(round(0.1 * k, 9), (10.0, 5.0, 0.0)), GROUND, [GO1], 0.002)
    assert len(kept) == POINTS
    time, cycle = kept.curve("cycle")
    assert len(time) == POINTS
    assert np.diff(time) == pytest.approx(np.full(POINTS - 1, 0.2))
    assert time[-1] == pytest.approx(0.1 * (3 * POINTS - 2))
    assert cycle == pytest.approx(np.full(POINTS, 2.0))
    kept.add(moment(0.0, (10.0, 5.0, 0.0)), GROUND, [GO1], 0.0)  # another run
    assert len(kept) == 1
