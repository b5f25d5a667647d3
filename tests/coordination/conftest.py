"""Problems in words, and a slow, obvious judge of plans that shares no code with the planner."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from cavalcade.coordination import TeamPlan, TeamProblem, problem_of
from cavalcade.geometry.trajectory import Trajectory
from cavalcade.lattice.ground import Ground, make_ground
from cavalcade.robots import RobotModel, robot_model
from cavalcade.scenario import build_world, parse_scenario
from cavalcade.world import Box, OccupancyMap, Shape
from cavalcade.world.gaps import body_at, gap_between

Array = np.ndarray
Gap = Callable[..., Array]
Pose = tuple[float, float, float]
Robot = tuple[str, Pose, Pose]
FINE = 0.01


def team(
    robots: Sequence[Robot], size: tuple[float, float] = (9.0, 4.0), boxes: Sequence[Any] = ()
) -> TeamProblem:
    """Level ground, `size` in m, with boxes (x0, y0, x1, y1) in m and cells of 0.05 m."""
    solid = np.zeros((round(size[1] / 0.05), round(size[0] / 0.05)), dtype=bool)
    for x0, y0, x1, y1 in np.round(np.array(boxes).reshape(-1, 4) / 0.05).astype(int):
        solid[y0:y1, x0:x1] = True
    names, starts, goals = zip(*robots, strict=True)
    ground = make_ground(OccupancyMap(solid, 0.05))
    return TeamProblem(ground, tuple(map(robot_model, names)), starts, goals)


def team_of_words(
    size: Sequence[float], robots: Sequence[Robot], boxes: Sequence[Any] = (), **world: Any
) -> TeamProblem:
    """The same from a scenario as a file writes it; boxes as (center, size)."""
    words = {
        "version": 1,
        "name": "by-hand",
        "world": {
            "empty": {"size": list(size)},
            "obstacles": [{"box": {"center": c, "size": s}} for c, s in boxes],
            **world,
        },
        "robots": [{"model": m, "start": list(s), "goal": list(g)} for m, s, g in robots],
        "task": {"goals": "individual"},
    }
    scenario = parse_scenario(words)
    return problem_of(scenario, build_world(scenario))


def fine_poses(trajectory: Trajectory, time: Array) -> Array:
    """Poses `(K, 3)` by the cubic that both ends' velocities give, standing at either end."""
    grid, t = trajectory.time, np.clip(time, 0.0, trajectory.time[-1])
    if len(grid) < 2:
        return np.repeat([[*trajectory.position[0, :2], trajectory.yaw[0]]], len(time), axis=0)
    k = np.clip(np.searchsorted(grid, t, side="right") - 1, 0, len(grid) - 2)
    h = grid[k + 1] - grid[k]
    s = (t - grid[k]) / h
    out = np.empty((len(time), 3))
    for axis in (0, 1):
        p, v = trajectory.position[:, axis], trajectory.velocity[:, axis]
        out[:, axis] = (
            (1 + 2 * s) * (1 - s) ** 2 * p[k]
            + s * (1 - s) ** 2 * h * v[k]
            + s**2 * (3 - 2 * s) * p[k + 1]
            + s**2 * (s - 1) * h * v[k + 1]
        )
    out[:, 2] = trajectory.yaw[k] + s * (trajectory.yaw[k + 1] - trajectory.yaw[k])
    return out


def shape_of(model: RobotModel) -> tuple[float, float, bool]:
    return model.length / 2, model.width / 2, model.round


def _least_gap(gap: Gap, one: RobotModel, poses: Array, other: RobotModel, there: Array) -> float:
    reach = math.hypot(*shape_of(one)[:2]) + math.hypot(*shape_of(other)[:2])
    near = np.hypot(*(poses - there).T[:2]) < reach + 0.1
    if not near.any():
        return math.inf
    return float(gap(shape_of(one), poses[near], shape_of(other), there[near]).min())


def _ground_gap(gap: Gap, model: RobotModel, poses: Array, ground: Ground) -> float:
    """Least distance to solid cells, but those of known shapes, and to the grid's border."""
    cell = ground.cell
    half_length, half_width, is_round = shape_of(model)
    c, s = np.abs(np.cos(poses[:, 2])), np.abs(np.sin(poses[:, 2]))
    span_x = np.full(len(poses), half_length) if is_round else c * half_length + s * half_width
    span_y = np.full(len(poses), half_length) if is_round else s * half_length + c * half_width
    width, height = ground.solid.shape[1] * cell, ground.solid.shape[0] * cell
    x, y = poses[:, 0], poses[:, 1]
    border = np.stack([x - span_x, width - x - span_x, y - span_y, height - y - span_y])
    least = float(border.min())
    part = ground.outlines.part
    rows, cols = np.nonzero(ground.solid & (part < 0) if part.size else ground.solid)
    if not len(rows):
        return least
    squares = np.column_stack([(cols + 0.5) * cell, (rows + 0.5) * cell, np.zeros(len(rows))])
    tree = cKDTree(squares[:, :2])
    near = tree.query_ball_point(poses[:, :2], math.hypot(half_length, half_width) + cell)
    which = np.repeat(np.arange(len(poses)), [len(found) for found in near])
    if len(which):
        cells = squares[np.concatenate([found for found in near if found]).astype(int)]
        square = (cell / 2, cell / 2, False)
        least = min(least, float(gap(shape_of(model), poses[which], square, cells).min()))
    return least


def _least_gap_to_shapes(
    gap: Gap, model: RobotModel, poses: Array, shapes: Sequence[Shape]
) -> float:
    reach = math.hypot(*shape_of(model)[:2])
    least = math.inf
    for shape in shapes:
        near = poses[shape.distance(poses[:, :2]) < reach + FINE]
        if not len(near):
            continue
        if isinstance(shape, Box):
            box = (shape.size[0] / 2, shape.size[1] / 2, False)
            there = np.repeat([[*shape.center, shape.yaw]], len(near), axis=0)
            least = min(least, float(gap(shape_of(model), near, box, there).min()))
        else:
            least = min([least, *(gap_between(body_at(model, pose), shape) for pose in near)])
    return least


def in_ground(problem: TeamProblem, t: Trajectory) -> Trajectory:
    """A trajectory of the map's frame, seen in the ground's."""
    x, y, yaw = problem.origin
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, -s], [s, c]])
    position, velocity = t.position.copy(), t.velocity.copy()
    position[:, :2] = (t.position[:, :2] - (x, y)) @ turn
    velocity[:, :2] = t.velocity[:, :2] @ turn
    return replace(t, position=position, velocity=velocity, yaw=t.yaw - yaw)


def _judge_motion(model: RobotModel, t: Trajectory) -> None:
    """What a robot's drive can do."""
    dt = np.diff(t.time)
    speed = np.hypot(t.velocity[:, 0], t.velocity[:, 1])
    push = np.hypot(*(np.diff(t.velocity[:, :2], axis=0) / dt[:, None]).T)
    rate = np.abs(np.diff(t.yaw)) / dt
    ahead = t.velocity[:, 0] * np.cos(t.yaw) + t.velocity[:, 1] * np.sin(t.yaw)
    across = t.velocity[:, 1] * np.cos(t.yaw) - t.velocity[:, 0] * np.sin(t.yaw)
    change = np.diff(t.position[:, :2], axis=0)
    mean = 0.5 * (t.velocity[1:, :2] + t.velocity[:-1, :2]) * dt[:, None]
    assert np.abs(change - mean).max(initial=0.0) < 1e-3
    if model.legs is not None:
        assert speed.max() <= model.legs.v_max + 1e-9
        assert push.max(initial=0.0) <= model.legs.mu * 9.81
        assert rate.max(initial=0.0) <= 1.05 * model.legs.yaw_rate
        # Back steps are short and slow.
        assert ahead.min() >= -0.3 - 1e-9
    else:
        assert speed.max() <= model.max_speed_x + 1e-9
        assert push.max(initial=0.0) <= max(model.max_acceleration, 2.0) * 1.001 + 1e-9
        assert rate.max(initial=0.0) <= model.max_yaw_rate * 1.001
    if model.drive in ("legged", "unicycle", "unicycle-2"):
        assert np.abs(across).max() < 1e-6
    if model.drive == "unicycle-2":
        assert np.abs(np.diff(rate)).max(initial=0.0) <= model.max_yaw_acceleration * 0.0301 * 1.01


def judge(
    gap: Gap, problem: TeamProblem, plan: TeamPlan, distance: float | None = None
) -> dict[str, float]:
    """Assert all that a plan on level ground promises.

    Args:
        gap: Of footprints.
        problem, plan: What was asked and answered.
        distance: Between centres, instead of bodies that keep clear of each other.

    Returns:
        Summed length and makespan.
    """
    assert plan.solved, (plan.reason, plan.detail)
    assert plan.reason == "solved"
    assert plan.detail == ""
    assert plan.iterations >= 1
    trajectories = [in_ground(problem, t) for t in plan.trajectories if t is not None]
    assert len(trajectories) == len(problem.models)
    end = max(t.duration for t in trajectories)
    time = np.arange(0.0, end + 1.0, FINE)
    tracks = []
    for model, start, goal, t in zip(
        problem.models, problem.starts, problem.goals, trajectories, strict=True
    ):
        assert t.time[0] == 0.0
        assert np.diff(t.time).min(initial=1.0) > 0.0
        assert np.diff(t.time).max(initial=0.0) <= 0.03 + 1e-9
        for k, pose in ((0, start), (-1, goal)):
            assert t.position[k, :2] == pytest.approx(pose[:2], abs=1e-6)
            assert np.abs(t.velocity[k]).max() < 1e-9
            if not model.drive.startswith("integrator"):
                assert math.remainder(t.yaw[k] - pose[2], 2 * math.pi) == pytest.approx(0, abs=1e-6)
        _judge_motion(model, t)
        poses = fine_poses(t, time)
        assert _ground_gap(gap, model, poses, problem.ground) > -1e-6
        in_map = fine_poses(plan.trajectories[len(tracks)], time)
        assert _least_gap_to_shapes(gap, model, in_map, problem.shapes) > 0.0
        tracks.append(poses)
    for i, j in combinations(range(len(tracks)), 2):
        if distance is not None:
            apart = np.hypot(*(tracks[i] - tracks[j]).T[:2]).min()
            assert apart >= distance - 0.01, f"robots {i} and {j}"
            continue
        least = _least_gap(gap, problem.models[i], tracks[i], problem.models[j], tracks[j])
        assert least > 0.0, f"robots {i} and {j}"
    return {"length": sum(t.length for t in trajectories), "makespan": end}


def plan_bytes(plan: TeamPlan) -> bytes:
    """All that is in the trajectories."""
    parts = []
    for t in plan.trajectories:
        if t is not None:
            parts += [t.time, t.position, t.velocity, t.yaw, t.phase]
    return b"".join(part.tobytes() for part in parts)


def straight_sum(problem: TeamProblem) -> float:
    """Of the straight lines from starts to goals, m."""
    pairs = zip(problem.starts, problem.goals, strict=True)
    return sum(math.dist(a[:2], b[:2]) for a, b in pairs)


@pytest.fixture(scope="session")
def make_team() -> Callable[..., TeamProblem]:
    return team


@pytest.fixture(scope="session")
def make_team_of_words() -> Callable[..., TeamProblem]:
    return team_of_words


@pytest.fixture(scope="session")
def judged(footprint_gap: Gap) -> Callable[..., dict[str, float]]:
    """`judge` with the footprints' distances."""

    def judging(problem: TeamProblem, plan: TeamPlan, distance: float | None = None) -> Any:
        return judge(footprint_gap, problem, plan, distance)

    return judging


@pytest.fixture(scope="session")
def bytes_of() -> Callable[[TeamPlan], bytes]:
    return plan_bytes


@pytest.fixture(scope="session")
def straight() -> Callable[[TeamProblem], float]:
    return straight_sum
