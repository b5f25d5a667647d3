"""Carrying one trial out, in a worker. Whatever happens, a line comes back.

What a run needs is imported when one begins: the campaign's own process only names these
functions to its workers.
"""

from __future__ import annotations

import traceback
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cavalcade.campaign.samplers import Instance
from cavalcade.campaign.trial import CRASHED, REFUSED, UNKNOWN, Line, Trial, failure_line
from cavalcade.errors import InputError, OutputError

if TYPE_CHECKING:
    from cavalcade.campaign.judging import Verdict
    from cavalcade.jobs import JobResult
    from cavalcade.scenario import Scenario


def run_trial(trial: Trial) -> Line:
    """Run one trial in memory and judge it."""
    return run_trial_into(trial, None)[0]


def replay(trial: Trial) -> JobResult | None:
    """The trial's run or plan again, in memory; None without a run."""
    return run_trial_into(trial, None)[1]


def lost_line(trial: Trial, outcome: str, detail: str) -> Line:
    """The line of a trial that never came back; its world is sampled, but not run."""
    known = _Known(trial)
    try:
        known.sample()
    except Exception as error:
        detail = f"{detail}; the world cannot be drawn: {_told(error)}"
    return known.line(outcome, detail)


def run_trial_into(
    trial: Trial, out: Path | None, *, force: bool = False, quiet: bool = True
) -> tuple[Line, JobResult | None]:
    """Run one trial and judge it; recording, figures and replay go to `out`, if there is one.

    Returns:
        The trial's line, and the run unless there was none.

    Raises:
        OutputError, OSError: `out` cannot be written.
    """
    from cavalcade.scenario import ScenarioWarning
    from cavalcade.world import MapWarning

    known = _Known(trial)
    try:
        with warnings.catch_warnings():
            # What is said of a map's thresholds has been said to whoever chose the map, and
            # variants are compared on scenarios that not all of them make something of.
            warnings.simplefilter("ignore", MapWarning)
            warnings.simplefilter("ignore", ScenarioWarning)
            if trial.sampler.individual_goals and trial.backend != "mujoco":
                return _planned(known, out, force, quiet)
            return _carried_out(known, out, force, quiet)
    except InputError as error:
        return known.line(REFUSED, str(error)), None
    except OutputError:
        raise
    except Exception as error:  # a crash is a result of the campaign, not its end
        if out is not None and isinstance(error, OSError):
            raise
        return known.line(CRASHED, _told(error)), None


@dataclass
class _Known:
    """What is known of a trial so far."""

    trial: Trial
    instance: Instance = UNKNOWN

    def sample(self) -> Scenario:
        self.instance = self.trial.instance()
        return self.trial.scenario(self.instance)

    def line(self, outcome: str, detail: str) -> Line:
        return failure_line(self.trial, outcome, detail, self.instance)

    def judged(self, verdict: Verdict, measured: Mapping[str, Any], result: JobResult) -> Line:
        return self.line(verdict.outcome, verdict.detail) | {
            "success": verdict.success,
            "contacts": verdict.contacts,
            "avoidable": verdict.avoidable,
            "violations": list(verdict.violations),
            "measured": dict(measured),
            "summary": result.summary.to_dict(),
        }


def _carried_out(
    known: _Known, out: Path | None, force: bool, quiet: bool
) -> tuple[Line, JobResult]:
    from cavalcade.campaign.judging import crossings, judged, time_ratio
    from cavalcade.jobs.running import run

    result = run(known.sample(), out, force=force, quiet=quiet)
    scenario, summary, recording = result.scenario, result.summary, result.recording
    if recording is None:  # a run always has one
        raise RuntimeError("a run without a recording")
    verdict = judged(scenario, result.world, recording, summary)
    measured = {"time_ratio": time_ratio(scenario, summary), **crossings(scenario, recording)}
    return known.judged(verdict, measured, result), result


def _planned(known: _Known, out: Path | None, force: bool, quiet: bool) -> tuple[Line, JobResult]:
    from cavalcade.campaign.judging import judged_plan, measured_plan
    from cavalcade.jobs import plan

    scenario = known.sample()
    result = plan(scenario, out, force=force, quiet=quiet)
    verdict = judged_plan(result, known.instance.expected)
    return known.judged(verdict, measured_plan(result), result), result


def _told(error: BaseException) -> str:
    """An exception in a few words, without the folders of where it was raised."""
    where = traceback.extract_tb(error.__traceback__)[-1]
    said = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    return f"{said} ({Path(where.filename).name}:{where.lineno})"
