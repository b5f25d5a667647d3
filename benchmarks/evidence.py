"""The long suites behind the README's figures: seeded trials, each judged by the checker.

    python benchmarks/evidence.py [--suite NAME ...] [--worlds N] [--first SEED] [--variant V ...]
                                  [--workers W] [--keep DIR]

One line per trial, then the distributions and whether each bar is met. Exit code 1 if one is
missed. With `--keep` the scenario file of every trial that failed is left for `cavalcade run`.
"""

from __future__ import annotations

import os

# Before numpy and numba start their threads, here and in the workers.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from evidence_suites import SUITES
from evidence_trials import Outcome, carry_out

Job = tuple[str, str, int, Path | None]
"""Suite, variant, number of the trial, folder for the failed ones."""


def one(job: Job) -> Outcome:
    """One trial in a worker."""
    suite, variant, seed, keep = job
    return carry_out(SUITES[suite].trial(seed, variant), keep)


def outcomes_of(jobs: list[Job], workers: int) -> Iterator[Outcome]:
    """Their outcomes in order."""
    if workers < 2 or len(jobs) < 2:
        yield from map(one, jobs)
        return
    with ProcessPoolExecutor(min(workers, len(jobs)), mp_context=get_context("spawn")) as pool:
        yield from pool.map(one, jobs)


def judge(name: str, variant: str, options: argparse.Namespace) -> bool:
    """Carry out a suite with one variant; True if all its bars are met."""
    suite = SUITES[name]
    worlds = suite.worlds if options.worlds is None else options.worlds
    seeds = range(options.first, options.first + worlds)
    if suite.fixed:
        seeds = range(suite.worlds)[options.first : options.first + worlds]
    began = time.perf_counter()
    print(f"{name} ({variant}): {suite.about}; {len(seeds)} trials", flush=True)
    outcomes = []
    for outcome in outcomes_of(
        [(name, variant, seed, options.keep) for seed in seeds], options.workers
    ):
        print(outcome.line(), flush=True)
        outcomes.append(outcome)
    bars = suite.bars(outcomes)
    print(f"{name} ({variant}): {time.perf_counter() - began:.0f} s of wall time")
    for line in [*suite.describe(outcomes), *(bar.line() for bar in bars)]:
        print(line)
    print(flush=True)
    return all(bar.met for bar in bars)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--suite", nargs="+", choices=SUITES, help="default: all")
    parser.add_argument("--worlds", type=int, help="trials per suite (default: the suite's own)")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--variant", nargs="+", help="of the planner (default: the suite's own)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--keep", type=Path, help="folder for the scenarios of failed trials")
    options = parser.parse_args()
    met = []
    for name in options.suite or SUITES:
        if not SUITES[name].available():
            print(f"{name}: left out, because the maps it needs are not there\n")
            # Asked for by name, a suite must not pass unseen.
            met += [False] if options.suite else []
            continue
        for variant in options.variant or SUITES[name].variants:
            met.append(judge(name, variant, options))
    print(f"{sum(met)} of {len(met)} suites met all their bars")
    return 0 if all(met) else 1


if __name__ == "__main__":
    sys.exit(main())
