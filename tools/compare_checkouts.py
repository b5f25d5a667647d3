"""Whether two checkouts do the same, byte for byte, and whether the new one is as fast.

Both are driven over the command line, each with its own source; nothing of either is imported.
What they leave is compared: exit codes, messages, scenarios, summaries, plans, recordings,
campaigns' tables. What may differ on purpose stands in `comparing/intended.py`.

    python tools/compare_checkouts.py OLD NEW [--only 'worlds/*'] [--groups scenarios,plans]

Exit codes: 0 all equal and all bars hold, 1 not so, 2 cannot be run.
"""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import ExitStack
from fnmatch import fnmatchcase
from pathlib import Path

from comparing.benchmarks import BAR, BENCHMARKS, FailedError, overall, pair_benchmark
from comparing.checkout import Checkout, Processes, StoppedError, UnusableError
from comparing.folders import Difference
from comparing.jobs import GROUPS, make_jobs

EQUAL, DIFFERENT, SLOWER, FAILED = STATES = ("equal", "different", "slower", "failed")
Answer = tuple[str, list[str]]
"""How a job ended and the lines that say more."""


def main() -> int:
    """Compare as the command line says; the exit code."""
    options = _options()
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _interrupt)
    processes = Processes()
    with ExitStack() as stack:
        if options.out is None:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="compare-"))
            out = Path(folder).resolve()
        else:
            out = options.out.resolve()
            if out.exists() and (not out.is_dir() or any(out.iterdir())):
                return _refuse(f"{options.out}: expected a missing or empty folder")
            out.mkdir(parents=True, exist_ok=True)
        # Left before the folder, so that no process writes there any more.
        stack.callback(processes.stop)
        sides = []
        for name in ("old", "new"):
            root = getattr(options, name).resolve()
            python = getattr(options, f"python_{name}") or root / ".venv/bin/python"
            sides.append(Checkout(name, root, python.absolute(), processes, options.limit))
        try:
            for side in sides:
                side.check(out)
            tasks = _tasks(options, sides[0], sides[1], out)
        except UnusableError as error:
            return _refuse(str(error))
        if not tasks:
            return _refuse("there is no such job; expected some of --groups and --only")
        if options.list:
            print("\n".join(tasks))
            return 0
        return _carry_out(tasks, options.jobs)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("old", type=Path, metavar="OLD", help="a checkout, the reference")
    parser.add_argument("new", type=Path, metavar="NEW", help="a checkout")
    parser.add_argument("--python-old", type=Path, help="OLD's Python, else OLD/.venv/bin/python")
    parser.add_argument("--python-new", type=Path, help="NEW's Python, else NEW/.venv/bin/python")
    parser.add_argument(
        "--groups", default=",".join(GROUPS), help="some of %(default)s, with commas"
    )
    parser.add_argument("--only", metavar="GLOB", default="*", help="jobs of such names")
    parser.add_argument("--list", action="store_true", help="name the jobs and do nothing")
    parser.add_argument("--worlds", type=int, default=38, metavar="N", help="generated worlds")
    parser.add_argument("--seed", type=int, default=0, help="of the generated worlds")
    parser.add_argument("--repeat", type=int, default=5, help="turns of each benchmark")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="jobs side by side")
    parser.add_argument("--limit", type=float, default=3600.0, help="s of one command, wall time")
    parser.add_argument("--out", type=Path, metavar="DIR", help="keep all folders there")
    options = parser.parse_args()
    options.groups = [group for group in options.groups.split(",") if group]
    for group in options.groups:
        if group not in GROUPS:
            parser.error(f"--groups: {group}: expected some of {', '.join(GROUPS)}")
    return options


def _tasks(
    options: argparse.Namespace, old: Checkout, new: Checkout, out: Path
) -> dict[str, Callable[[], Answer]]:
    """Names and work of all that is asked for, in order; benchmarks come last."""
    shipped = _shipped(old, out) if {"scenarios", "plans"} & set(options.groups) else []
    jobs = make_jobs(options.groups, shipped, out, options.worlds, options.seed)
    tasks: dict[str, Callable[[], Answer]] = {}
    for job in jobs:

        def compare(job=job) -> Answer:
            found = job.compare(old, new, out)
            if found:
                return DIFFERENT, _first_of_each_file(found)
            return EQUAL, [f"exit codes {job.ended(out)}"]

        tasks[job.name] = compare
    for benchmark in BENCHMARKS if "benchmarks" in options.groups else ():

        def pair(benchmark=benchmark) -> Answer:
            try:
                found = pair_benchmark(benchmark, old, new, options.repeat)
            except FailedError as error:
                return FAILED, [str(error)]
            ratio = overall(found)
            lines = [f"old/new {ratio:.3f}, at least {BAR:g} wanted", *map(str, found)]
            return EQUAL if ratio >= BAR else SLOWER, lines

        tasks[f"benchmarks/{benchmark.name}"] = pair
    return {name: task for name, task in tasks.items() if fnmatchcase(name, options.only)}


def _first_of_each_file(found: list[Difference]) -> list[str]:
    counts = Counter(difference.file for difference in found)
    firsts = {difference.file: difference for difference in reversed(found)}
    return [
        f"{firsts[file]}" + (f" (and {counts[file] - 1} more)" if counts[file] > 1 else "")
        for file in counts
    ]


def _shipped(checkout: Checkout, out: Path) -> list[str]:
    done = checkout.run(["-m", "cavalcade", "scenarios"], out)
    if done.code:
        raise UnusableError(f"{checkout.root}: cavalcade scenarios: exit code {done.code}")
    return [line.split()[0] for line in done.out.splitlines() if line.strip()]


def _carry_out(tasks: dict[str, Callable[[], Answer]], side_by_side: int) -> int:
    """Do it all, a line for each; benchmarks one at a time, after everything else."""
    counts: Counter[str] = Counter()
    alone = [name for name in tasks if name.startswith("benchmarks/")]
    together = [name for name in tasks if name not in alone]
    for names, workers in ((together, side_by_side), (alone, 1)):
        pool = ThreadPoolExecutor(max(workers, 1))
        try:
            pending = {pool.submit(_timed, tasks[name]): name for name in names}
            while pending:
                for future in wait(pending, return_when=FIRST_COMPLETED).done:
                    (state, lines), seconds = future.result()
                    counts[state] += 1
                    _say(pending.pop(future), state, lines, seconds)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        pool.shutdown()
    print(f"{len(tasks)} jobs: " + ", ".join(f"{counts[s]} {s}" for s in STATES))
    return 0 if counts[EQUAL] == len(tasks) else 1


def _timed(task: Callable[[], Answer]) -> tuple[Answer, float]:
    began = time.perf_counter()
    try:
        answer = task()
    except StoppedError:
        raise
    except Exception as error:  # an unreadable file is a finding, and not the end of all jobs
        answer = (FAILED, [f"{type(error).__name__}: {error}"])
    return answer, time.perf_counter() - began


def _say(name: str, state: str, lines: list[str], seconds: float) -> None:
    first, *rest = lines or [""]
    print(f"{state:9s} {name} ({seconds:.0f} s): {first}", flush=True)
    for line in rest:
        print(f"{'':9s}   {line}", flush=True)


def _refuse(message: str) -> int:
    print(f"compare_checkouts: {message}", file=sys.stderr)
    return 2


def _interrupt(number: int, frame: object) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (KeyboardInterrupt, StoppedError):
        sys.exit(130)
