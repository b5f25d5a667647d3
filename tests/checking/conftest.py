"""Result folders made by hand: a scenario, straight-line motion and a summary."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from cavalcade.checking import Report
from cavalcade.checking.check import judge
from cavalcade.checking.tracks import Track
from cavalcade.scenario import Scenario, load_scenario

Knots = Sequence[tuple[float, float, float, float]]
"""A robot's motion: (time, x, y, yaw) between which it moves evenly."""


def path(knots: Knots, dt: float = 0.05) -> Track:
    """A track through the knots, sampled every `dt` s."""
    table = np.array(knots, dtype=float)
    count = round((table[-1, 0] - table[0, 0]) / dt)
    time = table[0, 0] + dt * np.arange(count + 1)
    pose = np.stack([np.interp(time, table[:, 0], table[:, k]) for k in (1, 2, 3)], axis=1)
    return Track(time, pose)


def words(
    starts: Sequence[Sequence[float]],
    obstacles: Sequence[dict[str, Any]] = (),
    events: Sequence[dict[str, Any]] = (),
    **changes: Any,
) -> dict[str, Any]:
    """A scenario file's content: a column in an empty 10 x 10 m world unless changed."""
    return {
        "version": 1,
        "name": "by-hand",
        "world": {"empty": {"size": [10, 10]}, "obstacles": list(obstacles)},
        "robots": [{"model": "go1", "start": list(start)} for start in starts],
        "task": {
            "formation": {"shape": "column", "spacing": 1.0},
            "goals": [[8.0, 5.0, 0.0]],
        },
        "execution": {"events": list(events)},
        **changes,
    }


@pytest.fixture
def make_scenario(tmp_path: Path) -> Callable[..., Scenario]:
    """From `words`' arguments to a scenario."""

    def make(*args: Any, **changes: Any) -> Scenario:
        file = tmp_path / "scenario.yaml"
        file.write_text(yaml.safe_dump(words(*args, **changes)))
        return load_scenario(file)

    return make


@pytest.fixture
def verdict(make_scenario: Callable[..., Scenario]) -> Callable[..., Report]:
    """Judge motion given by knots; starts are taken from it."""

    def give(
        motion: Sequence[Knots],
        obstacles: Sequence[dict[str, Any]] = (),
        events: Sequence[dict[str, Any]] = (),
        *,
        dt: float = 0.05,
        summary: dict[str, Any] | None = None,
        **changes: Any,
    ) -> Report:
        tracks = tuple(path(knots, dt) for knots in motion)
        starts = [list(knots[0][1:]) for knots in motion]
        scenario = make_scenario(starts, obstacles, events, **changes)
        return judge(scenario, tracks, summary or {})

    return give


def write_recording(file: Path, tracks: Sequence[Track], *, pose_type: bool = True) -> None:
    """The tracks as an MCAP file with `/robot_k/pose`."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    kind = "geometry_msgs/msg/PoseStamped" if pose_type else "geometry_msgs/msg/Pose"
    bag = file.parent / "bag"
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        links = [
            writer.add_connection(f"/robot_{k}/pose", kind, typestore=store)
            for k in range(len(tracks))
        ]
        for link, track in zip(links, tracks, strict=True):
            for time, (x, y, yaw) in zip(track.time, track.pose, strict=True):
                stamp = round(time * 1e9)
                message = _pose(types, x, y, yaw)
                if pose_type:
                    moment = types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
                    header = types["std_msgs/msg/Header"](moment, "map")
                    message = types[kind](header, message)
                writer.write(link, stamp, store.serialize_cdr(message, kind))
    shutil.move(next(bag.glob("*.mcap")), file)
    shutil.rmtree(bag)


def _pose(types: Any, x: float, y: float, yaw: float) -> Any:
    point = types["geometry_msgs/msg/Point"](x, y, 0.0)
    turn = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return types["geometry_msgs/msg/Pose"](point, turn)


@pytest.fixture
def make_folder(tmp_path: Path) -> Callable[..., Path]:
    """A result folder on disk with the given tracks and summary."""

    def make(
        tracks: Sequence[Track], content: dict[str, Any], summary: dict[str, Any] | None = None
    ) -> Path:
        folder = tmp_path / "run"
        folder.mkdir()
        (folder / "scenario.yaml").write_text(yaml.safe_dump(content))
        (folder / "summary.json").write_text(json.dumps(summary or {"success": False}))
        write_recording(folder / "recording.mcap", tracks)
        return folder

    return make


@pytest.fixture
def knot_path() -> Callable[..., Track]:
    """`path`, for tests that make their own tracks."""
    return path


@pytest.fixture
def scenario_words() -> Callable[..., dict[str, Any]]:
    """`words`, for tests that write their own files."""
    return words


@pytest.fixture
def recorder() -> Callable[..., None]:
    """`write_recording`."""
    return write_recording
