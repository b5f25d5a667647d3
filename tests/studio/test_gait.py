"""The trot under robots whose legs nobody knows."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from cavalcade.robots import body_of, robot_model
from cavalcade.studio.scene.gait import STRIDE, Trot

_FEET = np.array([(0.2, 0.12), (0.2, -0.12), (-0.2, 0.12), (-0.2, -0.12)])


def _walk(trot: Trot, speed: float, turning: float, steps: int) -> list[tuple[np.ndarray, ...]]:
    """(pose, places, heights) per moment of one robot."""
    found, pose = [], np.array([1.0, 2.0, 0.3])
    for number in range(steps):
        places, lifted = trot.step(0.05 * number, pose[None])
        found.append((pose.copy(), places[0], lifted[0]))
        pose += 0.05 * np.array([speed * np.cos(pose[2]), speed * np.sin(pose[2]), turning])
    return found


@pytest.mark.parametrize(("speed", "turning"), [(0.5, 0.0), (0.3, 0.5), (0.0, 0.8), (-0.3, 0.0)])
def test_feet_on_the_ground_do_not_slide(speed: float, turning: float) -> None:
    moments = _walk(Trot(_FEET, 0.06), speed, turning, 200)
    for (_, before, low), (_, after, lower) in pairwise(moments[20:]):
        standing = (low < 1e-9) & (lower < 1e-9)
        assert np.abs(after - before)[standing] == pytest.approx(0.0, abs=5e-3)
        assert (low < 1e-9).sum() >= 2


def test_feet_step_and_stay_near_the_body() -> None:
    moments = _walk(Trot(_FEET, 0.06), 0.4, 0.0, 200)
    highest = max(float(lifted.max()) for _, _, lifted in moments)
    assert 0.04 < highest <= 0.06
    for pose, places, _ in moments:
        c, s = np.cos(pose[2]), np.sin(pose[2])
        hips = pose[:2] + _FEET @ np.array([[c, s], [-s, c]])
        assert np.hypot(*(places - hips).T).max() <= 0.75 * STRIDE


def test_a_body_at_rest_has_all_feet_down() -> None:
    trot = Trot(_FEET, 0.06)
    _walk(trot, 0.4, 0.0, 33)
    pose = np.array([[1.0, 2.0, 0.3]])
    for number in range(40):
        _, lifted = trot.step(10.0 + 0.05 * number, pose)
    assert lifted.max() < 1e-3


def test_feet_come_along_when_a_body_is_put_elsewhere() -> None:
    trot = Trot(_FEET, 0.06)
    trot.step(0.0, np.zeros((2, 3)))
    places, _ = trot.step(0.1, np.array([[5.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    assert places[0] == pytest.approx(_FEET + (5.0, 0.0))
    assert places[1] == pytest.approx(_FEET)


def test_time_may_go_backwards() -> None:
    trot = Trot(_FEET, 0.06)
    _walk(trot, 0.4, 0.0, 20)
    places, lifted = trot.step(0.0, np.array([[1.1, 2.0, 0.3]]))
    assert np.isfinite(places).all()
    assert np.isfinite(lifted).all()


@pytest.mark.parametrize("name", ["go1", "go2", "spirit"])
def test_legs_reach_the_feet(name: str) -> None:
    model = robot_model(name)
    body = body_of(model)
    assert body is not None
    trot = Trot(body.foot_places(body.standing)[:, :2], 0.06)
    for pose, places, lifted in _walk(trot, 0.45, 0.2, 120):
        c, s = np.cos(pose[2]), np.sin(pose[2])
        flat = (places - pose[:2]) @ np.array([[c, -s], [s, c]])
        height = lifted + body.foot_radius - body.stand_height
        feet = np.column_stack([flat, height])
        assert body.foot_places(body.joints_at(feet)) == pytest.approx(feet, abs=1e-6)
