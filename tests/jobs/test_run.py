"""What surrounds a run: folders, refusals, interruptions and what is said."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.errors import InputError, OutputError, ScenarioError
from cavalcade.fleet import IdealFleet
from cavalcade.jobs.running import run
from cavalcade.recording import Frame
from cavalcade.scenario import Scenario, build_world


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_cut_short_nothing_is_left_behind_and_the_team_stops(
    go: Callable[..., Any], tmp_path: Path, error: type[BaseException]
) -> None:
    fleets: list[IdealFleet] = []
    sent: list[Any] = []

    class Watched(IdealFleet):
        def send(self, commands: Any) -> None:
            sent.append(np.array(commands))
            super().send(commands)

    def fleet(scenario: Scenario) -> IdealFleet:
        fleets.append(Watched(scenario.models, scenario.starts))
        return fleets[0]

    def interrupt(frame: Frame) -> None:
        if frame.time >= 1.0:
            raise error

    with pytest.raises(error):
        go(tmp_path / "a" / "r", fleet=fleet, sinks=[interrupt])
    assert list(tmp_path.iterdir()) == []
    assert np.array_equal(sent[-1], np.zeros((4, 3)))
    assert np.any(sent[-2] != 0.0)


def test_a_full_folder_is_refused_before_anything_is_computed(
    go: Callable[..., Any], tmp_path: Path
) -> None:
    (tmp_path / "thesis.tex").write_text("")

    def change(planner: Any) -> None:
        pytest.fail("a planner was made")

    with pytest.raises(OutputError, match="not empty"):
        go(tmp_path, change=change)


def test_bad_input_leaves_no_folder(
    make_scenario: Callable[..., Scenario], straight: Any, tmp_path: Path
) -> None:
    in_the_way = {"circle": {"center": [2.5, 3.5], "radius": 0.2}}
    scenario = make_scenario(world={"obstacles": [in_the_way]})
    with pytest.raises(ScenarioError, match="start"):
        run(scenario, tmp_path / "r", planner=straight)
    assert list(tmp_path.iterdir()) == []


def test_arguments_are_checked(make_scenario: Callable[..., Scenario], straight: Any) -> None:
    with pytest.raises(InputError, match=r"backend: unknown backend 'gazebo' \(one of: ideal, muj"):
        run(make_scenario(), backend="gazebo", planner=straight)
    with pytest.raises(InputError, match="overrides"):
        run(make_scenario(), overrides=["execution.rate=10"], planner=straight)


def test_sinks_get_every_frame(go: Callable[..., Any]) -> None:
    seen: list[Frame] = []
    result = go(sinks=[seen.append], events=[{"at": 1.0, "lose": 0}])
    assert [frame.time for frame in seen] == result.recording.time.tolist()
    assert seen[-1].status.state == "final"
    assert [(frame.time, frame.notes) for frame in seen if frame.notes] == [
        (1.0, ("robot 0 lost",))
    ]
    assert np.array_equal(seen[7].poses, result.recording.poses[7])
    assert np.array_equal(seen[7].commands, result.recording.commands[7])


def test_classes_may_make_fleet_and_planner(
    make_scenario: Callable[..., Scenario], straight: Any
) -> None:
    class Robots(IdealFleet):
        def __init__(self, scenario: Scenario) -> None:
            super().__init__(scenario.models, scenario.starts)

    class Straight(type(straight(make_scenario(), None))):  # type: ignore[misc]
        def __init__(self, scenario: Scenario, world: Any) -> None:
            made = straight(scenario, world)
            super().__init__(made.slots, scenario.task.goals)

    result = run(make_scenario(), planner=Straight, fleet=Robots, figures=False, replay=False)
    assert result.reason == "arrived"


def test_fleet_and_planner_may_be_made_or_given(
    make_scenario: Callable[..., Scenario], straight: Any
) -> None:
    scenario = make_scenario()
    options: dict[str, Any] = {"figures": False, "replay": False}
    world = build_world(scenario)
    made = run(
        scenario,
        planner=straight,
        fleet=lambda scenario: IdealFleet(scenario.models, scenario.starts),
        **options,
    )
    fleet = IdealFleet(scenario.models, scenario.starts)
    given = run(scenario, planner=straight(scenario, world), fleet=fleet, **options)
    assert np.array_equal(made.recording.poses, given.recording.poses)
    assert np.array_equal(fleet.true_poses(), given.recording.poses[-1])
    assert given.world.map == world.map


def test_it_says_what_it_does_or_nothing(
    make_scenario: Callable[..., Scenario],
    straight: Any,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def options(name: str) -> dict[str, Any]:
        return {"out": tmp_path / name, "planner": straight, "figures": False, "replay": False}

    run(make_scenario(), **options("a"))
    assert capsys.readouterr() == ("", "")
    run(make_scenario(goal=(5.0, 3.0, 0.0), rate=10), quiet=False, **options("b"))
    said = capsys.readouterr().out
    assert "straight: 4 robots" in said
    assert "arrived" in said
    assert f"{tmp_path / 'b' / 'summary.json'}\n" in said
    assert "\x1b" not in said
