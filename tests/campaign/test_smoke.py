"""The shipped suite `smoke` for real, as `make test` promises."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cavalcade.campaign.draws import DataFolder
from cavalcade.campaign.engines.local import LocalEngine
from cavalcade.campaign.plan import check_plan, make_plan
from cavalcade.campaign.runner import run_campaign


def test_smoke(tmp_path: Path, table: Callable[[Path], list[dict[str, Any]]]) -> None:
    plan = make_plan("smoke")
    assert plan.suite.missing(DataFolder(None)) is None
    check_plan(plan)
    assert len(plan.trials) >= 20
    result = run_campaign(plan, tmp_path / "a", LocalEngine(2), command="cavalcade campaign smoke")
    lines = table(tmp_path / "a")
    assert [line["trial"] for line in lines] == sorted(trial.id for trial in plan.trials)
    wrong = ("crashed", "refused", "overtime", "invalid")
    assert [line for line in lines if line["outcome"] in wrong] == []
    own = [line for line in lines if line["variant"] == "cavalcade" and line["feasible"]]
    assert [line["trial"] for line in own if line["avoidable"]] == []
    assert sum(line["success"] for line in own) >= 0.9 * len(own)
    assert result.summary["trials"] == len(lines)
    assert {"trials.parquet", "report.md", "report.html"} <= set(os.listdir(tmp_path / "a"))
    assert all(file.is_file() for file in result.files)
