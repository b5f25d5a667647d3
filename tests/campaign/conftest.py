"""A suite of trials that take a twentieth of a second each, and what tests do with it."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cavalcade.campaign.lines import without_times
from cavalcade.campaign.plan import Plan, make_plan

SCENARIO = """\
version: 1
name: short
world: {empty: {size: [6, 4]}}
robots:
  - {model: go1, start: [1.0, 2.5, 0.0]}
  - {model: go1, start: [1.0, 1.5, 0.0]}
task:
  formation: {shape: line, spacing: 1.0}
  goals: [[2.5, 2.0, 0.0]]
execution: {timeout: 30}
"""

SUITE = """\
version: 1
suite: tiny
about: Two robots go one and a half metres.
time_limit: 60
variants: [cavalcade, fixed-roles]
disturbances:
  none: {}
  noise: {noise: {position: 0.002, heading: 0.002}}
worlds:
  - {name: short, draw: shipped, scenario: SCENARIO, seeds: 3}
"""


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """The file of a suite of 12 trials."""
    scenario = tmp_path / "short.yaml"
    scenario.write_text(SCENARIO, encoding="utf-8")
    suite = tmp_path / "tiny.yaml"
    suite.write_text(SUITE.replace("SCENARIO", str(scenario)), encoding="utf-8")
    return suite


@pytest.fixture
def tiny_plan(tiny: Path) -> Plan:
    return make_plan(tiny)


@pytest.fixture
def table() -> Callable[[Path], list[dict[str, Any]]]:
    """The lines of a campaign's folder by trial, without what differs from run to run."""

    def read(folder: Path) -> list[dict[str, Any]]:
        text = (folder / "trials.jsonl").read_text(encoding="utf-8")
        lines = [without_times(json.loads(line)) for line in text.splitlines()]
        return sorted(lines, key=lambda line: line["trial"])

    return read


PLANTED = '''\
"""Work for workers that does what real work should not."""

import os
import signal
import time
from pathlib import Path

from cavalcade.campaign.carrying import carry_out
from cavalcade.campaign.lines import failure_line

FOLDER = Path(FOLDER_NAME)


def _first_time(name):
    try:
        (FOLDER / name).touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


def fake(trial):
    """A line at once, without a run."""
    return failure_line(trial, "arrived", "") | {"success": True}


def slow_fake(trial):
    time.sleep(0.2)
    return fake(trial)


def dies_once(trial):
    """The third trial kills its worker, but only the first time."""
    if trial.seed == 1 and trial.variant == "cavalcade" and _first_time("died-" + trial.id):
        os.kill(os.getpid(), signal.SIGKILL)
    return carry_out(trial)


def dies_always(trial):
    if trial.seed == 1 and trial.variant == "cavalcade":
        with (FOLDER / ("deaths-" + trial.id)).open("a") as stream:
            stream.write("x")
        os.kill(os.getpid(), signal.SIGKILL)
    return fake(trial)


def sleeps(trial):
    if trial.seed == 1 and trial.variant == "cavalcade":
        (FOLDER / ("began-" + trial.id)).touch()
        time.sleep(60.0)
    return fake(trial)


def waits_once(trial):
    """Every trial waits at its first try until the test lets it go or kills the worker."""
    if _first_time("waiting-" + trial.id):
        (FOLDER / ("pid-" + trial.id)).write_text(str(os.getpid()))
        while not (FOLDER / "go").exists():
            time.sleep(0.02)
    return fake(trial)


def notes_threads(trial):
    import numba

    return fake(trial) | {"detail": str(numba.config.NUMBA_NUM_THREADS)}


def notes_signals(trial):
    blocked = signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    return fake(trial) | {"detail": "blocked" if blocked else "free"}


def die_at_once():
    os._exit(3)


def unpicklable(trial):
    return lambda: None
'''


@pytest.fixture
def planted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module that workers can import, with work that crashes, hangs and so on."""
    import importlib
    import sys

    folder = tmp_path / "planted"
    folder.mkdir()
    text = textwrap.dedent(PLANTED).replace("FOLDER_NAME", repr(str(folder)))
    (folder / "planted_work.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=":")
    sys.modules.pop("planted_work", None)
    yield importlib.import_module("planted_work")
    sys.modules.pop("planted_work", None)
