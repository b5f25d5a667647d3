"""Robots whose masses, joints and shapes are those of a MuJoCo model of one's own."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cavalcade.errors import ScenarioError
from cavalcade.jobs.running import run
from cavalcade.robots import robot_model
from cavalcade.scenario import Scenario, dump_scenario, load_scenario

pytest.importorskip("mujoco")


@pytest.fixture
def heavy(tmp_path: Path) -> Path:
    """A file with Go1's figures, but for a trunk that is 2 kg heavier."""
    from cavalcade.fleet.mujoco.robot_spec import robot_spec

    description = robot_model("go1").description
    assert description is not None
    spec = robot_spec(description, (2, 1), 0.8).spec
    spec.body("trunk").mass += 2.0
    spec.compile()
    file = tmp_path / "robots" / "heavy.xml"
    file.parent.mkdir()
    # Without what only our own models have.
    bare = re.sub(r"<site [^>]*/>|<sensor>.*</sensor>", "", spec.to_xml(), flags=re.DOTALL)
    file.write_text(bare, encoding="utf-8")
    return file


@pytest.fixture
def scenario(make_scenario: Callable[..., Scenario], heavy: Path) -> Scenario:
    made = make_scenario(robots=2, goal=(3.0, 3.0, 0.0), backend="mujoco")
    first, second = made.robots
    return made.model_copy(update={"robots": (first.model_copy(update={"mjcf": heavy}), second)})


def test_they_walk_beside_the_others(
    scenario: Scenario, straight: Any, heavy: Path, tmp_path: Path
) -> None:
    result = run(scenario, tmp_path / "r", planner=straight, figures=False)
    assert result.reason == "arrived"
    forces = result.recording.physics.foot_forces[1:, ..., 2].sum(axis=2).mean(axis=0)
    assert forces[0] - forces[1] == pytest.approx(2.0 * 9.81, rel=0.1)
    assert result.summary["physics"]["carried_share"] == pytest.approx([1.0, 1.0], rel=0.02)
    assert "mjcf: ../robots/heavy.xml" in (tmp_path / "r" / "scenario.yaml").read_text("utf-8")
    again = load_scenario(tmp_path / "r" / "scenario.yaml").robots[0].mjcf
    assert again is not None
    assert again.resolve() == heavy.resolve()


def test_ideal_robots_do_not_ask_for_it(scenario: Scenario, straight: Any, heavy: Path) -> None:
    heavy.unlink()
    ideal = run(scenario, planner=straight, backend="ideal")
    assert ideal.success


@pytest.mark.parametrize("content", [None, "<mujoco", "<mujoco/>"])
def test_a_file_that_cannot_be_used_is_named_with_its_key(
    scenario: Scenario, straight: Any, heavy: Path, content: str | None
) -> None:
    heavy.unlink() if content is None else heavy.write_text(content, encoding="utf-8")
    with pytest.raises(ScenarioError) as caught:
        run(scenario, planner=straight)
    assert str(caught.value).startswith(f"robots[0].mjcf: {heavy}: ")
    assert "\n" not in str(caught.value)


def test_any_robot_with_legs_may_lend_its_footprint(scenario: Scenario, tmp_path: Path) -> None:
    def like(name: str) -> Scenario:
        robots = tuple(
            robot.model_copy(update={"model": name if robot.mjcf is not None else "go1"})
            for robot in scenario.robots
        )
        dump_scenario(scenario.model_copy(update={"robots": robots}), tmp_path / "s.yaml")
        return load_scenario(tmp_path / "s.yaml")

    assert like("spirit").models[0].name == "spirit"
    with pytest.raises(ScenarioError, match=r"robots\[0\]\.model"):
        like("unicycle")
