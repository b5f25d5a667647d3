"""Processes on a ROS 2 graph of their own, for benchmarks."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Self

OPERATOR = Path(__file__).parent.parent / "tests" / "live" / "peers" / "goal.py"
"""An operator that is written without Cavalcade."""

_ENDING = 60.0
"""A process may take so long to end, s."""


class Process(subprocess.Popen):
    """A process whose output is in a file."""

    def __init__(self, words: Sequence[str], environment: dict[str, str], log: Path) -> None:
        self._log = log
        with log.open("wb") as file:
            super().__init__(words, stdout=file, stderr=subprocess.STDOUT, env=environment)

    @property
    def text(self) -> str:
        """What it said."""
        return self._log.read_text()


class Processes:
    """Starts them and ends them all; their outputs are in the folder `out`, which is made."""

    def __init__(self, out: Path) -> None:
        if out.exists():
            sys.exit(f"{out} is there already; name another folder with --out")
        out.mkdir(parents=True)
        self._out = out
        self._begun: list[Process] = []
        self._environment = {
            "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            **os.environ,
            "ROS_LOG_DIR": str(out / "log"),
        }

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for process in reversed(self._begun):
            self.end(process)

    def cavalcade(self, *words: str) -> Process:
        """One of our commands."""
        return self.python("-m", "cavalcade", *words)

    def python(self, *words: str) -> Process:
        """Another script."""
        log = self._out / f"{len(self._begun)}.log"
        self._begun.append(Process([sys.executable, *words], self._environment, log))
        return self._begun[-1]

    def end(self, process: Process) -> int:
        """Ask a process to end, and give its exit code."""
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        try:
            return process.wait(_ENDING)
        except subprocess.TimeoutExpired:
            process.kill()
            return process.wait()
