"""Reports of campaigns whose robots have goals of their own."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import pytest

from cavalcade.campaign.report import write_report
from cavalcade.campaign.report.cells import cells_of
from cavalcade.campaign.report.comparisons import PLAN_QUANTITIES, QUANTITIES, compare
from cavalcade.campaign.report.tables import PAPER, PLAN, cell_table, paper_table, refusal_table
from cavalcade.campaign.report.worst import worst_trials


@dataclass(frozen=True)
class Named:
    name: str


@dataclass(frozen=True)
class Plans:
    suite: str = "plans"
    about: str = "Made up."
    variants: tuple[str, ...] = ("auto", "cbs", "cbs-published")
    worlds: tuple[Named, ...] = (Named("random-goals"), Named("crowd"), Named("equal"))


def line_of(scenario, seed, variant, **more):
    length, seconds = 15.0 + seed % 3, 0.01 * (1 + seed)
    success = more.get("success", True)
    line = {
        "trial": f"{scenario}.{seed:04d}.{variant}",
        "suite": "plans",
        "scenario": scenario,
        "variant": variant,
        "disturbance": "none",
        "seed": seed,
        "outcome": "solved",
        "detail": "",
        "success": True,
        "feasible": True,
        "expected": "solved",
        "level": float(2 + seed % 4),
        "level_name": "robots",
        "contacts": 0,
        "avoidable": 0,
        "violations": [],
        "measured": {
            "time_ratio": None,
            "length_ratio": length / 14.5 if success else None,
            "makespan_ratio": 1.1 if success else None,
            "single_time_ratio": 2.5 if success else None,
        },
        "summary": {
            "method": variant.partition("-")[0],
            "reason": "solved",
            "makespan_s": 12.0 + seed,
            "planning_time_s": seconds,
            "path_length_m": [length / 2, length / 2] if success else [None, None],
            "min_footprint_gap_m": 0.06,
        },
    }
    return line | more


def lines():
    found = []
    for seed in range(16):
        for variant in Plans.variants:
            failed = {}
            if variant == "cbs-published" and seed % 4 == 0:
                failed = {"success": False, "outcome": "collision", "contacts": 1, "avoidable": 1}
            found.append(line_of("random-goals", seed, variant, **failed))
            found.append(line_of("crowd", seed, variant))
    for seed in range(5):
        refused = {
            "outcome": "infeasible" if seed else "budget",
            "success": seed > 0,
            "feasible": False,
            "expected": "infeasible",
            "detail": "the goals of robots 0 and 1 overlap",
        }
        found.append(line_of("equal", seed, "auto", **refused))
    return found


@pytest.fixture
def table(open_table):
    return open_table(lines(), Plans())


def test_the_papers_table_stands_first_and_ours_beside_it(table):
    made = paper_table(cells_of(table))
    assert [row[1:5] for row in made.rows[:3]] == [
        ("`sequential`", "18.2", "0.094", "11/16"),
        ("`joint`", "16.85", "1.067", "13/16"),
        ("`cbs`", "15.12", "0.254", "5/5"),
    ]
    assert len(PAPER) == 3
    ours = {row[1]: row for row in made.rows[3:]}
    lengths = [15.0 + seed % 3 for seed in range(16)]
    assert ours["`auto`"][2:5] == (f"{np.mean(lengths):.2f}", "0.085", "16/16")
    done = [15.0 + seed % 3 for seed in range(16) if seed % 4]
    assert ours["`cbs-published`"][2:5] == (f"{np.mean(done):.2f}", "0.085", "12/16")


def test_other_worlds_are_not_set_beside_the_paper(table):
    others = [cell for cell in cells_of(table) if cell.scenario == "crowd"]
    assert paper_table(others) is None


def test_lengths_and_planning_times(table):
    made = cell_table(cells_of(table), table.order, PLAN)
    row = dict(zip(made.head[2:], made.rows[0][2:], strict=True))
    seconds = [0.01 * (1 + seed) for seed in range(16)]
    assert row["average planning time (s)"] == f"{np.mean(seconds):.3f}"
    assert row["p99"] == f"{np.quantile(seconds, 0.99):.3f}"
    assert row["slowest"] == "0.160"
    assert row["over slowest alone p50"] == "1.10"
    assert row["over single plans p50"] == "2.50"


def test_refusals_have_a_table_of_their_own(table):
    made = refusal_table(cells_of(table, "unsolvable"), table.order)
    assert len(made.rows) == 1
    row = dict(zip(made.head, made.rows[0], strict=True))
    assert row["has to be"] == "proven infeasible"
    assert row["as it has to be"] == "80.0 %"
    assert row["slowest"] == "0.0500"
    assert row["ended"] == "1 budget, 4 infeasible"


def test_methods_are_compared_by_length_and_planning_time(table):
    found = compare(table, "variant")
    assert {tuple(comparison.values) for comparison in found} == {PLAN_QUANTITIES}
    paper = next(c for c in found if (c.scenario, c.second) == ("random-goals", "cbs-published"))
    assert (paper.success.first_only, paper.success.second_only) == (4, 0)
    assert paper.values[PLAN_QUANTITIES[1]].pairs == 12
    assert paper.values[PLAN_QUANTITIES[1]].mean.value == 0.0
    assert PLAN_QUANTITIES != QUANTITIES


def test_a_problem_that_was_not_refused_is_a_failure(table):
    worst = [trial for trial, _ in worst_trials(table)]
    assert "equal.0000.auto" in [trial.name for trial in worst]
    assert "equal.0001.auto" not in [trial.name for trial in worst if not trial.success]


def test_a_whole_report(tmp_path):
    made = lines()
    write_report(tmp_path, Plans(), made)
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "## Beside the paper's Table I" in text
    assert "### Problems without a plan" in text
    assert "## Length, time, planning" in text
    assert "### Planning time, where both succeeded" in text
    assert "### `crowd` over robots" in text
    assert "makespan over slowest alone, median" in text
    assert "formation error" not in text.lower()
    assert "cycle" not in text
    head = text.split("## Verdict")[1].split("## Length")[0]
    rows = re.findall(r"^\| `(equal|crowd)` \|", head, re.MULTILINE)
    assert "crowd" in rows
    # Refusals count in no other table.
    assert len(re.findall(r"^\| `equal` \|", text, re.MULTILINE)) == 1
    assert {"curves-crowd.png", "spread.png", "success.png", "variants.png"} <= {
        path.name for path in (tmp_path / "figures").iterdir()
    }


def test_a_campaign_of_refusals_alone(tmp_path):
    made = [line for line in lines() if line["scenario"] == "equal"]
    write_report(tmp_path, Plans(), made)
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "80.0 %" in text
    assert "No trial has finished" not in text
