"""Real campaigns in processes of their own that are stopped in the middle, and gone on with."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

from cavalcade.campaign.definition import define_campaign
from cavalcade.campaign.engines.protocol import Engine
from cavalcade.campaign.runner import run_campaign
from cavalcade.cli import main

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/status").exists(), reason="processes are looked up in /proc"
)

Table = Callable[[Path], list[dict[str, Any]]]

# The report has tests of its own.
PROGRAM = """\
import sys
from cavalcade.campaign import report
from cavalcade.cli import main

report.write_report = lambda *_, **__: ()
if __name__ == "__main__":
    sys.exit(main())
"""


@pytest.fixture
def suite(tiny: Path) -> Path:
    """More trials than the tiny one's, each of half a metre."""
    tiny.write_text(tiny.read_text().replace("seeds: 3", "seeds: 7"))
    scenario = tiny.with_name("short.yaml")
    scenario.write_text(scenario.read_text().replace("[2.5, 2.0, 0.0]", "[1.5, 2.0, 0.0]"))
    return tiny


@pytest.fixture
def start(tmp_path: Path, suite: Path) -> Callable[..., subprocess.Popen[str]]:
    """Starts the campaign of 28 trials in `tmp_path / out`."""
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)

    def begin(out: str, *more: str, workers: int = 2) -> subprocess.Popen[str]:
        words = ["campaign", str(suite), "--out", str(tmp_path / out)]
        words += ["--workers", str(workers), *more]
        return subprocess.Popen(
            [sys.executable, str(program), *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    return begin


@pytest.fixture
def go_on(
    tmp_path: Path,
    suite: Path,
    in_this_process: Engine,
    no_report: None,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Callable[..., tuple[int, str, str]]:
    """Does the same here, without workers, where nobody stops it; exit code, output, errors."""
    monkeypatch.setattr("cavalcade.campaign.engines.make_engine", lambda *_: in_this_process)

    def done(out: str, *more: str) -> tuple[int, str, str]:
        code = main(["campaign", str(suite), "--out", str(tmp_path / out), *more])
        return code, *capsys.readouterr()

    return done


def wait_for_lines(folder: Path, count: int) -> None:
    until = time.monotonic() + 60.0
    while time.monotonic() < until:
        file = folder / "trials.jsonl"
        if file.exists() and file.read_bytes().count(b"\n") >= count:
            return
        time.sleep(0.005)
    raise AssertionError("no trials were finished")


def children(parent: int) -> set[int]:
    """Every process below one."""
    below: dict[int, set[int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                stat = (entry / "stat").read_text()
            except OSError:
                continue
            below.setdefault(int(stat.rpartition(")")[2].split()[1]), set()).add(int(entry.name))
    found, todo = set(), [parent]
    while todo:
        new = below.get(todo.pop(), set()) - found
        found |= new
        todo += new
    return found


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_for_the_end_of(processes: Iterable[int]) -> None:
    until = time.monotonic() + 20.0
    while any(map(alive, processes)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(alive, processes))


def test_kill_9_of_a_worker_and_of_the_parent(
    start: Callable[..., subprocess.Popen[str]],
    go_on: Callable[..., tuple[int, str, str]],
    suite: Path,
    tmp_path: Path,
    table: Table,
    in_this_process: Engine,
) -> None:
    run_campaign(define_campaign(suite), tmp_path / "whole", in_this_process)
    expected = table(tmp_path / "whole")
    assert len(expected) == 28

    process = start("killed")
    wait_for_lines(tmp_path / "killed", 2)
    workers = sorted(children(process.pid))
    os.kill(workers[-1], signal.SIGKILL)
    wait_for_lines(tmp_path / "killed", 6)
    workers = sorted(children(process.pid))
    process.kill()
    process.communicate()
    wait_for_the_end_of(workers)
    done = len((tmp_path / "killed" / "trials.jsonl").read_text().splitlines())
    assert 6 <= done < 28

    code, out, _ = go_on("killed", "--resume", "--json")
    assert code == 0
    summary = json.loads(out)
    assert (summary["trials"], summary["outcomes"]) == (28, {"arrived": 28})
    assert table(tmp_path / "killed") == expected


def test_ctrl_c_ends_cleanly_and_says_how_to_go_on(
    start: Callable[..., subprocess.Popen[str]],
    go_on: Callable[..., tuple[int, str, str]],
    tmp_path: Path,
    table: Table,
) -> None:
    process = start("a", "--set", "execution.rate=25", workers=1)
    wait_for_lines(tmp_path / "a", 2)
    workers = children(process.pid)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    said = err.splitlines()
    assert len(said) == 2
    assert said[1] == "cavalcade: interrupted"
    assert " of 28 trials are done; go on with: cavalcade campaign " in said[0]
    assert said[0].endswith(f"--out {tmp_path / 'a'} --set execution.rate=25 --workers 1 --resume")
    wait_for_the_end_of(workers)
    before = (tmp_path / "a" / "trials.jsonl").read_bytes()
    done = before.count(b"\n")
    assert said[0].startswith(f"cavalcade: {done} of 28 ")
    # Without the same overrides it is another campaign.
    code, _, err = go_on("a", "--resume")
    assert code == 2
    assert "was begun with other overrides (--set): execution.rate=25" in err
    code, _, err = go_on("a", "--resume", "--set", "execution.rate=25", "--quiet")
    assert (code, err) == (0, "")
    assert len(table(tmp_path / "a")) == 28
    assert (tmp_path / "a" / "trials.jsonl").read_bytes().startswith(before)


def test_a_full_disk_in_the_middle(
    go_on: Callable[..., tuple[int, str, str]], tmp_path: Path, table: Table
) -> None:
    """A limit on the size of files stands in for a disk that is full."""
    assert go_on("other", "--seeds", "1")[0] == 0  # what is imported has been written by then
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (8000, before[1]))
    try:
        code, _, err = go_on("a")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert code == 2
    assert err.count("\n") == 1
    assert err.startswith(f"cavalcade: {tmp_path / 'a' / 'trials.jsonl'}: cannot be written: ")
    assert err.endswith("trials so far are kept, go on with --resume\n")
    text = (tmp_path / "a" / "trials.jsonl").read_text()
    assert text.endswith("}\n")
    assert 3 <= text.count("\n") < 28
    code, out, err = go_on("a", "--resume")
    assert (code, err) == (0, "")
    assert len(table(tmp_path / "a")) == 28
    assert f"{text.count(chr(10))} of them done already" in out
