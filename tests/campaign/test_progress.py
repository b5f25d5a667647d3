from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from cavalcade.campaign.dispatch import in_turns
from cavalcade.campaign.progress import CampaignReporter
from cavalcade.jobs.reporter import duration


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_plain_lines(capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    with CampaignReporter("clutter", 1000, 100, now=clock) as reporter:
        for _ in range(900):
            clock.now += 1.0
            reporter.finished({"success": clock.now < 1000.0})
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "clutter: 1000 trials, 100 of them done already"
    assert lines[1] == "130 of 1000 trials (13 %), none failed, 14 min 30 s left"
    assert lines[-1].startswith("970 of 1000 trials (97 %), ")
    assert len(lines) == 30


def test_lines_every_five_percent_when_that_is_sooner(capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    with CampaignReporter("smoke", 20, now=clock) as reporter:
        for _ in range(20):
            clock.now += 2.0
            reporter.finished({"success": False})
    lines = capsys.readouterr().out.splitlines()
    assert lines[1] == "3 of 20 trials (15 %), 3 failed, 34 s left"
    assert len(lines) == 7


def test_slow_groups_at_the_end_made_the_estimate_too_short(
    capsys: pytest.CaptureFixture[str],
) -> None:
    clock = Clock()
    seconds = {"quick": 1.0, "slow": 9.0}
    trials: list[Any] = [
        SimpleNamespace(id=f"{group}{seed}", group=group, variant="a", disturbance="none")
        for group in seconds
        for seed in range(50)
    ]
    left = in_turns(trials)
    assert [trial.id for trial in left[:4]] == ["quick0", "slow0", "quick1", "slow1"]
    assert sorted(trial.id for trial in left) == sorted(trial.id for trial in trials)
    with CampaignReporter("both", 100, now=clock) as reporter:
        for trial in left:
            clock.now += seconds[trial.group]
            reporter.finished({"success": True})
            if reporter._said == clock.now:
                told = capsys.readouterr().out.splitlines()[-1].split(", ")[-1]
                minutes, _, rest = told.removesuffix(" s left").rpartition(" min ")
                said, true = 60 * int(minutes or 0) + int(rest), 600.0 - clock.now
                assert said == pytest.approx(true, rel=0.5, abs=10.0)


def test_quiet(capsys: pytest.CaptureFixture[str]) -> None:
    with CampaignReporter("smoke", 20, quiet=True) as reporter:
        reporter.finished({"success": True})
        reporter.say("x")
        reporter.warn("a line\nwas torn")
    out, err = capsys.readouterr()
    assert out == ""
    assert err == "cavalcade: warning: a line was torn\n"


def test_a_bar_on_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    with CampaignReporter("smoke", 20) as reporter:
        for _ in range(20):
            reporter.finished({"success": True})
    said = capsys.readouterr().out
    assert "smoke" in said
    assert "20/20" in said


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.2, "0 s"), (59.4, "59 s"), (200.0, "3 min 20 s"), (3600.0 * 2 + 300, "2 h 05 min")],
)
def test_durations(seconds: float, text: str) -> None:
    assert duration(seconds) == text
