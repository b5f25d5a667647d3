"""The benchmarks of both sides in turns, and how their figures compare.

Each side runs its own copy: what is measured is what the benchmark says in its output (a time, or
a factor of real time), or the CPU seconds of the whole process where it says none. Noise of a
machine only ever adds time, so that the bar is on the best of all turns, as the mean of a
benchmark's figures; the median of the turns stands beside it.
"""

from __future__ import annotations

import re
import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from comparing.checkout import Checkout, Done

BAR = 0.97
"""The least ratio of old to new times."""

_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
CPU = "CPU seconds"


class FailedError(Exception):
    """A benchmark could not be run; the message says how it ended."""


@dataclass(frozen=True)
class Benchmark:
    """One benchmark, as a script of the folder `benchmarks` or a command of cavalcade.

    Attributes:
        name: Of the job.
        command: The script's name and arguments, or `cavalcade` and arguments.
        figures: Finds figures in the output: a regular expression with the groups `value` and
            any of `label`, `unit` and `factor` (a name; then more is better). None: CPU seconds.
        most: Repetitions at most, for those that take minutes.
        allowed: Exit codes of a benchmark that has run.
    """

    name: str
    command: tuple[str, ...]
    figures: str | None = None
    most: int = 100
    allowed: tuple[int, ...] = (0,)


@dataclass(frozen=True)
class Ratio:
    """How one figure compares: old to new time, by the best and by the median of all turns."""

    label: str
    best: float
    median: float
    old: float
    new: float

    def __str__(self) -> str:
        below = "" if self.best >= BAR else f"  below {BAR:g}"
        return (
            f"{self.label}: old/new {self.best:.3f} (best), {self.median:.3f} (median); "
            f"{self.old:.4g} s -> {self.new:.4g} s{below}"
        )


def overall(found: Sequence[Ratio]) -> float:
    """The benchmark's own ratio: the geometric mean of its figures' best."""
    return statistics.geometric_mean(ratio.best for ratio in found)


BENCHMARKS = (
    Benchmark(
        "cycle",
        ("bench_cycle.py", "--solves", "0"),
        r"^(?P<label>\d+ robots) .*?median (?P<value>[\d.]+) (?P<unit>ms)",
    ),
    Benchmark(
        "eikonal",
        ("bench_eikonal.py", "--quick"),
        r"^ *(?P<label>\d+ x +\d+), .*? cavalcade +(?P<value>[\d.]+) (?P<unit>ms)",
    ),
    Benchmark(
        "body",
        ("bench_body.py", "--quick"),
        r"^(?P<label>A [^:]*): (?P<value>[\d.]+) (?P<unit>us|ms)",
    ),
    Benchmark(
        "mpc",
        ("bench_mpc.py", "--problems", "60", "--turns", "5"),
        r"^(?P<label>\w+, \w+) +(?P<value>[\d.]+) +\(",
    ),
    Benchmark(
        "physics-plant",
        ("physics_plant.py", "--seconds", "1"),
        r"^\| (?P<label>\d+) \| (?P<factor>)(?P<value>\d+) \|$",
        most=3,
    ),
    Benchmark(
        "startup",
        ("bench_startup.py", "--runs", "5"),
        r"^ *(?P<label>compiled: moves) after (?P<value>[\d.]+) (?P<unit>s) ",
        most=2,
        allowed=(0, 1),
    ),
    Benchmark("start", ("cavalcade", "run", "triangle-lab", "--out", "run", "--quiet")),
    Benchmark(
        "campaign",
        ("cavalcade", "campaign", "smoke", "--out", "campaign", "--workers", "1", "--quiet"),
    ),
)


def pair_benchmark(benchmark: Benchmark, old: Checkout, new: Checkout, repeat: int) -> list[Ratio]:
    """Run it on both sides in turns, after one run each that warms the caches.

    Raises:
        FailedError: It has failed on one side, or says nothing to compare.
        StoppedError: Everything is to end.
    """
    runs: dict[str, list[dict[str, float]]] = {"old": [], "new": []}
    for turn in range(min(repeat, benchmark.most) + 1):
        # Each goes first in every second turn.
        for checkout in (old, new) if turn % 2 else (new, old):
            found = figures(benchmark, run_benchmark(benchmark, checkout))
            if turn:
                runs[checkout.name].append(found)
    return list(ratios(runs["old"], runs["new"]))


def run_benchmark(benchmark: Benchmark, checkout: Checkout) -> Done:
    """Run it once on one side.

    Raises:
        FailedError: It is not there or has failed.
    """
    program, *arguments = benchmark.command
    script = checkout.root / "benchmarks" / program
    if program == "cavalcade":
        command = ["-m", program, *arguments]
    elif script.is_file():
        command = [str(script), *arguments]
    else:
        raise FailedError(f"{checkout.name}: there is no benchmarks/{program}")
    with TemporaryDirectory(prefix="compare-") as folder:
        done = checkout.run(command, Path(folder))
    if done.code not in benchmark.allowed:
        last = (done.err.strip().splitlines() or ["no message"])[-1]
        raise FailedError(f"{checkout.name}: exit code {done.code}: {last}")
    return done


def figures(benchmark: Benchmark, done: Done) -> dict[str, float]:
    """Labels and seconds (or real time's share) of what it says; else its CPU seconds."""
    found: dict[str, float] = {}
    if benchmark.figures is not None:
        for match in re.finditer(benchmark.figures, done.out, re.MULTILINE):
            parts = match.groupdict()
            value = float(parts["value"])
            if parts.get("factor") is not None:
                value = 1.0 / value if value else float("inf")
            else:
                value *= _UNITS[parts.get("unit") or "µs"]
            found[" ".join(parts["label"].split())] = value
    return found or {CPU: done.cpu}


def ratios(
    old: Sequence[Mapping[str, float]], new: Sequence[Mapping[str, float]]
) -> Iterator[Ratio]:
    """How the figures of several turns compare.

    Raises:
        FailedError: The two sides name different figures.
    """
    labels = [list(dict.fromkeys(label for run in runs for label in run)) for runs in (old, new)]
    if set(labels[0]) != set(labels[1]):
        raise FailedError(f"figures of different names: {labels[0]} and {labels[1]}")
    for label in labels[0]:
        before, after = ([run[label] for run in runs if label in run] for runs in (old, new))
        yield Ratio(
            label=label,
            best=min(before) / min(after),
            median=statistics.median(before) / statistics.median(after),
            old=min(before),
            new=min(after),
        )
