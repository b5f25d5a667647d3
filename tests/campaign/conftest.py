"""A suite of trials that take a twentieth of a second each, and what tests do with it."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

import pytest

from cavalcade.campaign.definition import Definition, define_campaign
from cavalcade.campaign.engines.protocol import Ended, Work
from cavalcade.campaign.trial import without_times

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
  - {name: short, sampler: shipped, scenario: SCENARIO, seeds: 3}
"""


class InThisProcess:
    """An engine without processes: what trials give by themselves, for what needs no worker."""

    def __init__(self) -> None:
        self._ended: list[Ended] = []

    @property
    def room(self) -> int:
        return 1 - len(self._ended)

    def submit(self, key: str, work: Work, arguments: tuple[Any, ...], limit: float) -> None:
        self._ended.append(Ended(key, "done", work(*arguments)))

    def collect(self, timeout: float) -> list[Ended]:
        ended, self._ended = self._ended, []
        return ended

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        pass


@pytest.fixture
def in_this_process() -> InThisProcess:
    return InThisProcess()


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """The file of a suite of 12 trials."""
    scenario = tmp_path / "short.yaml"
    scenario.write_text(SCENARIO, encoding="utf-8")
    suite = tmp_path / "tiny.yaml"
    suite.write_text(SUITE.replace("SCENARIO", str(scenario)), encoding="utf-8")
    return suite


@pytest.fixture
def tiny_plan(tiny: Path) -> Definition:
    return define_campaign(tiny)


@pytest.fixture
def no_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """Campaigns leave their lines alone."""
    monkeypatch.setattr("cavalcade.campaign.report.write_report", lambda *_, **__: ())


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

import gc
import os
import signal
import time
from multiprocessing.connection import Connection
from pathlib import Path

from cavalcade.campaign.trial import failure_line

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
    from cavalcade.campaign.trial_runner import run_trial  # takes long to import

    return run_trial(trial)


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


def _wait_for_the_end():
    """Say which worker this is and wait to be killed; the next worker need not."""
    if _first_time("held"):
        (FOLDER / "pid").write_text(str(os.getpid()))
        time.sleep(60.0)


class SlowToTake:
    """A trial that workers do not get to the end of while they take it."""

    def __reduce__(self):
        return _wait_for_the_end, ()


class SlowToGive:
    """A result that workers do not get to the end of while they give it back."""

    def __reduce__(self):
        _wait_for_the_end()
        return str, ()


class HalfGiven(SlowToGive):
    """The same, with the beginning of a message of 1000 bytes in the pipe."""

    def __reduce__(self):
        pipes = [thing for thing in gc.get_objects() if isinstance(thing, Connection)]
        (pipe,) = (pipe for pipe in pipes if not pipe.closed and pipe.writable)
        os.write(pipe.fileno(), (1000).to_bytes(4, "big") + b"half")
        return super().__reduce__()


def takes(_):
    return "taken"


def gives(_):
    return SlowToGive()


def gives_half(_):
    return HalfGiven()


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
