"""The local engine: crash isolation, time limits, and the same trials whatever the workers."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cavalcade.campaign.definition import Definition
from cavalcade.campaign.dispatch import dispatch
from cavalcade.campaign.engines import ENGINES, local, make_engine
from cavalcade.campaign.engines.local import LocalEngine, WorkersError
from cavalcade.campaign.engines.protocol import Engine
from cavalcade.campaign.runner import run_campaign
from cavalcade.campaign.trial import Trial
from cavalcade.errors import InputError

Table = Callable[[Path], list[dict[str, Any]]]


@pytest.fixture
def undisturbed(tiny_plan: Definition) -> list[Trial]:
    """Half of the trials; of these one is the second world's of the first variant."""
    return [trial for trial in tiny_plan.trials if trial.disturbance == "none"]


@pytest.mark.usefixtures("no_report")
def test_any_workers_and_any_deaths_give_the_same_table(
    tiny_plan: Definition, table: Table, tmp_path: Path, planted: Any, in_this_process: Engine
) -> None:
    none, dying = (tmp_path / name for name in ("none", "dying"))
    run_campaign(tiny_plan, none, in_this_process)
    expected = table(none)
    assert [line["outcome"] for line in expected] == ["arrived"] * 12
    assert all(line["success"] and line["feasible"] for line in expected)
    # A worker that is killed by `kill -9` in a trial costs one retry.
    run_campaign(tiny_plan, dying, LocalEngine(2), work=planted.dies_once)
    assert len(list(planted.FOLDER.glob("died-*"))) == 2
    assert table(dying) == expected


def test_what_kills_its_worker_twice_is_crashed(undisturbed: list[Trial], planted: Any) -> None:
    with LocalEngine(2) as engine:
        lines = {
            line["trial"]: line
            for line in dispatch(engine, undisturbed, 30.0, work=planted.dies_always)
        }
    assert len(lines) == 6
    crashed = [trial for trial, line in lines.items() if line["outcome"] == "crashed"]
    assert crashed == ["short.0001.cavalcade.none"]
    assert (planted.FOLDER / f"deaths-{crashed[0]}").read_text() == "xx"
    line = lines[crashed[0]]
    assert line["detail"] == "the worker was killed by SIGKILL, as at the first try"
    assert (line["success"], line["feasible"], line["summary"]) == (False, True, {})


def test_kill_9_from_outside_in_the_middle_of_a_trial(tiny_plan: Definition, planted: Any) -> None:
    lines = []
    with LocalEngine(2) as engine:
        for line in dispatch(
            engine,
            tiny_plan.trials[:3],
            30.0,
            work=planted.waits_once,
            tick=lambda: _kill_all(planted.FOLDER),
        ):
            lines.append(line)
    assert sorted(line["trial"] for line in lines) == sorted(t.id for t in tiny_plan.trials[:3])
    assert all(line["success"] for line in lines)


def _kill_all(folder: Path) -> None:
    for file in folder.glob("pid-*"):
        text = file.read_text()
        if text:
            file.unlink()
            os.kill(int(text), signal.SIGKILL)


def test_over_time(undisturbed: list[Trial], planted: Any) -> None:
    with LocalEngine(2) as engine:
        lines = list(dispatch(engine, undisturbed, 1.5, work=planted.sleeps))
    late = {line["trial"]: line["detail"] for line in lines if line["outcome"] == "overtime"}
    assert late == {"short.0001.cavalcade.none": "not done within 1.5 s"}
    assert len(lines) == 6


def test_idle_workers_that_die_are_replaced(tiny_plan: Definition, planted: Any) -> None:
    from multiprocessing import active_children

    with LocalEngine(2) as engine:
        first = list(dispatch(engine, tiny_plan.trials[:2], 30.0, work=planted.fake))
        for process in active_children():
            process.kill()
        time.sleep(0.5)
        rest = list(dispatch(engine, tiny_plan.trials[2:], 30.0, work=planted.fake))
    assert len(first + rest) == 12
    assert all(line["success"] for line in first + rest)


def test_workers_use_one_thread_and_results_that_cannot_travel_are_crashed(
    tiny_plan: Definition, planted: Any
) -> None:
    with LocalEngine(1) as engine:
        (line,) = dispatch(engine, tiny_plan.trials[:1], 30.0, work=planted.notes_threads)
        assert line["detail"] == "1"
        (line,) = dispatch(engine, tiny_plan.trials[:1], 30.0, work=planted.unpicklable)
        assert line["outcome"] == "crashed"


@pytest.mark.usefixtures("no_report")
def test_workers_that_never_start_end_the_campaign_and_no_trial(
    tiny_plan: Definition, planted: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(local, "start_worker", planted.die_at_once)
    monkeypatch.setattr(local, "_BREAKS", 2)
    with pytest.raises(WorkersError, match="the worker processes end before they take a trial"):
        run_campaign(tiny_plan, tmp_path / "a", LocalEngine(1), work=planted.fake)
    assert (tmp_path / "a" / "trials.jsonl").read_text() == ""


def test_a_job_that_went_down_with_the_pool_is_not_lost(
    tiny_plan: Definition, planted: Any
) -> None:
    with LocalEngine(1) as engine:
        engine.submit("a", planted.fake, (tiny_plan.trials[0],), 60.0)
        engine._all[0].stop()
        (ended,) = _collected(engine)
    assert (ended.key, ended.fate) == ("a", "done")


def _collected(engine: LocalEngine) -> list[Any]:
    until = time.monotonic() + 30.0
    found: list[Any] = []
    while not found and time.monotonic() < until:
        found = engine.collect(0.5)
    return found


def test_ctrl_c_does_not_reach_workers_and_leaving_ends_them_in_the_middle_of_a_trial(
    tiny_plan: Definition, planted: Any
) -> None:
    with LocalEngine(1) as engine:
        (line,) = dispatch(engine, tiny_plan.trials[:1], 30.0, work=planted.notes_signals)
        assert line["detail"] == "blocked"
        assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])
        engine.submit("a", planted.waits_once, (tiny_plan.trials[0],), 60.0)
        pid = _pid(planted.FOLDER)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def _pid(folder: Path) -> int:
    until = time.monotonic() + 30.0
    while time.monotonic() < until:
        texts = [file.read_text() for file in folder.glob("pid-*")]
        if texts and texts[0]:
            return int(texts[0])
        time.sleep(0.02)
    raise AssertionError("no worker began")


def test_what_is_prepared_comes_first(tiny_plan: Definition) -> None:
    """What compiles kernels for all trials has the machine, and more time."""
    engine = _Recorded()
    lines = list(dispatch(engine, tiny_plan.trials, 5.0, prepare=(print, ())))
    assert len(lines) == 12
    assert engine.most_at_first == 1
    assert engine.limits[0] > 100.0
    assert set(engine.limits[1:]) == {5.0}


class _Recorded:
    """An engine that does nothing, and knows what it was asked."""

    workers = 4

    def __init__(self) -> None:
        self.waiting: list[str] = []
        self.limits: list[float] = []
        self.most_at_first = 0
        self.collected = 0

    @property
    def room(self) -> int:
        return 4 - len(self.waiting)

    def submit(self, key: str, work: Any, arguments: Any, limit: float) -> None:
        self.waiting.append(key)
        self.limits.append(limit)

    def collect(self, timeout: float) -> list[Any]:
        from cavalcade.campaign.engines import Ended

        if not self.collected:
            self.most_at_first = len(self.waiting)
        self.collected += 1
        done, self.waiting = self.waiting, []
        return [Ended(key, "done", {"trial": key}) for key in done]

    def __enter__(self) -> _Recorded:
        return self

    def __exit__(self, *_: object) -> None:
        pass


@pytest.mark.parametrize(
    ("name", "workers", "message"),
    [
        ("lokal", None, "--engine: unknown engine 'lokal'; did you mean local?"),
        ("local", 0, "--workers: expected a whole number from 1 on, got 0"),
        ("local", 100_000, "--workers: expected at most "),
        ("ray", 100_000, "--workers: expected at most "),
    ],
)
def test_no_such_engine(
    name: str, workers: int | None, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("RAY_ADDRESS", raising=False)
    with pytest.raises(InputError) as caught:
        make_engine(name, workers)
    assert str(caught.value).startswith(message)
    assert ENGINES == ("local", "ray")


def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(InputError, match=r"pip install cavalcade\[cluster\]"):
        make_engine("ray", 2)
