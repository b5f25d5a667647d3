"""What a job compiles is compiled or loaded before it begins, and the progress is told."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import cavalcade as cv
from cavalcade.jobs import warming
from cavalcade.jobs.reporter import JobReporter
from cavalcade.kernels import progress

WATCHED = Path(__file__).with_name("watched.py")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="a process per job is forked")
def test_a_cycle_waited_for_the_compiler() -> None:
    done = subprocess.run([sys.executable, WATCHED], capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert len(found) > 8
    assert {job: kernels for job, kernels in found.items() if kernels} == {}


def test_what_jobs_need() -> None:
    cone = cv.load_scenario("cone")
    assert warming.needs_of(cone, "ideal") == warming.Needs("formation")
    gap = warming.needs_of(cv.load_scenario("gap"), None)
    assert (gap.kind, gap.uneven, gap.backend) == ("individual", True, None)
    assert "cavalcade.kinodynamic" in gap.modules
    assert "cavalcade.formation" not in gap.modules


def test_all_kernels_of_an_own_loop() -> None:
    planner = cv.FormationPlanner(cv.OccupancyMap.empty((4, 4)), cv.Formation.line(2, 0.8))
    before = planner.status
    cv.warm_up(planner)
    assert planner.status == before  # it was not touched
    with pytest.raises(cv.InputError, match="no-such"):
        cv.warm_up("no-such")
    with pytest.raises(cv.InputError, match="whats: expected a scenario"):
        cv.warm_up(["cone"])


class _Kernels:
    """Stands for a compilation that goes on."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, works: dict[str, float]) -> None:
        self.now = 0.0
        self.functions = {name: _function(name) for name in works}
        monkeypatch.setattr(progress.clock, "perf_counter", lambda: self.now)
        lengths = {self.functions[name]: int(100 * work) for name, work in works.items()}
        monkeypatch.setattr(progress, "_length", lengths.__getitem__)
        dispatchers = [type("D", (), {"py_func": f}) for f in self.functions.values()]
        monkeypatch.setattr(progress, "_kernels_in", lambda modules: dispatchers)
        monkeypatch.setattr(progress, "reached_from", lambda function: {function: ""})


def _function(name: str) -> Any:
    def function() -> None:
        pass

    function.__qualname__ = name
    return function


def test_an_estimate_is_right_where_work_is_even(monkeypatch: pytest.MonkeyPatch) -> None:
    works = {f"f{k}": 1.0 + k % 3 for k in range(60)}
    kernels = _Kernels(monkeypatch, works)
    total = sum(works.values())
    told: list[tuple[float, float]] = []
    compilation = progress.Compilation((), (), lambda c: told.append((kernels.now, c.seconds_left)))
    compilation.begin()
    for name, work in works.items():
        kernels.now += 0.2 * work
        compilation.compiled(kernels.functions[name])
    assert compilation.share == 1.0
    for now, left in told:
        if now > 0.25 * 0.2 * total and now < 0.95 * 0.2 * total:
            assert 1 / 1.5 < left / (0.2 * total - now) < 1.5


def test_what_was_loaded_counts_as_done(monkeypatch: pytest.MonkeyPatch) -> None:
    kernels = _Kernels(monkeypatch, {"a": 1.0, "b": 1.0, "c": 2.0})
    compilation = progress.Compilation((), ("module.c",), lambda _: None)
    compilation.ready({kernels.functions["a"]})
    compilation.begin()
    assert compilation.share == 0.0
    compilation.compiled(kernels.functions["b"])
    assert compilation.kernels == 1
    assert compilation.share == pytest.approx(1 / 3)


def test_the_progress_is_told_on_lines(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    kernels = _Kernels(monkeypatch, {f"f{k}": 1.0 for k in range(10)})
    monkeypatch.setattr("cavalcade.jobs.reporter.clock.monotonic", lambda: kernels.now)
    with JobReporter("job") as reporter, reporter.compiling(()):
        compilation = progress.Compilation((), (), reporter._tell_compiling)
        compilation.begin()
        for function in kernels.functions.values():
            kernels.now += 3.0
            compilation.compiled(function)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("Compiling (once): 10 %, 1 functions done, about ")
    assert 4 <= len(lines) <= 6


def test_nothing_is_said_where_nothing_is_compiled(capsys: pytest.CaptureFixture[str]) -> None:
    warming.warm([warming.Needs("formation")], JobReporter("job", quiet=True))
    with JobReporter("job") as reporter:
        warming.warm([warming.Needs("formation")], reporter)
    assert capsys.readouterr().out == ""
