"""One trial of the evidence: a scenario carried out, then judged by the independent checker."""

from __future__ import annotations

import shutil
import tempfile
import traceback
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from cavalcade.checking.report import Report
from cavalcade.errors import InputError
from cavalcade.running.frames import Recording
from cavalcade.scenario import Scenario, World
from cavalcade.world import MapWarning

CONTACT = ("robot-robot", "robot-obstacle", "robot-map")
"""The checker's kinds of violation that are collisions."""

REFUSED, CRASHED = "refused", "crashed"
"""Reasons beside those of `summary.json`: the scenario is bad input; an exception escaped."""


@dataclass(frozen=True)
class Trial:
    """What is to be run.

    Attributes:
        suite: Name of its suite.
        variant: Of the planner.
        name: Unique within suite and variant.
        seed: What its world was drawn from.
        feasible: A disc of 0.30 m radius gets from every start to every goal slot.
        make: Gives the scenario; left out of a trial that is only named.
    """

    suite: str
    variant: str
    name: str
    seed: int
    feasible: bool = True
    make: Callable[[], Scenario] | None = None


@dataclass(frozen=True)
class Finished:
    """A run as the suites measure it."""

    scenario: Scenario
    world: World
    recording: Recording
    summary: Mapping[str, Any]
    report: Report


@dataclass(frozen=True)
class Outcome:
    """What became of a trial.

    Attributes:
        trial: Which one, only named.
        reason: As in `summary.json`, `refused` or `crashed`.
        detail: One line.
        success: The run says so and the checker found nothing.
        violations: The checker's lines.
        contacts: How many of them are collisions.
        summary: What `summary.json` holds.
        figures: What the suite measured besides.
    """

    trial: Trial
    reason: str
    detail: str
    success: bool = False
    violations: tuple[str, ...] = ()
    contacts: int = 0
    summary: Mapping[str, Any] = field(default_factory=dict)
    figures: Mapping[str, Any] = field(default_factory=dict)

    @property
    def time(self) -> float:
        """Simulated seconds."""
        return float(self.summary.get("sim_time_s") or 0.0)

    def line(self) -> str:
        """One line for people."""
        trial = self.trial
        words = [f"{trial.suite}/{trial.variant} {trial.name}:"]
        words.append("ok" if self.success else f"FAILED {self.reason}")
        if not trial.feasible:
            words.append("(infeasible world)")
        if self.summary:
            error = self.summary["formation_error_m"]["mean"]
            words.append(
                f"t {self.time:.1f} s, error {_text(error)}, "
                f"obstacle {_text(self.summary['min_obstacle_distance_m'])}, "
                f"pair {_text(self.summary['min_robot_distance_m'])}, "
                f"gap {_text(self.summary['min_footprint_gap_m'])} m"
            )
        words += [f"| {name} {_text(value)}" for name, value in self.figures.items()]
        if self.detail:
            words.append(f"| {self.detail}")
        words += [f"| {violation}" for violation in self.violations[:3]]
        return " ".join(words)


def carry_out(trial: Trial, keep: Path | None) -> Outcome:
    """Run one trial and judge it. Whatever happens, an outcome comes back.

    Args:
        trial: Which one.
        keep: Folder for the scenario files of the trials that fail; None keeps nothing.
    """
    folder = Path(tempfile.mkdtemp(prefix="cavalcade-evidence-"))
    try:
        with warnings.catch_warnings():
            # What is said of a map's thresholds has been said to whoever chose the map.
            warnings.simplefilter("ignore", MapWarning)
            return _judged(trial, folder / "run", keep)
    except InputError as error:
        return Outcome(_named(trial), REFUSED, str(error))
    except Exception as error:  # a crash is a result of the suite, not its end
        where = traceback.extract_tb(error.__traceback__)[-1]
        text = f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
        return Outcome(_named(trial), CRASHED, text)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _judged(trial: Trial, out: Path, keep: Path | None) -> Outcome:
    from evidence_suites import SUITES

    from cavalcade.checking import check
    from cavalcade.running import run
    from cavalcade.scenario import build_world, resolve_scenario

    if trial.make is None:
        raise ValueError("the trial is only named")
    scenario = resolve_scenario(trial.make())
    try:
        result = run(scenario, out, figures=False, replay=False)
        report = check(out)
    except Exception:
        if keep is not None:
            _keep(trial, scenario, keep)
        raise
    done = Finished(scenario, build_world(scenario), result.recording, result.summary, report)
    success = result.success and report.ok
    outcome = Outcome(
        _named(trial),
        result.reason,
        str(result.summary["detail"] or ""),
        success,
        tuple(f"{v.time:.2f} s {v.kind}: {v.message}" for v in report.violations),
        sum(violation.kind in CONTACT for violation in report.violations),
        result.summary,
        SUITES[trial.suite].measure(trial, done),
    )
    if keep is not None and not success:
        _keep(trial, scenario, keep)
    return outcome


def _named(trial: Trial) -> Trial:
    """The trial without what makes its scenario, which cannot travel between processes."""
    return replace(trial, make=None)


def _keep(trial: Trial, scenario: Scenario, folder: Path) -> None:
    from cavalcade.scenario import dump_scenario

    folder.mkdir(parents=True, exist_ok=True)
    name = f"{trial.suite}-{trial.variant}-{trial.name}".replace(" ", "-")
    dump_scenario(scenario, folder / f"{name}.yaml")


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3f}"
    return "-" if value is None else str(value)
