"""The numbered examples run as they stand and write only where they are told to."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[1] / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))

SAYS = {
    "01_run_a_shipped_scenario": "arrived after",
    "02_step_the_planner_yourself": "arrived after",
    "03_own_map_and_shape": "arrived after",
    "04_change_the_world_on_the_way": "arrived after",
    "05_compare_variants": "published",
    "06_arrival_times": "wrote",
    "07_check_a_recording": "clean",
    "08_run_a_campaign": "feasible worlds solved",
    "09_plan_a_team": "clean",
    "10_plan_on_terrain": "in flight from",
    "11_walk_in_physics": "on its feet",
    "12_plan_team_without_files": "all at their goals after",
    "13_safety_filter_alone": "they stand",
    "14_plan_one_body": "on foot: infeasible",
    "15_leg_control_alone": "swings with",
    "16_predictive_control_alone": "brake with",
    "17_check_arrays": "clean, closest",
    "18_own_loop_at_20_hz": "arrived after",
}

WRITES = {
    "01_run_a_shipped_scenario": ["triangle-lab/replay.html", "triangle-lab/recording.mcap"],
    "03_own_map_and_shape": ["hall.yaml", "arrow.yaml", "arrow/summary.json"],
    "04_change_the_world_on_the_way": ["changes/summary.json"],
    "06_arrival_times": ["arrival_times.png"],
    "07_check_a_recording": ["cone/recording.mcap"],
    "08_run_a_campaign": ["pair/trials.parquet", "pair/report.html"],
    "09_plan_a_team": ["crossing/plan.npz", "crossing/replay.html"],
    "10_plan_on_terrain": ["gap/plan.npz", "gap/figures/profile.png"],
    "11_walk_in_physics": ["cone/replay.html", "cone/figures/gait.png"],
}


def test_all_examples_are_known_and_numbered():
    assert [path.stem for path in EXAMPLES] == list(SAYS)
    assert [path.name[:3] for path in EXAMPLES] == [f"{k:02}_" for k in range(1, len(SAYS) + 1)]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs(path, tmp_path, monkeypatch, capsys):
    if "physics" in path.stem:
        pytest.importorskip("mujoco")
    elsewhere, out = tmp_path / "here", tmp_path / "out"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    monkeypatch.setattr(sys, "argv", [str(path), str(out)])
    runpy.run_path(str(path), run_name="__main__")
    assert SAYS[path.stem] in capsys.readouterr().out
    for name in WRITES.get(path.stem, []):
        assert (out / name).stat().st_size > 0
    assert not list(elsewhere.iterdir()), "an example writes only to the folder it is given"


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 40
