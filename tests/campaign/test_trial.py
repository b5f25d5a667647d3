"""One trial: what the checker is given, what becomes of failures, and the same again."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from cavalcade.campaign import judging
from cavalcade.campaign.avoidable import CONTACT, lost_since
from cavalcade.campaign.definition import Definition, define_campaign
from cavalcade.campaign.engines.protocol import Engine
from cavalcade.campaign.runner import run_campaign
from cavalcade.campaign.trial import TIMES, Trial, without_times
from cavalcade.campaign.trial_runner import lost_line, replay, run_trial, run_trial_into
from cavalcade.checking import check
from cavalcade.checking.report import Report, Violation
from cavalcade.checking.tracks import read_tracks
from cavalcade.errors import InputError, OutputError
from cavalcade.scenario import Scenario

KEYS = [
    *("trial", "suite", "scenario", "variant", "disturbance", "seed", "outcome", "detail"),
    *(
        "success",
        "feasible",
        "expected",
        "level",
        "level_name",
        "contacts",
        "avoidable",
        "violations",
    ),
    *("measured", "summary"),
]


@pytest.fixture
def noisy(tiny_plan: Definition) -> Trial:
    return tiny_plan.trial("short.0002.cavalcade.noise")


def test_a_line_holds_the_verdict_and_the_summary(noisy: Trial) -> None:
    line = run_trial(noisy)
    assert list(line) == KEYS
    assert (line["outcome"], line["success"], line["violations"]) == ("arrived", True, [])
    assert (line["trial"], line["scenario"], line["seed"]) == (noisy.id, "short", 2)
    assert 1.0 < line["measured"]["time_ratio"] < 4.0
    assert line["summary"]["seed"] == 2
    assert json.loads(json.dumps(line, allow_nan=False)) == line
    assert without_times(run_trial(noisy)) == without_times(line)


def test_the_checker_sees_what_a_recording_would_hold(noisy: Trial, tmp_path: Path) -> None:
    _, ran = run_trial_into(noisy, tmp_path / "a")
    assert ran is not None
    written = read_tracks(tmp_path / "a" / "recording.mcap", 2)
    for in_memory, from_file in zip(judging.tracks_of(ran.recording), written, strict=True):
        assert in_memory.time.tobytes() == from_file.time.tobytes()
        assert in_memory.pose.tobytes() == from_file.pose.tobytes()
    assert check(tmp_path / "a") == judging.judge(ran.scenario, written, ran.summary)
    assert (tmp_path / "a" / "replay.html").is_file()
    assert any((tmp_path / "a" / "figures").iterdir())


def test_turning_more_than_once_is_the_same_in_memory_and_file(tmp_path: Path) -> None:
    from cavalcade.recording.frames import Recording
    from cavalcade.recording.mcap_writer import write_recording

    count = 400
    time = np.round(np.arange(count) * 0.05, 9)
    poses = np.zeros((count, 1, 3))
    poses[:, 0, 0], poses[:, 0, 2] = np.sin(time), 3.0 * time - 2.0
    status = carry_out_status(count)
    recording = Recording(time, poses, poses, poses, status, (), ())
    from cavalcade.robots import MODELS

    write_recording(tmp_path / "r.mcap", recording, (MODELS["go1"],))
    (written,) = read_tracks(tmp_path / "r.mcap", 1)
    (in_memory,) = judging.tracks_of(recording)
    assert in_memory.pose.tobytes() == written.pose.tobytes()
    assert in_memory.time.tobytes() == written.time.tobytes()


def carry_out_status(count: int) -> Any:
    from cavalcade.recording.status import PlannerStatus

    status = PlannerStatus(
        state="final",
        leader=0,
        roles=np.zeros(1, dtype=int),
        slots=np.zeros((1, 2)),
        goals=np.zeros((1, 2)),
        goal=None,
        paths=(),
        connections=np.zeros((0, 2), dtype=int),
        eta=np.zeros(1),
        arrived=False,
        waypoint=0,
        goal_moved=0.0,
        involved=(),
        message="",
    )
    return (status,) * count


@pytest.mark.usefixtures("no_report")
def test_a_trial_of_a_campaign_again(
    tiny_plan: Definition,
    tmp_path: Path,
    table: Callable[[Path], Any],
    in_this_process: Engine,
) -> None:
    """Bit for bit: with recording and figures the summary is the same but for times."""
    from cavalcade.campaign.repeat import repeat_trial

    run_campaign(tiny_plan, tmp_path / "c", in_this_process)
    trial = "short.0001.fixed-roles.noise"
    done = repeat_trial(tmp_path / "c", trial, tmp_path / "t")
    assert done.same is True
    (line,) = [one for one in table(tmp_path / "c") if one["trial"] == trial]
    assert without_times(done.line) == line
    summary = json.loads((tmp_path / "t" / "summary.json").read_text())
    assert {k: v for k, v in summary.items() if k not in TIMES} == line["summary"]
    with pytest.raises(OutputError, match="not empty"):
        repeat_trial(tmp_path / "c", trial, tmp_path / "t")
    repeat_trial(tmp_path / "c", trial, tmp_path / "t", force=True)
    found = replay(tiny_plan.trial(trial))
    assert found is not None
    assert {k: v for k, v in found.summary.to_dict().items() if k not in TIMES} == line["summary"]


def test_bad_input_is_refused_and_an_exception_is_a_crash(
    noisy: Trial, monkeypatch: pytest.MonkeyPatch
) -> None:
    import cavalcade.jobs.running

    line = run_trial(replace(noisy, overrides=("robots[0].start=[100, 1, 0]",)))
    assert line["outcome"] == "refused"
    assert "robots[0].start" in line["detail"]
    assert (list(line), line["success"], line["summary"]) == (KEYS, False, {})

    def broken(*_: Any, **__: Any) -> Any:
        raise ZeroDivisionError("by nothing\nat all")

    monkeypatch.setattr(cavalcade.jobs.running, "run", broken, raising=False)
    line = run_trial(noisy)
    assert line["outcome"] == "crashed"
    assert line["detail"].startswith("ZeroDivisionError: by nothing at all (test_trial.py:")


def test_a_lost_trial_still_knows_its_world() -> None:
    definition = define_campaign("clutter", seeds=1)
    line = lost_line(definition.trials[0], "overtime", "not done within 3 s")
    assert (line["outcome"], line["feasible"], line["level_name"]) == (
        "overtime",
        True,
        "obstacles",
    )
    assert 15 <= line["level"] <= 50

    class Nothing:
        level_name = None

        def sample(self, seed: int, data: Any) -> Any:
            raise InputError("no such file")

    sampler: Any = Nothing()
    line = lost_line(replace(definition.trials[0], sampler=sampler), "crashed", "killed")
    assert line["feasible"] is True
    assert line["detail"].startswith("killed; the world cannot be drawn: InputError: no such file")


def violation(kind: Any, time: float = 3.0) -> Violation:
    return Violation(kind, time, (0,), "robot 0 touches circle", 0.0, 0.0, "event at 2 s")


class TestVerdict:
    """What the checker and the audit make of the run's own reason."""

    @pytest.fixture
    def scenario(self, tiny_plan: Definition) -> Scenario:
        trial = tiny_plan.trials[0]
        events = "execution.events=[{at: 2.0, add: {circle: {center: [4, 2], radius: 0.3}}}]"
        return replace(trial, overrides=(events,)).scenario(trial.instance())

    @pytest.fixture
    def verdict(self, scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
        def make(
            violations: list[Violation], avoid: bool = True, events: bool = True, **summary: Any
        ) -> judging.Verdict:
            said = {
                "success": False,
                "reason": "collision",
                "detail": None,
                "sim_time_s": 10.0,
                "goal_error_m": [0.01, 0.02],
                **summary,
            }
            monkeypatch.setattr(judging, "judge", lambda *_: Report(tuple(violations), None))
            monkeypatch.setattr(judging, "tracks_of", lambda recording: ())
            found = [
                SimpleNamespace(violation=v, avoidable=avoid, why="too near to brake")
                for v in violations
                if v.kind in CONTACT
            ]
            monkeypatch.setattr(judging, "audit", lambda *_: found)
            execution = scenario.execution.model_copy(update={} if events else {"events": ()})
            ran = scenario.model_copy(update={"execution": execution})
            nothing: Any = None
            return judging.judged(ran, nothing, cast(Any, SimpleNamespace(physics=None)), said)

        return make

    def test_clean(self, verdict: Any) -> None:
        done = verdict([], success=True, reason="arrived")
        assert (done.outcome, done.success, done.contacts) == ("arrived", True, 0)
        done = verdict([], reason="stuck", detail="robots 0 and 1")
        assert (done.outcome, done.success, done.detail) == ("stuck", False, "robots 0 and 1")

    def test_a_collision_that_could_be_avoided(self, verdict: Any) -> None:
        done = verdict([violation("robot-obstacle")])
        assert (done.outcome, done.success, done.contacts, done.avoidable) == (
            "collision",
            False,
            1,
            1,
        )
        assert done.violations == ("3.00 s robot-obstacle: robot 0 touches circle",)

    def test_one_that_could_not(self, verdict: Any) -> None:
        hit = [violation("robot-obstacle")]
        done = verdict(hit, avoid=False)
        assert (done.outcome, done.success, done.avoidable) == ("collision", True, 0)
        assert done.detail == "too near to brake"
        assert not verdict(hit, avoid=False, goal_error_m=[0.01, 0.2]).success
        assert not verdict(hit, avoid=False, goal_error_m=[0.01, None]).success
        assert not verdict(hit, avoid=False, sim_time_s=30.0).success
        assert not verdict(hit, avoid=False, reason="stuck").success
        # Without events there is nothing that could not have been avoided.
        assert not verdict(hit, avoid=False, events=False).success

    def test_any_other_violation(self, verdict: Any) -> None:
        done = verdict([violation("speed")] * 7, success=True, reason="arrived")
        assert (done.outcome, done.success, len(done.violations)) == ("invalid", False, 5)
        done = verdict([violation("robot-map"), violation("speed")], avoid=False)
        assert (done.outcome, done.success) == ("collision", False)

    def test_a_collision_that_only_the_run_saw(self, verdict: Any) -> None:
        done = verdict([])
        assert (done.outcome, done.success, done.contacts) == ("collision", False, 0)


def test_who_is_lost_since_when(tiny_plan: Definition) -> None:
    trial = tiny_plan.trials[0]
    events = "execution.events=[{at: 1, lose: 0}, {at: 2, rejoin: 0}, {at: 3, lose: 1}]"
    scenario = replace(trial, overrides=(events,)).scenario(trial.instance())
    found = scenario.execution.events
    assert [lost_since(found, robot, math.inf) for robot in (0, 1)] == [None, 3.0]
    assert [lost_since(found, robot, 1.5) for robot in (0, 1)] == [1.0, None]
