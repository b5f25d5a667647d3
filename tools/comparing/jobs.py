"""What is run on both sides: names, commands, and the differences of what they leave."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from comparing.checkout import Checkout
from comparing.folders import SAID, Difference, Side, compare_folders
from comparing.worlds import write_worlds

GROUPS = ("scenarios", "plans", "physics", "smoke", "worlds", "benchmarks")
PHYSICS = ("cone", "head-on", "gap")
"""Shipped scenarios that are walked by Go1s in physics."""

SMOKE = {"smoke": "clutter.0000.cavalcade", "smoke-plans": "pairs.0000.auto"}
"""Suites, and the trial of each that is repeated."""


@dataclass(frozen=True)
class Job:
    """Commands of cavalcade that both sides run, one after the other.

    Attributes:
        name: Its group and what it is, such as `scenarios/cone`.
        commands: Each a name for what it says, and the arguments; they run in the job's folder.
    """

    name: str
    commands: tuple[tuple[str, tuple[str, ...]], ...]

    def compare(self, old: Checkout, new: Checkout, out: Path) -> list[Difference]:
        """Run it on both sides and give what differs.

        Raises:
            StoppedError: Everything is to end.
        """
        sides = []
        for checkout in (old, new):
            folder = out / self.name / checkout.name
            folder.mkdir(parents=True)
            for name, arguments in self.commands:
                checkout.cavalcade(arguments, folder, name)
            # The job's own folder first: both sides' results have the same name.
            places = ((folder, "<job>"), (out, "<out>"), (checkout.root, "<checkout>"))
            sides.append(Side(folder, places))
        return compare_folders(*sides)

    def ended(self, out: Path) -> str:
        """The exit codes of the new side's commands, as one text."""
        files = (out / self.name / "new" / f"{name}{SAID}" for name, _ in self.commands)
        codes = [json.loads(file.read_text(encoding="utf-8"))["exit_code"] for file in files]
        return ", ".join(str(code) for code in codes)


def make_jobs(
    groups: Sequence[str], shipped: Sequence[str], out: Path, worlds: int, seed: int
) -> list[Job]:
    """All jobs of these groups but the benchmarks.

    Args:
        groups: Some of `GROUPS`.
        shipped: Names of the shipped scenarios.
        out: Where the generated worlds are written.
        worlds: How many of them.
        seed: Theirs.
    """
    jobs = []
    if "scenarios" in groups:
        jobs += [Job(f"scenarios/{name}", _run(name)) for name in shipped]
    if "plans" in groups:
        # Formations are refused by `plan`; that they are, and how, is compared as well.
        jobs += [Job(f"plans/{name}", _run(name, "plan")) for name in shipped]
    if "physics" in groups:
        options = ("--set", "robots.*.model=go1", "--backend", "mujoco")
        jobs += [Job(f"physics/{name}", _run(name, "run", options)) for name in PHYSICS]
    if "smoke" in groups:
        jobs += [Job(f"smoke/{suite}", _campaign(suite, SMOKE[suite])) for suite in SMOKE]
    if "worlds" in groups:
        for number, file in enumerate(write_worlds(out / "inputs", worlds, seed)):
            planned = "formation" not in file.stem and number % 3 == 1
            commands = _run(str(file), "plan" if planned else "run")
            jobs.append(Job(f"worlds/{file.stem}", commands))
    return jobs


def _run(scenario: str, command: str = "run", options: tuple[str, ...] = ()) -> tuple:
    arguments = (command, scenario, "--out", command, "--quiet", "--force", *options)
    return ((command, arguments), ("check", ("check", command, "--json")))


def _campaign(suite: str, trial: str) -> tuple:
    return (
        ("campaign", ("campaign", suite, "--out", "campaign", "--workers", "1", "--quiet")),
        ("trial", ("trial", "campaign", trial, "--out", "trial", "--quiet", "--force")),
    )
