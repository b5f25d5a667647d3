"""Grounds, and a slow, obvious judge of plans that shares no code with the planner."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from cavalcade.geometry.trajectory import Trajectory
from cavalcade.kinodynamic.planner import BodyPlan
from cavalcade.lattice.ground import Ground, make_ground
from cavalcade.robots import RobotModel, robot_model
from cavalcade.world import OccupancyMap
from cavalcade.world.terrain import generate_terrain

WALK, TAKE_OFF, FLIGHT, LANDING = 0, 1, 2, 3
G = 9.81
CELL = 0.05


def flat_ground(width: float = 9.0, height: float = 4.0, boxes: tuple = ()) -> Ground:
    """Level ground with solid boxes (x0, y0, x1, y1) in m."""
    solid = np.zeros((round(height / CELL), round(width / CELL)), dtype=bool)
    for x0, y0, x1, y1 in boxes:
        solid[round(y0 / CELL) : round(y1 / CELL), round(x0 / CELL) : round(x1 / CELL)] = True
    return make_ground(OccupancyMap(solid, CELL))


def terrain_ground(kind: str, size: tuple = (9.0, 4.0), seed: int = 0, **options: float) -> Ground:
    terrain = generate_terrain(kind, size, seed, **options)
    return make_ground(OccupancyMap(np.zeros(terrain.height.shape, bool), CELL), terrain)


def value_at(layer: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Bilinear values `(N,)` at points `(N, 2)` x, y."""
    if layer.shape == (1, 1):
        return np.full(len(points), layer[0, 0])
    at = np.asarray(points).T[::-1] / CELL - 0.5
    return map_coordinates(layer, at, order=1, mode="nearest")


def body_points(pose: np.ndarray, pitch: float, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
    """Points of the body in the world, `(N, 3)`; pose is x, y, z, yaw."""
    x, y, z, yaw = pose
    along, up = xs * math.cos(pitch), xs * math.sin(pitch)
    c, s = math.cos(yaw), math.sin(yaw)
    return np.stack([x + c * along - s * ys, y + s * along + c * ys, z + up], axis=1)


def in_solid(ground: Ground, model: RobotModel, x: float, y: float, yaw: float) -> bool:
    """Whether a dense grid of the footprint's points touches anything solid or leaves the map."""
    u, v = np.meshgrid(
        np.linspace(-0.5, 0.5, 53) * (model.length - 1e-6),
        np.linspace(-0.5, 0.5, 29) * (model.width - 1e-6),
    )
    c, s = math.cos(yaw), math.sin(yaw)
    col = np.floor((x + c * u - s * v) / CELL).astype(int)
    row = np.floor((y + s * u + c * v) / CELL).astype(int)
    rows, cols = ground.solid.shape
    if (col < 0).any() or (row < 0).any() or (col >= cols).any() or (row >= rows).any():
        return True
    return bool(ground.solid[row, col].any())


def state_problem(
    ground: Ground, model: RobotModel, pose: np.ndarray, phase: int, slack: float = 0.0
) -> str:
    """What is wrong with a body at x, y, z, yaw, as the design says it; empty if nothing."""
    legs = model.legs
    x, y, _, yaw = pose
    if in_solid(ground, model, x, y, yaw):
        return "solid"
    here = np.array([[x, y]])
    slope = math.cos(yaw) * value_at(ground.slope_x, here)[0]
    slope += math.sin(yaw) * value_at(ground.slope_y, here)[0]
    pitch = math.atan(slope)
    half_l, half_w = legs.trunk_length / 2, legs.trunk_width / 2
    belly = body_points(
        pose,
        pitch,
        np.array([0, half_l, half_l, -half_l, -half_l]),
        np.array([0, half_w, -half_w, half_w, -half_w]),
    )
    room = belly[:, 2] - legs.trunk_height / 2 - value_at(ground.height, belly[:, :2])
    if room.min() < legs.h_min - slack:
        return "belly"
    if phase == FLIGHT:
        return ""
    if value_at(ground.traversability, here)[0] < 0.3 - slack:
        return "footing"
    xs = np.array([-1, -1] if phase == TAKE_OFF else [-1, -1, 1, 1]) * legs.hip_x
    ys = np.array([1, -1] if phase == TAKE_OFF else [1, -1, 1, -1]) * legs.hip_y
    hips = body_points(pose, pitch, xs, ys)
    if value_at(ground.traversability, hips[:, :2]).min() < 0.3 - slack:
        return "footing"
    if (hips[:, 2] - value_at(ground.height, hips[:, :2])).max() > legs.h_max + slack:
        return "reach"
    return ""


def stretches(trajectory: Trajectory) -> list[tuple[int, int, int]]:
    """Phases with the numbers of their first and last samples."""
    out, first = [], 0
    last = len(trajectory.time) - 1
    for k in range(1, last + 1):
        if k == last or trajectory.phase[k] != trajectory.phase[first]:
            out.append((int(trajectory.phase[first]), first, k))
            first = k
    return out


def judge(
    plan: BodyPlan,
    ground: Ground,
    model: RobotModel,
    start: tuple,
    goal: tuple,
    published: bool = False,
) -> None:
    """Assert all that a plan promises."""
    t = plan.trajectory
    legs = model.legs
    assert t is not None
    assert plan.reason == "solved"
    assert t.time[0] == 0.0
    dt = np.diff(t.time)
    assert dt.min() > 0.0
    assert dt.max() <= 0.03 + 1e-9
    for k, pose in ((0, start), (-1, goal)):
        assert np.allclose(t.position[k, :2], pose[:2], atol=1e-9)
        assert abs(math.remainder(t.yaw[k] - pose[2], 2 * math.pi)) < 1e-6
        assert np.abs(t.velocity[k]).max() < 1e-9
    assert np.abs(np.diff(t.yaw)).max() < math.pi
    speed = np.hypot(t.velocity[:, 0], t.velocity[:, 1])
    assert speed.max() <= legs.v_max + 1e-9
    moving = speed > 0.05
    along = np.arctan2(t.velocity[:, 1], t.velocity[:, 0])
    off = np.remainder(t.yaw - along + math.pi, 2 * math.pi) - math.pi
    assert np.abs(off[moving]).max(initial=0.0) < 1e-6
    for k in range(len(t.time)):
        pose = np.array([*t.position[k], t.yaw[k]])
        # At the end of a phase the rules of both hold, but for what the next one lifts.
        wrong = state_problem(ground, model, pose, int(t.phase[k]), 1e-6)
        assert wrong == "", f"{wrong} at sample {k} in phase {t.phase[k]}"
    for phase, first, last in stretches(t):
        _judge_motion(t, legs, phase, first, last, published)


def _judge_motion(t, legs, phase, first, last, published) -> None:
    p, v, time = (
        t.position[first : last + 1],
        t.velocity[first : last + 1],
        t.time[first : last + 1],
    )
    dt = np.diff(time)[:, None]
    down = np.array([0.0, 0.0, -G])
    if phase == WALK:
        push = np.diff(v[:, :2], axis=0) / dt
        assert np.hypot(push[:, 0], push[:, 1])[: None if not published else -1].max() <= (
            legs.mu * G * 1.001 + (2.0 if published else 0.0)
        )
        if not published:
            assert np.abs(np.diff(t.yaw[first : last + 1]) / dt[:, 0]).max() <= 1.05 * legs.yaw_rate
            # The cubic that both ends' velocities give.
            assert np.abs(np.diff(p, axis=0) - 0.5 * (v[1:] + v[:-1]) * dt).max() < 2e-3
    elif phase == FLIGHT:
        s = time - time[0]
        s = s[:, None]
        inner = slice(None, -1) if published else slice(None)
        assert np.abs(p - (p[0] + v[0] * s + 0.5 * down * s * s)).max() < 1e-9
        assert np.abs(v - (v[0] + down * s))[inner].max() < 1e-9
    else:
        s = (time - time[0])[:, None]
        span = s[-1, 0]
        # The peak force from the way alone, since a published landing's last speed jumps.
        force = 3.0 / (G * span**2) * (p[-1] - p[0] - v[0] * span - 0.5 * down * span**2)
        assert force[2] >= 1.0 - 1e-9
        assert np.linalg.norm(force) <= legs.grf_max + 1e-9
        assert np.hypot(force[0], force[1]) <= legs.mu * force[2] + 1e-9
        way = G * force * (2 * s**3 / (3 * span) - s**4 / (3 * span**2))
        assert np.abs(p - (p[0] + v[0] * s + way + 0.5 * down * s * s)).max() < 1e-9
        gain = G * force * (2 * s**2 / span - 4 * s**3 / (3 * span**2))
        inner = slice(None, -1) if published else slice(None)
        assert np.abs(v - (v[0] + gain + down * s))[inner].max() < 1e-9


@pytest.fixture
def spirit() -> RobotModel:
    return robot_model("spirit")


@pytest.fixture(params=["spirit", "go1", "go2"])
def model(request: pytest.FixtureRequest) -> RobotModel:
    return robot_model(request.param)


@pytest.fixture
def make_terrain() -> Callable[..., Ground]:
    return terrain_ground


@pytest.fixture
def make_flat() -> Callable[..., Ground]:
    return flat_ground


@pytest.fixture
def judged() -> Callable[..., None]:
    return judge


@pytest.fixture(scope="session")
def reference_problem() -> Callable[..., str]:
    return state_problem


@pytest.fixture(scope="session")
def reference_solid() -> Callable[..., bool]:
    return in_solid


@pytest.fixture(scope="session")
def rough() -> Ground:
    return terrain_ground("rough", seed=1)


@pytest.fixture(scope="session")
def cluttered() -> Ground:
    return flat_ground(boxes=((2.0, 0.0, 2.3, 2.0), (4.5, 2.4, 4.8, 4.0), (6.2, 1.0, 6.5, 1.8)))
