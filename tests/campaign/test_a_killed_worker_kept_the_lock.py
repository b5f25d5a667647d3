"""A worker that was killed while it took a trial, or gave its line back, once stopped them all.

It kept the lock of a pipe that all workers shared: for a minute nothing was finished, then the
others died of it and cost their trials a retry.
"""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from cavalcade.campaign.definition import Definition
from cavalcade.campaign.engines.local import LocalEngine


@pytest.mark.parametrize(
    ("work", "fate"), [("takes", "done"), ("gives", "lost"), ("gives_half", "lost")]
)
@pytest.mark.parametrize("workers", [1, 2])
def test_a_worker_killed_with_the_lock_stops_no_other(
    work: str, fate: str, workers: int, tiny_plan: Definition, planted: Any
) -> None:
    first, second = tiny_plan.trials[:2]
    expected = {"killed": fate, "after": "done"}
    with LocalEngine(workers) as engine:
        if workers == 2:
            engine.submit("beside", planted.waits_once, (first,), 60.0)
            _pid(planted.FOLDER / f"pid-{first.id}")
            expected["beside"] = "done"
        trial = planted.SlowToTake() if work == "takes" else second
        engine.submit("killed", getattr(planted, work), (trial,), 60.0)
        os.kill(_pid(planted.FOLDER / "pid"), signal.SIGKILL)
        (planted.FOLDER / "go").touch()
        engine.submit("after", planted.fake, (second,), 60.0)
        fates: dict[str, str] = {}
        until = time.monotonic() + 20.0
        while len(fates) < len(expected) and time.monotonic() < until:
            fates |= {ended.key: ended.fate for ended in engine.collect(0.5)}
    # A trial that had not begun has not failed.
    assert fates == expected


def _pid(file: Path) -> int:
    until = time.monotonic() + 20.0
    while time.monotonic() < until:
        if file.exists() and file.read_text():
            return int(file.read_text())
        time.sleep(0.01)
    raise AssertionError("no worker began")
