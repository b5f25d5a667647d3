"""A made-up run: four robots in a square cross a cluttered arena, squeeze and swap slots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cavalcade.geometry import rotation, transform_points, wrap_angle
from cavalcade.recording.frames import ObstacleTrack, Recording
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import Scenario, World
from cavalcade.world import OccupancyMap, shape_from_mapping

OBSTACLES: list[dict[str, Any]] = [
    {"box": {"center": [4.9, 7.3], "size": [1.5, 1.6], "yaw": 0.25}},
    {"box": {"center": [4.7, 3.9], "size": [1.3, 1.8], "yaw": -0.15}},
    {"circle": {"center": [6.9, 5.1], "radius": 0.22}},
    {"circle": {"center": [3.2, 2.3], "radius": 0.45}},
    {"circle": {"center": [7.6, 8.5], "radius": 0.6}},
    {"polygon": {"points": [[8.7, 1.0], [9.9, 1.5], [9.6, 3.1], [9.1, 2.2], [8.2, 2.4]]}},
    {"box": {"center": [9.3, 6.6], "size": [0.5, 1.8], "yaw": 0.1}},
    {"box": {"center": [9.5, 3.6], "size": [0.4, 1.4], "yaw": 0.3}},
    {"circle": {"center": [11.2, 8.3], "radius": 0.35}},
    {"box": {"center": [6.6, 1.6], "size": [1.4, 0.35], "yaw": 0.7}},
    {"circle": {"center": [12.2, 2.2], "radius": 0.25}},
    {"box": {"center": [2.0, 8.2], "size": [0.9, 0.3], "yaw": 1.1}},
]
MOVER: dict[str, Any] = {"circle": {"center": [11.5, 9.0], "radius": 0.3}}
SLOTS = np.array([[0.71, 0.0], [0.0, 0.71], [0.0, -0.71], [-0.71, 0.0]])
JOINTS = [(0, 1), (0, 2), (1, 3), (2, 3), (0, 3), (1, 2)]


@dataclass(frozen=True)
class Run:
    """All that a picture is made from."""

    scenario: Any
    world: Any
    recording: Recording
    summary: dict[str, Any]


def made_up_run(cycles: int = 240, duration: float = 30.0, robots: int = 4) -> Run:
    """A run of any length; up to four robots of a square."""
    slots, joints = SLOTS, JOINTS
    if robots != 4:
        angles = 2.0 * np.pi * np.arange(robots) / robots
        radius = 0.0 if robots == 1 else max(0.7, 0.75 / (2.0 * np.sin(np.pi / robots)))
        slots = radius * np.column_stack([np.cos(angles), np.sin(angles)])
        joints = [(i, (i + 1) % robots) for i in range(robots)] if robots > 2 else []
        joints = [(min(p), max(p)) for p in joints] or ([(0, 1)] if robots == 2 else [])
    scenario = Scenario.model_validate(
        {
            "version": 1,
            "name": "made-up-clutter",
            "world": {"empty": {"size": [14, 10]}, "obstacles": OBSTACLES},
            "robots": [
                {"model": "go1", "start": [*(slots[k] + (1.6, 5.2)), 0.0]} for k in range(robots)
            ],
            "task": {
                "formation": {"shape": "custom", "slots": slots.tolist()},
                "goals": [[12.4, 5.0, 0.0]],
            },
            "planner": {"lookahead": 5.0},
            "execution": {
                "events": [{"at": 12.0, "move": {**MOVER, "to": [11.5, 7.0], "speed": 0.25}}]
            },
        }
    )
    shapes = tuple(shape_from_mapping(mapping) for mapping in OBSTACLES)
    base = OccupancyMap.empty((14.0, 10.0), 0.05)
    world = World(base.with_shapes(shapes), base, shapes, ())
    time = np.linspace(0.0, duration, cycles)
    poses, part = _motion(time / duration, slots, robots)
    status = tuple(
        _status(part[i], poses[i], poses[min(i + cycles // 6, cycles - 1)], slots, joints)
        for i in range(cycles)
    )
    recording = Recording(
        time=time,
        poses=poses,
        estimated=poses.copy(),
        commands=np.zeros_like(poses),
        status=status,
        obstacles=(
            ObstacleTrack(
                shape=MOVER,
                start=0.4 * duration,
                end=np.inf,
                time=np.array([0.4, 0.67]) * duration,
                offset=np.array([[0.0, 0.0], [0.0, -2.0]]),
            ),
        ),
        notes=((0.4 * duration, "obstacle moves to (11.5, 7.0)"),),
    )
    return Run(scenario, world, recording, _summary(robots, duration))


def _motion(part: NDArray[np.float64], slots: NDArray[np.float64], robots: int) -> Any:
    knots = np.array(
        [[1.6, 5.2], [3.6, 5.4], [4.8, 5.6], [6.6, 5.9], [8.2, 5.4], [9.4, 5.0], [12.4, 5.0]]
    )
    smooth = np.clip(part * 1.08, 0.0, 1.0)
    smooth = smooth + 0.05 * np.sin(2.0 * np.pi * smooth) / np.pi
    at = np.linspace(0.0, 1.0, len(knots))
    fine = np.linspace(0.0, 1.0, 400)
    kernel = np.hanning(61) / np.hanning(61).sum()
    columns = []
    for axis in (0, 1):
        raw = np.interp(fine, at, knots[:, axis])
        padded = np.concatenate([np.full(30, raw[0]), raw, np.full(30, raw[-1])])
        columns.append(np.interp(smooth, fine, np.convolve(padded, kernel, mode="valid")))
    centre = np.column_stack(columns)
    squeeze = 1.0 - 0.62 * np.exp(-(((centre[:, 0] - 4.8) / 0.9) ** 2))
    squeeze -= 0.58 * np.exp(-(((centre[:, 0] - 9.4) / 0.8) ** 2))
    swap = 0.5 + 0.5 * np.tanh((centre[:, 0] - 6.4) / 0.5)
    poses = np.zeros((len(part), robots, 3))
    for i, c in enumerate(centre):
        ahead = centre[min(i + 4, len(centre) - 1)] - centre[max(i - 4, 0)]
        heading = np.arctan2(ahead[1], ahead[0]) if np.hypot(*ahead) > 1e-6 else 0.0
        own = slots.copy()
        if robots == 4:  # robots 0 and 1 exchange their slots, round each other
            turn = rotation(-np.pi * swap[i])
            middle = (slots[0] + slots[1]) / 2.0
            own[:2] = (slots[:2] - middle) @ turn.T + middle
        shape = own * (1.0 + 0.45 * (1.0 - squeeze[i]), squeeze[i])
        poses[i, :, :2] = c + shape @ rotation(heading).T
    flow = np.gradient(poses[..., :2], axis=0)
    moving = np.hypot(flow[..., 0], flow[..., 1]) > 1e-4
    yaw = np.where(moving, np.arctan2(flow[..., 1], flow[..., 0]), 0.0)
    poses[..., 2] = wrap_angle(yaw)
    return poses, part


def _status(
    part: float,
    poses: NDArray[np.float64],
    later: NDArray[np.float64],
    slots: NDArray[np.float64],
    joints: list[tuple[int, int]],
) -> PlannerStatus:
    robots = len(poses)
    final, arrived = part > 0.8, bool(part > 0.985)
    roles = np.arange(robots)
    swapped = robots == 4 and poses[:, 0].mean() > 6.4
    if swapped:
        roles = np.array([1, 0, 2, 3])
    leader = -1 if final else (1 if swapped else 0)
    goal = np.array([12.4, 5.0, 0.0])
    goals = transform_points(goal, slots)[roles] if final else later[:, :2]
    paths = tuple(
        np.linspace(pose[:2], end, 12) + 0.06 * np.sin(np.linspace(0, np.pi, 12))[:, None]
        for pose, end in zip(poses, goals, strict=True)
    )
    if leader >= 0:
        tail = np.linspace(goals[leader], goal[:2], 30)
        paths = tuple(
            np.vstack([path, tail]) if k == leader else path for k, path in enumerate(paths)
        )
    slot_robot = np.argsort(roles)
    return PlannerStatus(
        state="inactive" if arrived else "final" if final else "partial",
        leader=leader,
        roles=roles,
        slots=slots,
        goals=goals,
        goal=goal,
        paths=paths,
        connections=np.array([(slot_robot[a], slot_robot[b]) for a, b in joints]).reshape(-1, 2),
        eta=np.full(robots, 20.0 * (1.0 - part)),
        arrived=arrived,
        waypoint=0,
        goal_moved=0.0,
        involved=(),
        message="",
    )


def _summary(robots: int, duration: float) -> dict[str, Any]:
    return {
        "name": "made-up-clutter",
        "success": True,
        "reason": "arrived",
        "variant": "cavalcade",
        "seed": 0,
        "robots": robots,
        "makespan_s": duration,
        "min_obstacle_distance_m": 0.34,
        "min_robot_distance_m": 0.71,
        "min_footprint_gap_m": 0.08,
        "collisions": {"robot_robot": 0, "robot_obstacle": 0},
        "formation_error_m": {"mean": 0.11, "p95": 0.32, "max": 0.41},
        "leader_changes": 1,
        "role_changes": 1,
    }


@pytest.fixture(scope="session")
def run() -> Run:
    """Four robots, 240 cycles."""
    return made_up_run()


@pytest.fixture(scope="session")
def make_run() -> Any:
    """The maker itself: `make_run(cycles=..., duration=..., robots=...)`."""
    return made_up_run
