"""A checkout as a command line: its own source under its own Python, and nothing else of it."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from comparing.folders import SAID


class StoppedError(Exception):
    """No more commands are to be run."""


class UnusableError(Exception):
    """A checkout cannot be used; the message says why."""


@dataclass(frozen=True)
class Done:
    """A command that has ended.

    Attributes:
        code: Its exit code, negative for a signal's number.
        cpu: Seconds that it and the processes it waited for spent on the processor.
        wall: Seconds from start to end.
        out: What it wrote to stdout.
        err: What it wrote to stderr.
    """

    code: int
    cpu: float
    wall: float
    out: str
    err: str


class Processes:
    """Runs commands, from several threads at once, and ends all of them when told to."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._groups: set[int] = set()
        self._stopped = False

    def run(
        self, command: Sequence[str], folder: Path, environment: dict[str, str], limit: float
    ) -> Done:
        """Run a command in a process group of its own, for `limit` s of wall time at most.

        Raises:
            StoppedError: `stop` has been called.
        """
        began = time.perf_counter()
        with self._lock:
            if self._stopped:
                raise StoppedError
            process = subprocess.Popen(
                command,
                cwd=folder,
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
            self._groups.add(process.pid)
        texts = [b"", b""]
        readers = [
            threading.Thread(target=_drain, args=(stream, texts, place), daemon=True)
            for place, stream in enumerate((process.stdout, process.stderr))
        ]
        for reader in readers:
            reader.start()
        timer = threading.Timer(limit, _end, (process.pid, signal.SIGKILL))
        timer.start()
        try:
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        finally:
            timer.cancel()
            _end(process.pid, signal.SIGKILL)  # whatever it left running
            with self._lock:
                self._groups.discard(process.pid)
        for reader in readers:
            reader.join()
        if self._stopped:
            raise StoppedError
        out, err = (text.decode("utf-8", "replace") for text in texts)
        cpu = usage.ru_utime + usage.ru_stime
        return Done(process.returncode, cpu, time.perf_counter() - began, out, err)

    def stop(self) -> None:
        """End every command and start none any more."""
        with self._lock:
            self._stopped = True
            groups = list(self._groups)
        for group in groups:
            _end(group, signal.SIGTERM)
        until = time.monotonic() + 5.0
        while self._groups and time.monotonic() < until:
            time.sleep(0.05)
        for group in groups:
            _end(group, signal.SIGKILL)


@dataclass(frozen=True)
class Checkout:
    """One of the two sides.

    Attributes:
        name: `old` or `new`.
        root: The checkout.
        python: The interpreter with what it depends on.
        processes: Who runs its commands.
        limit: Wall time of one command, s.
    """

    name: str
    root: Path
    python: Path
    processes: Processes
    limit: float

    def run(self, arguments: Sequence[str], folder: Path) -> Done:
        """Run its Python with these arguments in a folder, with this checkout's source."""
        kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "CAVALCADE"))}
        environment = {**kept, "PYTHONPATH": str(self.root / "src")}
        command = [str(self.python), *arguments]
        return self.processes.run(command, folder, environment, self.limit)

    def cavalcade(self, arguments: Sequence[str], folder: Path, name: str) -> Done:
        """Run a command of cavalcade and leave what it said and its exit code beside its results.

        Args:
            arguments: After `cavalcade`.
            folder: Where it runs.
            name: Of the file, to which `SAID` is added.
        """
        done = self.run(["-m", "cavalcade", *arguments], folder)
        try:
            out = json.loads(done.out)
        except ValueError:
            out = done.out.splitlines()
        said = {"exit_code": done.code, "stdout": out, "stderr": done.err.splitlines()}
        (folder / f"{name}{SAID}").write_text(json.dumps(said, indent=1), encoding="utf-8")
        return done

    def check(self, folder: Path) -> None:
        """See that it is this checkout's source that its Python runs.

        Raises:
            UnusableError: It is not, or cannot be run.
        """
        if not self.python.is_file():
            raise UnusableError(
                f"{self.python}: no such Python; name one with --python-{self.name}"
            )
        done = self.run(["-c", "import cavalcade; print(cavalcade.__file__)"], folder)
        if done.code:
            last = (done.err.strip().splitlines() or [""])[-1]
            raise UnusableError(f"{self.root}: cavalcade cannot be imported: {last}")
        if not Path(done.out.strip()).resolve().is_relative_to(self.root / "src"):
            raise UnusableError(f"{self.python}: runs {done.out.strip()}, not {self.root / 'src'}")


def _drain(stream: object, texts: list[bytes], place: int) -> None:
    with stream:  # type: ignore[attr-defined]
        texts[place] = stream.read()  # type: ignore[attr-defined]


def _end(group: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(group, number)
