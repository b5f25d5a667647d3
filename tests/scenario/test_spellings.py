"""Keys and values in their old spelling: taken, and warned about once and in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from cavalcade.campaign.suite import parse_suite
from cavalcade.cli import main
from cavalcade.errors import ScenarioError
from cavalcade.scenario import load_scenario, parse_scenario
from cavalcade.scenario.settings import PlannerSection
from cavalcade.scenario.spellings import KEYS, VALUES, RenamedWarning

Data = dict[str, Any]
OLD = {"variant": "cavalcade-no-standoffs", "expect": {"stray": 0.05}}
NEW = {"variant": "cavalcade-no-recovery", "expect": {"tracking_error": 0.05}}


def test_the_old_spelling_means_the_new_one(data: Data) -> None:
    with pytest.warns(RenamedWarning) as warned:
        old = parse_scenario({**data, "planner": OLD})
    new = parse_scenario({**data, "planner": NEW})
    assert old == new
    assert [str(warning.message) for warning in warned] == [
        "planner.variant: cavalcade-no-standoffs is called cavalcade-no-recovery now",
        "planner.expect.stray is called planner.expect.tracking_error now",
    ]


def test_what_was_given_stays_as_it_is(data: Data) -> None:
    planner = {"expect": {"stray": 0.05}}
    with pytest.warns(RenamedWarning):
        parse_scenario({**data, "planner": planner})
    assert planner == {"expect": {"stray": 0.05}}


def test_over_the_file_it_is_taken_too(tmp_path: Path, data: Data) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    with pytest.warns(RenamedWarning, match=r"s\.yaml: planner\.expect\.stray is called"):
        scenario = load_scenario(file, ["planner.expect.stray=0.05"])
    assert scenario.planner.expect.tracking_error == 0.05


def test_both_spellings_at_once_are_refused(data: Data) -> None:
    both = {"expect": {"stray": 0.05, "tracking_error": 0.05}}
    with pytest.warns(RenamedWarning), pytest.raises(ScenarioError, match=r"expect\.stray: stands"):
        parse_scenario({**data, "planner": both})


@pytest.mark.filterwarnings("default")
def test_the_command_line_says_it_in_one_line(
    tmp_path: Path, data: Data, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(yaml.safe_dump({**data, "planner": OLD}), encoding="utf-8")
    main(["show", str(file), "--out", str(tmp_path / "s.png")])
    lines = [line for line in capsys.readouterr().err.splitlines() if "warning" in line]
    assert len(lines) == 2
    assert all("is called" in line for line in lines)


def test_suites_may_name_old_variants() -> None:
    suite = {
        "version": 1,
        "suite": "old",
        "variants": ["cavalcade", "cavalcade-no-standoffs"],
        "references": {"cavalcade-no-standoffs": "cavalcade"},
        "worlds": [{"name": "a", "seeds": 1, "draw": "crowd"}],
    }
    with pytest.warns(RenamedWarning):
        found = parse_suite(suite)
    assert found.variants == ("cavalcade", "cavalcade-no-recovery")
    assert found.references == {"cavalcade-no-recovery": "cavalcade"}


def test_the_tables_lead_from_what_is_gone_to_what_there_is() -> None:
    variants = PlannerSection.model_json_schema()["properties"]["variant"]["enum"]
    for old, new in VALUES["planner.variant"].items():
        assert old not in variants
        assert new in variants
    for old, new in KEYS.items():
        assert old.rpartition(".")[0] == new.rpartition(".")[0]
