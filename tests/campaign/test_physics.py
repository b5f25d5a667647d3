"""Campaigns of robots that walk."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.campaign import judging
from cavalcade.campaign.definition import Definition, define_campaign
from cavalcade.campaign.dispatch import dispatch
from cavalcade.campaign.engines.local import LocalEngine
from cavalcade.campaign.engines.protocol import Engine
from cavalcade.campaign.runner import run_campaign
from cavalcade.campaign.samplers import DataFolder
from cavalcade.campaign.trial import without_times
from cavalcade.campaign.trial_runner import run_trial, run_trial_into
from cavalcade.checking import check
from cavalcade.checking.physics.record import read_records
from cavalcade.jobs import JobResult

SUITE = """\
version: 1
suite: legs
backend: mujoco
worlds:
  - {name: steady, sampler: walk, kind: steady, velocity: [0.4, 0, 0], duration: 5, seeds: 1}
  - {name: push, sampler: walk, kind: push, duration: 4, seeds: 2}
  - {name: pair, sampler: walk, kind: random, robots: 2, duration: 3, seeds: 1}
"""
SHIPPED = ("physics-walk", "physics-formation", "physics-plans", "physics-leaps")


@pytest.fixture
def definition(tmp_path: Path) -> Definition:
    pytest.importorskip("mujoco")
    file = tmp_path / "legs.yaml"
    file.write_text(SUITE, encoding="utf-8")
    return define_campaign(file)


def test_the_same_lines_with_a_worker_and_without(
    definition: Definition,
    tmp_path: Path,
    table: Callable[[Path], list[dict[str, Any]]],
    in_this_process: Engine,
) -> None:
    result = run_campaign(definition, tmp_path / "a", in_this_process)
    with LocalEngine(1) as engine:
        by_worker = [without_times(line) for line in dispatch(engine, definition.trials, 60.0)]
    one = table(tmp_path / "a")
    assert one == sorted(by_worker, key=lambda line: line["trial"])
    assert [(line["trial"], line["outcome"], line["violations"]) for line in one] == [
        (trial.id, "done", []) for trial in sorted(definition.trials, key=lambda trial: trial.id)
    ]
    assert result.summary["success"] == 4
    steady = next(line for line in one if line["scenario"] == "steady")["summary"]
    assert steady["falls"] == 0
    assert steady["commanded"]["speed_error"] < 0.03
    assert 0.005 < steady["commanded"]["rms_m_s"] < 0.04
    assert steady["path_length_m"][0] == pytest.approx(0.4 * 4.5, abs=0.15)
    text = (tmp_path / "a" / "report.md").read_text(encoding="utf-8")
    assert "## Following commands" in text
    assert "## Legs and bodies" in text
    assert "2 of 2 tasks done" in text


def test_the_checker_sees_what_a_recording_would_hold(
    definition: Definition, tmp_path: Path
) -> None:
    line, ran = run_trial_into(definition.trial("push.0001.cavalcade"), tmp_path / "a")
    assert isinstance(ran, JobResult)
    track = ran.recording.physics
    assert track is not None
    written = read_records(tmp_path / "a" / "recording.mcap", 1)
    for here, there in zip(judging.records_of(track), written, strict=True):
        for name in ("time", "base", "joints", "rates", "torques", "forces"):
            assert getattr(here, name).tobytes() == getattr(there, name).tobytes(), name
        assert here.touches == there.touches
    assert check(tmp_path / "a").violations == ()
    assert without_times(run_trial(definition.trial("push.0001.cavalcade"))) == without_times(line)


def test_a_push_that_is_not_said_is_found(definition: Definition) -> None:
    """The audit takes pushes from the scenario alone: without, forces do not explain the motion."""
    _, ran = run_trial_into(definition.trial("push.0001.cavalcade"), None)
    assert isinstance(ran, JobResult)
    done, summary = ran.recording, ran.summary
    assert judging.judged(ran.scenario, ran.world, done, summary).success
    execution = ran.scenario.execution.model_copy(update={"events": ()})
    untold = ran.scenario.model_copy(update={"execution": execution})
    verdict = judging.judged(untold, ran.world, done, summary)
    assert verdict.outcome == "invalid"
    assert any("momentum" in text for text in verdict.violations)


def test_who_falls_has_fallen_whatever_else_there_is(definition: Definition) -> None:
    trial = definition.trial("push.0000.cavalcade")
    hard = replace(trial, sampler=trial.sampler.model_copy(update={"impulse": 90.0}))  # type: ignore[attr-defined]
    line = run_trial(hard)
    assert (line["outcome"], line["success"]) == ("fallen", False)
    assert line["detail"].startswith("robot 0 ")
    assert line["summary"]["falls"] == 1


def test_plans_are_carried_out(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    file = tmp_path / "plans.yaml"
    file.write_text(
        "version: 1\nsuite: plans\nbackend: mujoco\nworlds:\n"
        "  - {name: pair, sampler: pairs, size: [5, 5], models: [go1], seeds: 1}\n",
        encoding="utf-8",
    )
    (trial,) = define_campaign(file).trials
    line = run_trial(trial)
    assert (line["outcome"], line["violations"]) == ("arrived", [])
    assert line["summary"]["method"] == "auto"
    assert np.max(line["summary"]["goal_error_m"]) < 0.15


@pytest.mark.parametrize("name", SHIPPED)
def test_without_mujoco_one_line_says_what_to_install(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    missing = define_campaign(name).suite.missing(DataFolder(None))
    assert missing is not None
    assert "pip install 'cavalcade[physics]'" in missing
    assert "\n" not in missing


def test_the_backend_of_the_command_line_takes_the_place_of_the_suite_s(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    ideal = define_campaign("physics-formation", overrides=["execution.backend=ideal"])
    assert (ideal.suite.backend, ideal.overrides) == ("ideal", ())
    assert ideal.suite.missing(DataFolder(None)) is None
    walking = define_campaign("clutter", overrides=["execution.backend=mujoco"])
    assert walking.suite.missing(DataFolder(None)) is not None
    assert define_campaign("clutter").suite.backend is None


@pytest.mark.parametrize("name", SHIPPED)
def test_every_group_of_the_shipped_suites_draws(name: str) -> None:
    suite = define_campaign(name).suite
    assert suite.backend == "mujoco"
    for group in suite.worlds:
        instance = group.sampler.sample(suite.seed, DataFolder(None))
        assert instance.feasible
