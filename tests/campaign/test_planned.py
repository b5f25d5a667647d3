"""Trials of robots with goals of their own: made, judged, measured, and the same again."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.campaign.definition import define_campaign
from cavalcade.campaign.engines.local import LocalEngine
from cavalcade.campaign.engines.protocol import Engine
from cavalcade.campaign.judging import judged_plan, measured_plan
from cavalcade.campaign.repeat import repeat_trial
from cavalcade.campaign.runner import run_campaign
from cavalcade.campaign.suite import parse_suite
from cavalcade.campaign.trial import TIMES, Trial, trials_of, without_times
from cavalcade.campaign.trial_runner import lost_line, replay, run_trial, run_trial_into
from cavalcade.campaign.warming import needs_of_all
from cavalcade.checking import check
from cavalcade.checking.plans import read_plan
from cavalcade.coordination.result import TeamPlan
from cavalcade.jobs import JobResult, plan
from cavalcade.recording.plan_file import plan_arrays
from cavalcade.scenario import Scenario, build_world, parse_scenario, resolve_scenario

SUITE = """\
version: 1
suite: tiny-plans
worlds:
  - {name: pair, sampler: pairs, keep: colliding, variants: [cbs, sequential], seeds: 2}
  - {name: equal, sampler: infeasible, kind: goals-equal, seeds: 1}
  - {name: bad, sampler: infeasible, kind: starts-overlap, seeds: 1}
"""


def trial_of(group: dict[str, Any], **head: Any) -> Trial:
    said = {"version": 1, "suite": "one", "worlds": [{"name": "it", "seeds": 1, **group}], **head}
    return next(iter(trials_of(parse_suite(said), (), None)))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def head_on() -> JobResult:
    _, ran = run_trial_into(trial_of({"sampler": "shipped", "scenario": "head-on"}), None)
    assert isinstance(ran, JobResult)
    return ran


def test_a_line_holds_the_verdict_and_the_summary() -> None:
    trial = trial_of({"sampler": "pairs"}, variants=["cbs"])
    line = run_trial(trial)
    assert (line["outcome"], line["success"], line["violations"]) == ("solved", True, [])
    assert (line["trial"], line["expected"], line["feasible"]) == ("it.0000.cbs", "solved", True)
    assert line["summary"]["method"] == "cbs"
    assert line["measured"]["length_ratio"] >= 1.0 - 1e-6
    assert json.loads(json.dumps(line, allow_nan=False)) == line
    assert without_times(run_trial(trial)) == without_times(line)
    assert "single_time_ratio" in TIMES


def test_the_checker_sees_what_a_plan_file_would_hold(tmp_path: Path) -> None:
    trial = trial_of({"sampler": "shipped", "scenario": "corner-swap"})
    line, ran = run_trial_into(trial, tmp_path / "a")
    assert isinstance(ran, JobResult)
    written = read_plan(tmp_path / "a" / "plan.npz")
    in_memory = plan_arrays(ran.trajectories, ran.footholds)
    assert sorted(written) == sorted(in_memory)
    for name, array in in_memory.items():
        assert array.tobytes() == written[name].tobytes()
        assert array.dtype == written[name].dtype
    assert check(tmp_path / "a").ok == line["success"] is True
    assert (tmp_path / "a" / "replay.html").is_file()


def changed(result: JobResult, **changes: Any) -> JobResult:
    assert result.planned is not None
    team: TeamPlan = replace(result.planned.plan, **changes)
    return replace(result, planned=replace(result.planned, plan=team))


def test_a_fault_in_the_motion_is_invalid(head_on: JobResult) -> None:
    paths = head_on.trajectories
    assert paths[0] is not None
    velocity = paths[0].velocity.copy()
    velocity[len(velocity) // 2] = (30.0, 0.0, 0.0)
    broken = changed(head_on, trajectories=(replace(paths[0], velocity=velocity), paths[1]))
    assert judged_plan(head_on).success
    verdict = judged_plan(broken)
    assert (verdict.outcome, verdict.success, verdict.contacts) == ("invalid", False, 0)
    assert verdict.violations


def test_contact_is_a_collision_even_where_the_summary_says_so_itself(head_on: JobResult) -> None:
    scenario = head_on.scenario
    lone = []
    for k in range(2):
        one = scenario.model_copy(update={"robots": (scenario.robots[k],)})
        lone.append(plan(one).trajectories[0])

    def through_each_other(scenario: Scenario, world: Any) -> TeamPlan:
        return replace(head_on.plan, trajectories=tuple(lone))

    made = plan(scenario, coordinator=through_each_other)
    assert made.reason == "collision"
    verdict = judged_plan(made)
    assert (verdict.outcome, verdict.success) == ("collision", False)
    assert verdict.contacts == verdict.avoidable >= 1


@pytest.mark.parametrize(
    ("expected", "reason", "success"),
    [
        ("solved", "infeasible", False),
        ("solved", "budget", False),
        ("infeasible", "infeasible", True),
        ("infeasible", "budget", False),
        ("unsolved", "infeasible", True),
        ("unsolved", "budget", True),
        ("refused", "infeasible", False),
    ],
)
def test_where_there_is_no_plan_refusing_is_the_success(
    head_on: JobResult, expected: str, reason: str, success: bool
) -> None:
    def refuse(scenario: Scenario, world: Any) -> TeamPlan:
        plan = replace(head_on.plan, reason=reason, trajectories=(None, None))
        return replace(plan, detail="so it is")

    made = plan(head_on.scenario, coordinator=refuse)
    verdict = judged_plan(made, expected)
    assert (verdict.outcome, verdict.success, verdict.detail) == (reason, success, "so it is")


def test_a_plan_for_what_has_none_is_no_success(head_on: JobResult) -> None:
    assert not judged_plan(head_on, "infeasible").success


def test_measures_are_what_they_say(head_on: JobResult) -> None:
    measured = measured_plan(head_on)
    summary = head_on.summary
    assert measured["length_ratio"] == pytest.approx(sum(summary["path_length_m"]) / 10.0, abs=1e-5)
    durations = []
    for robot in head_on.scenario.robots:
        single = plan(head_on.scenario.model_copy(update={"robots": (robot,)}), method="cbs")
        durations.append(single.summary["makespan_s"])
    expected = summary["makespan_s"] / max(durations)
    assert measured["makespan_ratio"] == pytest.approx(expected, abs=1e-5)
    assert measured["single_time_ratio"] is not None
    assert measured["single_time_ratio"] > 0.0


def test_one_robot_has_nobody_to_be_compared_with() -> None:
    line = run_trial(trial_of({"sampler": "terrain", "kind": "flat"}))
    assert line["success"]
    assert line["measured"]["makespan_ratio"] is line["measured"]["single_time_ratio"] is None
    assert 1.0 - 1e-6 <= line["measured"]["length_ratio"] < 1.2


def test_bad_input_is_a_success_only_where_it_has_to_be_refused() -> None:
    bad = trial_of({"sampler": "infeasible", "kind": "starts-overlap"})
    line = run_trial(bad)
    assert (line["outcome"], line["success"], line["expected"]) == ("refused", True, "refused")
    assert line["summary"] == {}
    swap = trial_of({"sampler": "shipped", "scenario": "head-on"})
    outside = ("robots.0.start=[50, 50, 0]",)
    line = run_trial(replace(swap, overrides=outside))
    assert (line["outcome"], line["success"]) == ("refused", False)


def test_a_lost_trial_is_no_refusal() -> None:
    trial = trial_of({"sampler": "infeasible", "kind": "goals-equal"})
    line = lost_line(trial, "overtime", "not done within 60 s")
    assert (line["success"], line["feasible"], line["expected"]) == (False, False, "infeasible")


def test_a_replay_gives_the_plan() -> None:
    found = replay(trial_of({"sampler": "shipped", "scenario": "head-on"}))
    assert found is not None
    assert found.planned is not None
    assert found.planned.summary == found.summary
    assert found.scenario.name == "head-on"
    assert found.world.map.size == (9.0, 4.0)


def test_what_has_to_be_warm() -> None:
    found = needs_of_all(define_campaign("smoke-plans").trials)
    assert {(needs.kind, needs.backend) for needs in found} == {("individual", None)}
    assert {needs.method for needs in found} == {"auto", "cbs", "joint", "sequential"}
    assert {needs.variant for needs in found} == {"cavalcade", "published"}
    assert {needs.uneven for needs in found} == {False, True}
    driven = needs_of_all(define_campaign("smoke").trials)
    assert {(needs.kind, needs.backend) for needs in driven} == {("formation", "ideal")}


@pytest.mark.usefixtures("no_report")
def test_a_campaign_and_one_of_its_trials_again(
    tmp_path: Path, table: Callable[[Path], list[dict[str, Any]]], in_this_process: Engine
) -> None:
    file = tmp_path / "tiny-plans.yaml"
    file.write_text(SUITE, encoding="utf-8")
    plans = define_campaign(file)
    run_campaign(plans, tmp_path / "a", LocalEngine(1))
    run_campaign(plans, tmp_path / "b", in_this_process)
    lines = table(tmp_path / "a")
    assert lines == table(tmp_path / "b")
    assert [line["outcome"] for line in lines] == [
        "refused", "infeasible", "solved", "solved", "solved", "solved"
    ]  # fmt: skip
    again = repeat_trial(tmp_path / "a", "pair.0001.cbs", tmp_path / "again")
    assert again.same
    names = {path.name for path in (tmp_path / "again").iterdir()}
    assert {"scenario.yaml", "summary.json", "plan.npz", "replay.html", "figures"} <= names
    assert check(tmp_path / "again").ok
    refused = repeat_trial(tmp_path / "a", "equal.0000.auto", tmp_path / "equal")
    assert refused.same
    assert refused.line["success"]


def test_the_worlds_are_as_they_were_resolved(head_on: JobResult) -> None:
    assert head_on.scenario == resolve_scenario(head_on.scenario)
    said = trial_of({"sampler": "shipped", "scenario": "head-on"}).instance().scenario
    world = build_world(parse_scenario(said))
    assert np.array_equal(world.map.occupied, head_on.world.map.occupied)
