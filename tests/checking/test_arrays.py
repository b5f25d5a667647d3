"""Motion at hand as arrays is judged as recorded motion is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from cavalcade.checking import check_motion
from cavalcade.errors import InputError
from cavalcade.robots import robot_model

GO1 = robot_model("go1")


def passing(gap: float, duration: float = 20.0) -> tuple[np.ndarray, np.ndarray]:
    """Two Go1s pass each other at 0.3 m/s, `gap` m between their centre lines."""
    time = np.linspace(0.0, duration, 21)
    along = 0.3 * (time - 0.5 * duration)
    first = np.column_stack([5.0 + along, np.full(21, 2.0), np.zeros(21)])
    second = np.column_stack([5.0 - along, np.full(21, 2.0 + gap), np.full(21, np.pi)])
    return time, np.stack([first, second], axis=1)


def without_start_and_stop(report: Any) -> list[Any]:
    """They set out and stop at once, which no robot can; that is another matter."""
    return [one for one in report.violations if "acceleration" not in one.kind]


@pytest.mark.parametrize(("gap", "touches"), [(0.30, False), (0.26, True)])
def test_contact_between_robots_depends_on_their_width(gap: float, touches: bool) -> None:
    time, poses = passing(gap)
    report = check_motion(time, poses, [GO1, GO1], size=(10.0, 4.0))
    assert bool(without_start_and_stop(report)) == touches
    assert report.figures is not None
    if not touches:
        assert report.figures.min_footprint_gap_m == pytest.approx(gap - GO1.width, abs=1e-6)


def test_an_obstacle_between_two_samples_is_hit() -> None:
    time, poses = passing(0.5)
    post = {"circle": {"center": [5.15, 2.0], "radius": 0.01}}
    report = check_motion(time, poses, [GO1, GO1], size=(10.0, 4.0), obstacles=[post])
    assert [one.kind for one in without_start_and_stop(report)]
    assert "obstacles[0]" in without_start_and_stop(report)[0].message


def test_ground_ends_at_the_border() -> None:
    time, poses = passing(0.5)
    assert without_start_and_stop(check_motion(time, poses, [GO1, GO1], size=(7.9, 4.0)))


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"time": [0.0, np.nan]}, "time"),
        ({"poses": np.zeros((2, 3, 3))}, "poses"),
        ({"poses": np.full((2, 1, 3), np.inf)}, "poses"),
        ({"size": None}, "size"),
        ({"size": (0.0, 3.0)}, "size"),
        ({"obstacles": [{"cone": {}}]}, r"obstacles\[0\]"),
    ],
)
def test_what_does_not_fit_names_its_key(changes: dict[str, Any], key: str) -> None:
    said: dict[str, Any] = {"time": [0.0, 1.0], "poses": np.ones((2, 1, 3)), "size": (4.0, 3.0)}
    said |= changes
    with pytest.raises(InputError, match=f"^{key}: "):
        check_motion(said.pop("time"), said.pop("poses"), [GO1], **said)
