"""Goals that are moved or cannot be reached: what users are told of them."""

from __future__ import annotations

import pytest

from cavalcade.cli import main
from cavalcade.jobs import run
from cavalcade.jobs.reporter import result_rows
from cavalcade.scenario import parse_scenario

ALONE = {"shape": "custom", "slots": [[0.0, 0.0]]}


def scenario(goal, obstacles=()):
    return parse_scenario(
        {
            "version": 1,
            "name": "alone",
            "world": {"empty": {"size": [4.0, 3.0]}, "obstacles": list(obstacles)},
            "robots": [{"model": "go1", "start": [1.0, 1.5, 0.0]}],
            "task": {"formation": ALONE, "goals": [goal]},
        },
        "a.yaml",
    )


@pytest.mark.parametrize(
    ("goal", "moved", "on_map"),
    [
        ([2.0, 1.5, 0.0], 0.0, True),
        ([3.8, 1.5, 0.0], 0.3, True),
        ([4.0, 1.5, 0.0], 0.5, True),
        ([4.1, 1.5, 0.0], 0.6, False),
        ([5.0, 1.5, 0.0], 1.5, False),
    ],
)
def test_a_moved_goal_was_told_in_the_summary_alone(goal, moved, on_map):
    result = run(scenario(goal))
    assert result.success
    assert result.goals_on_map == on_map
    assert result.summary.goal_moved_m == pytest.approx(moved, abs=0.06)
    row = dict(result_rows(result.summary)).get("goal moved by")
    shown = f"{result.summary.goal_moved_m:.2f} m, to where the shape fits"
    assert row == (shown if moved else None)


@pytest.mark.parametrize(
    ("goal", "said"),
    [([8.0, 1.5, 0.0], "it is off the map"), ([1.0, -4.0, 0.0], "it is off the map")],
)
def test_a_goal_off_the_map_was_called_one_without_a_path(goal, said):
    result = run(scenario(goal))
    assert result.reason == "infeasible"
    assert result.summary.detail == f"no path to the goal for robot 0: {said}"


@pytest.mark.parametrize(
    ("x", "moved", "off"), [(2.0, None, False), (3.8, 0.3, False), (4.4, 0.9, True)]
)
def test_the_command_line_says_it_on_stderr(tmp_path, capsys, x, moved, off):
    file = tmp_path / "a.yaml"
    file.write_text(scenario([x, 1.5, 0.0]).model_dump_json(exclude_none=True))
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 0
    out, err = capsys.readouterr()
    assert ("goal moved by" in out) == (moved is not None)
    assert err.count("\n") == (moved is not None)
    assert ("it is off the map" in err) == off
