"""Whole runs of robots that walk."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.checking import check
from cavalcade.errors import InputError, ScenarioError
from cavalcade.fleet import Fall
from cavalcade.jobs.running import run
from cavalcade.metrics.summary import package_versions
from cavalcade.recording.mcap_reader import read_recording
from cavalcade.scenario import Scenario

TIMES = ("wall_time_s", "planning_time_s", "cycle_ms", "real_time_factor", "versions")


@pytest.fixture
def walk(make_scenario: Callable[..., Scenario], straight: Any) -> Callable[..., Any]:
    """Two robots that walk a metre, unless options say otherwise."""
    pytest.importorskip("mujoco")

    def walk(out: Path | None = None, seed: int | None = None, **options: Any) -> Any:
        said: dict[str, Any] = {"robots": 2, "goal": (3.0, 3.0, 0.0), "backend": "mujoco"}
        scenario = make_scenario(**(said | options))
        return run(scenario, out, seed=seed, planner=straight, figures=False, replay=False)

    return walk


def without_times(summary: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in summary.items() if key not in TIMES}


def test_a_team_walks_to_its_slots_and_the_checker_agrees(
    walk: Callable[..., Any], tmp_path: Path
) -> None:
    result = walk(tmp_path / "r")
    assert result.reason == "arrived"
    summary = result.summary
    assert summary["backend"] == "mujoco"
    assert summary["falls"] == 0
    assert summary["collisions"] == {"robot_robot": 0, "robot_obstacle": 0}
    assert summary["physics"]["carried_share"] == pytest.approx([1.0, 1.0], rel=0.02)
    assert 0.0 < summary["physics"]["max_torque_share"] <= 1.0
    assert summary["real_time_factor"] > 0.0
    assert summary["versions"]["mujoco"]
    assert max(summary["goal_error_m"]) < 0.15
    assert json.loads((tmp_path / "r" / "summary.json").read_text("utf-8")) == summary
    assert check(tmp_path / "r").violations == ()


def test_the_recording_holds_the_track_and_the_planner_s_view(
    walk: Callable[..., Any], tmp_path: Path
) -> None:
    made = walk(tmp_path / "r").recording
    back = read_recording(tmp_path / "r")
    assert np.array_equal(back.time, made.time)
    one, other = back.physics, made.physics
    for name in ("time", "base", "joints", "joint_rates", "torques", "foot_forces"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert np.diff(one.time) == pytest.approx(0.02)
    assert one.time[-1] == pytest.approx(made.time[-1], abs=0.02)
    both, *_ = np.nonzero(np.isclose(one.time[:, None], made.time[None]))
    assert len(both) > 10
    planar = {round(float(time), 6): pose for time, pose in zip(made.time, made.poses, strict=True)}
    for k in both:
        pose = planar[round(float(one.time[k]), 6)]
        assert one.base[k, :, :2] == pytest.approx(pose[:, :2], abs=1e-9)


def test_same_seed_same_bytes_other_seeds_other_robots(
    walk: Callable[..., Any], tmp_path: Path
) -> None:
    options = {"physics": {"variation": 0.05}, "noise": {"position": 0.01}}
    runs = [walk(tmp_path / f"{k}", seed=seed, **options) for k, seed in enumerate((1, 1, 2))]
    data = [(tmp_path / f"{k}" / "recording.mcap").read_bytes() for k in range(3)]
    assert data[0] == data[1]
    assert data[0] != data[2]
    assert without_times(runs[0].summary) == without_times(runs[1].summary)
    bodies = [made.recording.physics.base for made in runs]
    assert not np.array_equal(bodies[0][:50], bodies[2][:50])


def test_a_fall_ends_the_run(walk: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    from cavalcade.fleet.mujoco.fleet import MujocoFleet

    plain = MujocoFleet.advance

    def advance(fleet: MujocoFleet, dt: float) -> None:
        if abs(fleet.time - 1.0) < 1e-6:
            fleet.simulator.push(1, (0.0, 1500.0, 0.0), 0.1)
        plain(fleet, dt)

    monkeypatch.setattr(MujocoFleet, "advance", advance)
    result = walk()
    assert result.reason == "fallen"
    assert not result.success
    summary = result.summary
    assert summary["involved"] == [1]
    assert summary["falls"] == 1
    assert summary["detail"].startswith("robot 1 ")
    assert 1.0 < summary["sim_time_s"] < 3.0
    (fall,) = result.recording.physics.falls
    assert fall.robot == 1
    assert summary["detail"].endswith(f"at {fall.time:.2f} s")


@pytest.mark.parametrize(
    ("cause", "words"),
    [("tilt", "rolled or pitched over"), ("height", "sank"), ("trunk", "with its trunk")],
)
def test_any_fleet_that_says_so_has_fallen(go: Callable[..., Any], cause: str, words: str) -> None:
    from cavalcade.fleet import IdealFleet

    class Falling(IdealFleet):
        @property
        def falls(self) -> tuple[Fall, ...]:
            return (Fall(0.52, 2, cause),) if self.time > 0.52 else ()

    result = go(fleet=lambda scenario: Falling(scenario.models, scenario.starts))
    assert result.reason == "fallen"
    assert result.summary["sim_time_s"] == pytest.approx(0.55)
    assert words in result.summary["detail"]
    assert result.summary["involved"] == [2]


def test_bodies_that_touch_are_collisions(walk: Callable[..., Any]) -> None:
    """A box comes along and runs into a robot that stands in its slot."""
    box = {"box": {"center": [7.0, 3.5], "size": [0.4, 0.4]}}
    move = {"at": 0.0, "move": {**box, "to": [2.6, 3.5], "speed": 2.0}}
    result = walk(goal=(2.0, 3.0, 0.0), events=[move, {"at": 6.0, "goals": [[2.0, 3.0, 0.0]]}])
    assert result.reason in ("collision", "fallen")
    assert result.summary["collisions"]["robot_obstacle"] > 0
    assert result.summary["physics"]["contacts"]["robot_obstacle"] > 0


def test_ideal_runs_say_nothing_of_physics(go: Callable[..., Any]) -> None:
    result = go()
    assert result.summary["physics"] is None
    assert result.summary["real_time_factor"] is None
    assert result.recording.physics is None
    assert "mujoco" not in result.summary["versions"]
    assert "mujoco" not in package_versions()


def test_the_backend_may_be_an_argument(
    make_scenario: Callable[..., Scenario], straight: Any
) -> None:
    pytest.importorskip("mujoco")
    result = run(make_scenario(robots=1, timeout=1.0), planner=straight, backend="mujoco")
    assert result.summary["backend"] == "mujoco"
    assert result.recording.physics is not None
    spirit = make_scenario(robots=1)
    robots = (spirit.robots[0].model_copy(update={"model": "spirit"}),)
    with pytest.raises(ScenarioError, match=r"robots\[0\]\.model: .*\(one of: go1, go2\)"):
        run(spirit.model_copy(update={"robots": robots}), planner=straight, backend="mujoco")


def test_without_mujoco_one_line_says_what_to_install(
    make_scenario: Callable[..., Scenario],
    straight: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(InputError, match=r"pip install 'cavalcade\[physics\]'"):
        run(make_scenario(backend="mujoco"), tmp_path / "r", planner=straight)
    assert list(tmp_path.iterdir()) == []


_COMMAND = """
import sys
sys.modules["mujoco"] = None
from cavalcade.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_the_command_line_says_it_too(tmp_path: Path) -> None:
    words = ["run", "cone", "--out", str(tmp_path / "r"), "--backend", "mujoco"]
    done = subprocess.run(
        [sys.executable, "-c", _COMMAND, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "pip install 'cavalcade[physics]'" in done.stderr
    assert list(tmp_path.iterdir()) == []
