"""Turns, the grid of metres and the first view."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cavalcade.studio.scene import camera, rotations
from cavalcade.studio.scene.scale import grid_lines, spacing

_SQUARE = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])


def _as_scipy(turns: np.ndarray) -> Rotation:
    return Rotation.from_quat(turns[..., [1, 2, 3, 0]])


def test_turns_are_those_of_scipy() -> None:
    rng = np.random.default_rng(1)
    a, b = (Rotation.random(20, random_state=seed) for seed in (1, 2))
    first, second = (one.as_quat()[:, [3, 0, 1, 2]] for one in (a, b))
    vectors = rng.normal(size=(20, 3))
    assert rotations.turned(first, vectors) == pytest.approx(a.apply(vectors))
    both = _as_scipy(rotations.product(first, second))
    assert both.apply(vectors) == pytest.approx((a * b).apply(vectors))
    back = rotations.turned(rotations.inverse(first), rotations.turned(first, vectors))
    assert back == pytest.approx(vectors)


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5, np.pi])
@pytest.mark.parametrize("pitch", [0.0, 0.3, -0.4])
@pytest.mark.parametrize("roll", [0.0, 0.2, -0.3])
def test_bodies_lie_along_slopes(yaw: float, pitch: float, roll: float) -> None:
    turn = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    forward, left = turn.apply([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
    found = _as_scipy(rotations.from_axes(forward[None], left[None]))
    assert found.apply((1.0, 0.0, 0.0))[0] == pytest.approx(forward)
    assert found.apply((0.0, 1.0, 0.0))[0] == pytest.approx(left)


def test_sticks_lie_along_their_ways() -> None:
    ways = np.random.default_rng(5).normal(size=(20, 3))
    turns = _as_scipy(rotations.along(ways))
    length = np.linalg.norm(ways, axis=1, keepdims=True)
    assert turns.apply((1.0, 0.0, 0.0)) == pytest.approx(ways / length)
    assert turns.apply((0.0, 1.0, 0.0))[:, 2] == pytest.approx(0.0)


def test_lines_stand_at_whole_metres_inside_the_map() -> None:
    lines, strong = grid_lines(_SQUARE, 1)
    upright = lines[lines[:, 0, 0] == lines[:, 1, 0]]
    assert upright[:, 0, 0].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert upright[:, :, 1].tolist() == [[0.0, 3.0]] * 5
    assert len(lines) == 9
    assert strong.sum() == 2


def test_lines_of_a_turned_map_end_at_its_border() -> None:
    turn = Rotation.from_euler("z", 0.5).as_matrix()[:2, :2]
    corners = _SQUARE @ turn.T + (7.3, -2.2)
    lines, _ = grid_lines(corners, 1)
    inside = (lines.reshape(-1, 2) - (7.3, -2.2)) @ turn
    assert (inside >= -1e-9).all()
    assert (inside <= np.array([4.0, 3.0]) + 1e-9).all()
    on_border = np.minimum(np.abs(inside), np.abs(inside - (4.0, 3.0))).min(axis=1)
    assert on_border == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("extent", "step"), [(0.5, 1), (60.0, 1), (61.0, 2), (3000.0, 50)])
def test_large_maps_have_few_lines(extent: float, step: int) -> None:
    assert spacing(extent) == step


@pytest.mark.parametrize("towards", [np.pi / 2.0, 0.3])
def test_all_points_are_in_view(towards: float) -> None:
    points = np.random.default_rng(3).uniform((-5, 2, 0), (20, 9, 1), (40, 3))
    eye, target = camera.view_of(points, towards)
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    depth = (points - eye) @ ahead
    tall = np.tan(np.radians(45.0) / 2.0)
    assert (depth > 0.0).all()
    assert (np.abs((points - eye) @ up) <= tall * depth).all()
    assert (np.abs((points - eye) @ right) <= 1.15 * tall * depth).all()


def test_one_point_is_seen_from_some_distance() -> None:
    eye, target = camera.view_of(np.zeros((1, 3)))
    assert np.linalg.norm(eye - target) == pytest.approx(4.0)
