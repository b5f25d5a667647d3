"""Leaps as they are told and as campaigns count them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cavalcade.campaign.definition import define_campaign
from cavalcade.campaign.judging import crossings, judged
from cavalcade.campaign.trial_runner import run_trial_into
from cavalcade.errors import ScenarioError
from cavalcade.jobs import JobResult
from cavalcade.recording.physics_track import PhysicsTrack

SUITE = """\
version: 1
suite: leaps
backend: mujoco
worlds:
  - {name: gap, sampler: walk, kind: gap, width: 0.3, seeds: 1}
  - {name: flat, sampler: walk, kind: steady, duration: 1, seeds: 1}
"""


@pytest.fixture(scope="module")
def leapt(tmp_path_factory: pytest.TempPathFactory) -> JobResult:
    pytest.importorskip("mujoco")
    file = tmp_path_factory.mktemp("leaps") / "leaps.yaml"
    file.write_text(SUITE, encoding="utf-8")
    line, ran = run_trial_into(define_campaign(file).trial("gap.0000.cavalcade"), None)
    assert isinstance(ran, JobResult)
    assert (line["outcome"], line["success"], line["violations"]) == ("done", True, [])
    assert (line["measured"]["crossings"], line["measured"]["strict_crossings"]) == (1, 1)
    return ran


def changed(track: PhysicsTrack, **values: Any) -> PhysicsTrack:
    return replace(track, **values)


def test_it_flies_from_one_side_to_the_other_and_stands(leapt: JobResult) -> None:
    track = leapt.recording.physics
    assert track is not None
    loads = track.foot_forces[:, 0, :, 2].sum(axis=1)
    flying = track.time[1:][loads[1:] < 1.0]
    assert 0.15 < np.ptp(flying) < 1.0
    x = np.interp([flying[0], flying[-1]], track.time, track.base[:, 0, 0])
    assert x[0] < 3.0 < x[1]
    assert track.time[-1] - flying[-1] > 1.5


def test_who_ends_before_the_gap_or_too_early_has_not_leapt(leapt: JobResult) -> None:
    """A recording that is cut right after the landing, and one that is moved back."""
    recording, summary = leapt.recording, leapt.summary
    track = recording.physics
    assert track is not None
    keep = track.time <= track.time[-1] - 1.0
    short = changed(
        track,
        **{
            name: getattr(track, name)[keep]
            for name in ("time", "base", "joints", "joint_rates", "torques", "foot_forces")
        },
    )
    cut = replace(recording, physics=short)
    assert crossings(leapt.scenario, cut) == {"crossings": 1, "strict_crossings": 0}
    back = track.base - np.array([0.8, 0, 0, 0, 0, 0, 0])
    moved = replace(recording, physics=changed(track, base=back))
    assert crossings(leapt.scenario, moved)["strict_crossings"] == 0
    verdict = judged(leapt.scenario, leapt.world, moved, summary)
    assert verdict.outcome == "invalid"
    assert not verdict.success


def test_other_ground_has_no_crossings(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    file = tmp_path / "leaps.yaml"
    file.write_text(SUITE, encoding="utf-8")
    line, _ = run_trial_into(define_campaign(file).trial("flat.0000.cavalcade"), None)
    assert line["measured"] == {"time_ratio": None}


def test_ideal_robots_do_not_leap_when_told(tmp_path: Path) -> None:
    file = tmp_path / "leaps.yaml"
    file.write_text(SUITE.replace("mujoco", "ideal"), encoding="utf-8")
    trial = define_campaign(file).trial("gap.0000.cavalcade")
    with pytest.raises(ScenarioError, match=r"commands\[0\]\.leap: ideal robots do not leap"):
        trial.scenario(trial.instance())
