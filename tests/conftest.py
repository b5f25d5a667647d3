"""What tests of several packages share."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from cavalcade.geometry import Array

Shape = tuple[float, float, bool]

SLOW = (
    "campaign/report/test_report.py",
    "campaign/samplers/test_feasibility.py",
    "campaign/samplers/test_individual_goals.py",
    "campaign/samplers/test_samplers.py",
    "campaign/samplers/test_walk.py",
    "campaign/test_",
    "checking/physics/",
    "cli/test_campaigns.py",
    "cli/test_end_to_end.py",
    "coordination/test_narrow.py",
    "coordination/test_plan_team.py",
    "coordination/test_repeatable.py",
    "coordination/test_terrain.py",
    "drawing/test_figures.py",
    "eikonal/test_real_maps.py",
    "fleet/mujoco/",
    "formation/test_safety_filter.py",
    "jobs/physics/",
    "jobs/plans/",
    "jobs/test_disturbed.py",
    "jobs/test_stuck_",
    "kinodynamic/",
    "lattice/test_space_time_search.py",
    "locomotion/test_control.py",
    "locomotion/test_leap.py",
    "test_examples.py",
)
"""Beginnings of files whose tests take seconds; `make test-fast` leaves them out."""

_SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what is slow, and what needs a browser."""
    here = Path(__file__).resolve().parent
    for item in items:
        if "chromium" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.browser)
        if item.path.relative_to(here).as_posix().startswith(SLOW):
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def shared_data() -> Callable[[str], Path]:
    """Path of a file below `../shared/data`; skips the test where it is not there."""

    def path_of(relative: str) -> Path:
        path = _SHARED_DATA / relative
        if not path.exists():
            pytest.skip(f"shared/data/{relative} is not here")
        return path

    return path_of


@pytest.fixture(scope="session", autouse=True)
def _interruptible() -> Iterator[None]:
    """Let the programs that tests start be interrupted, also where a shell runs us aside.

    Shells start what is put aside with the signal of Ctrl-C ignored, and that is inherited.
    """
    before = signal.getsignal(signal.SIGINT)
    if before is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def _corners(shape: Shape, poses: Array) -> Array:
    """Of boxes at poses `(K, 3)`: `(K, 4, 2)`, in order."""
    around = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * shape[:2]
    c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    x = poses[:, 0, None] + c * around[:, 0] - s * around[:, 1]
    y = poses[:, 1, None] + s * around[:, 0] + c * around[:, 1]
    return np.stack([x, y], axis=2)


def _box_and_points(shape: Shape, poses: Array, points: Array) -> Array:
    """Distances `(K,)` of points `(K, 2)` from boxes, negative inside."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    dx, dy = points[:, 0] - poses[:, 0], points[:, 1] - poses[:, 1]
    u = np.abs(c * dx + s * dy) - shape[0]
    v = np.abs(c * dy - s * dx) - shape[1]
    return np.hypot(np.maximum(u, 0.0), np.maximum(v, 0.0)) + np.minimum(np.maximum(u, v), 0.0)


def _gap(one: Shape, poses: Array, other: Shape, there: Array) -> Array:
    """See `footprint_gap`."""
    if one[2]:
        if other[2]:
            return np.hypot(*(poses - there).T[:2]) - one[0] - other[0]
        return _box_and_points(other, there, poses[:, :2]) - one[0]
    if other[2]:
        return _box_and_points(one, poses, there[:, :2]) - other[0]
    a, b = _corners(one, poses), _corners(other, there)
    separation = np.full(len(poses), -np.inf)
    for yaw in (poses[:, 2], poses[:, 2] + np.pi / 2, there[:, 2], there[:, 2] + np.pi / 2):
        axis = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)[:, None]
        on_a, on_b = (a * axis).sum(axis=2), (b * axis).sum(axis=2)
        separation = np.maximum(separation, on_b.min(axis=1) - on_a.max(axis=1))
        separation = np.maximum(separation, on_a.min(axis=1) - on_b.max(axis=1))
    # Apart, the nearest point of one of the two is a corner.
    nearest = np.full(len(poses), np.inf)
    for k in range(4):
        nearest = np.minimum(nearest, _box_and_points(other, there, a[:, k]))
        nearest = np.minimum(nearest, _box_and_points(one, poses, b[:, k]))
    return np.where(separation < 0.0, separation, nearest)


@pytest.fixture(scope="session")
def footprint_gap() -> Callable[[Shape, Array, Shape, Array], Array]:
    """Exact distances `(K,)` of footprints at poses `(K, 3)`, m; negative where they overlap.

    A shape is half length, half width, and whether it is a disc.
    """
    return _gap
