"""`docs/how-to/planning.md` says what the code does."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import cavalcade as cv
from cavalcade.execution import plan_follower as follower
from cavalcade.jobs.reporter import result_rows

NOTE = (Path(__file__).resolve().parents[3] / "docs" / "how-to" / "planning.md").read_text(
    encoding="utf-8"
)


def test_the_example_runs():
    code = re.search(r"```python\n(.*?)```", NOTE, re.S).group(1)
    names: dict = {}
    exec(code, names)
    plan = names["plan"]
    assert (plan.solved, plan.reason) == (True, "solved")
    assert plan.footholds[0].shape[1] == 6


def test_the_gains():
    assert f"position ({follower.POSITION_GAIN:g} /s)" in NOTE
    assert f"heading ({follower.HEADING_GAIN:g} /s)" in NOTE


def test_every_key_of_the_summary_is_explained_somewhere(make_scenario, straight_team):
    summary = cv.plan(make_scenario(), coordinator=straight_team()).summary
    recording = (
        Path(__file__).resolve().parents[3] / "docs" / "reference" / "recording.md"
    ).read_text("utf-8")
    missing = [key for key in summary if key not in NOTE and key not in recording]
    assert missing == []
    assert dict(result_rows(summary))["result"] == "solved"


@pytest.mark.parametrize("name", ["plan.png", "timing.png", "footholds.png", "profile.png"])
def test_every_figure_is_explained(name):
    assert f"- `{name}`" in NOTE
