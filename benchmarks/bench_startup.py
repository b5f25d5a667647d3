"""How long the shell's return key is from the first motion, with and without compiled kernels.

Every measurement is a fresh process of `cavalcade run`, timed from before its start. The kernels
go to a folder of their own, so the first process finds none, as after installation.

    python benchmarks/bench_startup.py [--scenario square-clutter] [--runs 5]
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

PROBE = """
import sys, time
from cavalcade.cli import commands, main

run_command = commands.run_command
moves = False

def watched(arguments):
    # Only here, so that a command's imports are its own, as from the shell.
    from cavalcade.execution.control import ControlLoop

    send = ControlLoop.send

    def told(self, commands):
        global moves
        send(self, commands)
        if not moves and commands.any():
            moves = True
            print(f"MOVES {time.time()}", file=sys.stderr)

    ControlLoop.send = told
    return run_command(arguments)

commands.run_command = watched
code = main(sys.argv[1:])
print(f"ENDS {time.time()}", file=sys.stderr)
sys.exit(code)
"""


@dataclass(frozen=True)
class Start:
    """Seconds from the start of a process to its first motion and to its end; what it said."""

    moves: float
    ends: float
    said: str


def run_once(scenario: str, cache: Path) -> Start:
    """One `cavalcade run` in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.time()
        done = subprocess.run(
            [sys.executable, "-c", PROBE, "run", scenario, "--out", str(Path(folder) / "run")],
            env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
            capture_output=True,
            text=True,
            check=True,
        )
    marks = dict(
        line.split() for line in done.stderr.splitlines() if line[:5] in ("MOVES", "ENDS ")
    )
    return Start(
        float(marks["MOVES"]) - began, float(marks["ENDS"]) - began, done.stdout.splitlines()[0]
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scenario", default="square-clutter")
    parser.add_argument("--runs", type=int, default=5, help="runs with compiled kernels")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        cold = run_once(options.scenario, Path(folder))
        warm = [run_once(options.scenario, Path(folder)) for _ in range(options.runs)]
        kernels = len({file.name for file in Path(folder).rglob("*.nbi")})
        versions = len(list(Path(folder).rglob("*.nbc")))
    moves = statistics.median(start.moves for start in warm)
    compiling = cold.ends - statistics.median(start.ends for start in warm)
    print(f"{options.scenario}, {kernels} kernels in {versions} versions")
    print(f"  nothing compiled: compiling costs {compiling:.1f} s, moves after {cold.moves:.1f} s")
    print(f"    it says: {cold.said}")
    print(f"  compiled: moves after {moves:.2f} s (median of {options.runs})")
    print(f"    it says: {warm[0].said}")
    met = compiling <= 30.0 and moves <= 3.0
    print(f"compiling <= 30 s and moving within 3 s: {'met' if met else 'MISSED'}")
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
