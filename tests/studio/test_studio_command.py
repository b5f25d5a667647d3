"""`cavalcade studio` as a command: it says where it is, and ends when it is told to."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from cavalcade.errors import InputError
from cavalcade.studio.app import Studio


def command(*words: str, folder: Path) -> list[str]:
    return [sys.executable, "-m", "cavalcade", "studio", *words, "--out", str(folder / "studio")]


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_it_says_where_it_is_and_ends_cleanly(tmp_path: Path, ending: signal.Signals) -> None:
    words = command("triangle-lab", "--port", "0", folder=tmp_path)
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.fullmatch(r"The studio is at (http://127\.0\.0\.1:\d+); Ctrl-C ends it\n", line)
        assert found, line
        with urllib.request.urlopen(found[1], timeout=30) as page:
            assert page.status == 200
        process.send_signal(ending)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 0
    assert (out, err) == ("", "")
    assert not (tmp_path / "studio").exists()


def test_a_port_in_use_is_said(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"cannot listen on 127.0.0.1, port {port}"):
            Studio(port=port, folder=tmp_path)
        words = command("--port", str(port), folder=tmp_path)
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "--port 0" in done.stderr


@pytest.mark.parametrize("host", ["no.such.host.invalid", "203.0.113.7"])
def test_a_host_that_is_not_this_machine_is_said(tmp_path: Path, host: str) -> None:
    with pytest.raises(InputError, match=f"cannot listen on {re.escape(host)}"):
        Studio(host, 0, folder=tmp_path)


@pytest.mark.parametrize("shown", ["sqare-clutter", "no/such/file.yaml", "."])
def test_what_it_cannot_open_is_said(tmp_path: Path, shown: str) -> None:
    words = command(shown, "--port", "0", folder=tmp_path)
    done = subprocess.run(words, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_it_opens_a_scenario_and_what_a_run_has_left(tmp_path: Path) -> None:
    with Studio(port=0, folder=tmp_path / "studio") as studio:
        studio.open("triangle-lab")
        assert studio.build.draft.scenario is not None
        assert studio.build.draft.scenario.name == "triangle-lab"
        assert studio.chosen == "Build"
        with pytest.raises(InputError):
            studio.open(tmp_path / "missing")
        assert studio.build.draft.scenario.name == "triangle-lab"
        with pytest.raises(InputError, match="no tab"):
            studio.choose("Else")  # type: ignore[arg-type]
