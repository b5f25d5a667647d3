"""The shipped suites `smoke` and `smoke-plans` for real, as `make test` promises."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cavalcade.campaign.definition import check_definition, define_campaign
from cavalcade.campaign.engines.protocol import Engine
from cavalcade.campaign.report import worst
from cavalcade.campaign.runner import run_campaign
from cavalcade.campaign.samplers import DataFolder


@pytest.fixture(autouse=True)
def few_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of the worst trials are repeated for the report: a failure and one that succeeded."""
    monkeypatch.setattr(worst, "MOST", 2)


def test_smoke(
    tmp_path: Path, table: Callable[[Path], list[dict[str, Any]]], in_this_process: Engine
) -> None:
    definition = define_campaign("smoke")
    assert definition.suite.missing(DataFolder(None)) is None
    check_definition(definition)
    assert len(definition.trials) >= 20
    result = run_campaign(
        definition, tmp_path / "a", in_this_process, command="cavalcade campaign smoke"
    )
    lines = table(tmp_path / "a")
    assert [line["trial"] for line in lines] == sorted(trial.id for trial in definition.trials)
    wrong = ("crashed", "refused", "overtime", "invalid")
    assert [line for line in lines if line["outcome"] in wrong] == []
    own = [line for line in lines if line["variant"] == "cavalcade" and line["feasible"]]
    assert [line["trial"] for line in own if line["avoidable"]] == []
    assert sum(line["success"] for line in own) >= 0.9 * len(own)
    assert result.summary["trials"] == len(lines)
    assert {"trials.parquet", "report.md", "report.html"} <= set(os.listdir(tmp_path / "a"))
    assert all(file.is_file() for file in result.files)


def test_smoke_of_plans(
    tmp_path: Path, table: Callable[[Path], list[dict[str, Any]]], in_this_process: Engine
) -> None:
    definition = define_campaign("smoke-plans")
    assert definition.suite.missing(DataFolder(None)) is None
    check_definition(definition)
    assert len(definition.trials) >= 20
    result = run_campaign(definition, tmp_path / "a", in_this_process)
    lines = table(tmp_path / "a")
    assert [line["trial"] for line in lines] == sorted(trial.id for trial in definition.trials)
    # The paper's options may bring robots into contact; everything else has to be right.
    own = [line for line in lines if not line["variant"].endswith("-published")]
    assert [(line["trial"], line["detail"]) for line in own if not line["success"]] == []
    assert {line["outcome"] for line in own} == {"solved", "infeasible", "refused"}
    hopeless = [line for line in own if line["expected"] == "infeasible"]
    assert hopeless
    assert max(line["summary"]["goal_moved_m"] for line in hopeless) == 0.0
    assert {"crashed", "overtime"}.isdisjoint(line["outcome"] for line in lines)
    text = (tmp_path / "a" / "report.md").read_text(encoding="utf-8")
    assert "### Problems without a plan" in text
    assert "## Length, time, planning" in text
    assert result.summary["success_of_feasible"] == sum(
        line["success"] for line in lines if line["feasible"]
    )
