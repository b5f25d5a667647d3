"""A whole campaign: from its definition to a folder of lines and a report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cavalcade.campaign.definition import Definition
from cavalcade.campaign.dispatch import dispatch, in_turns
from cavalcade.campaign.engines.protocol import Engine, Work
from cavalcade.campaign.progress import CampaignReporter
from cavalcade.campaign.samplers import EXPECTED
from cavalcade.campaign.store import Store
from cavalcade.campaign.trial import Line
from cavalcade.campaign.trial_runner import replay, run_trial
from cavalcade.campaign.warming import needs_of_all, warm_all
from cavalcade.jobs.reporter import Reporter


class CampaignInterrupted(KeyboardInterrupt):
    """Ctrl-C; of `total` trials the finished ones, `done`, are kept."""

    def __init__(self, done: int, total: int) -> None:
        super().__init__()
        self.done, self.total = done, total


@dataclass(frozen=True)
class CampaignResult:
    """Counts over all trials, as plain data, and what was written, in a reader's order."""

    summary: dict[str, Any]
    files: tuple[Path, ...]


def run_campaign(
    definition: Definition,
    out: str | Path,
    engine: Engine,
    *,
    resume: bool = False,
    quiet: bool = True,
    work: Work = run_trial,
    command: str = "",
) -> CampaignResult:
    """Carry out what is not done yet of a campaign, and write the report.

    Args:
        definition: Checked, its data there.
        out: The campaign's folder.
        engine: Not started; it is not started if nothing is left to do.
        resume: Go on with what `out` holds.
        quiet: Print nothing but warnings.
        command: That was given, for the report.

    Raises:
        OutputError: The folder cannot be used or written; all finished trials are kept.
        CampaignInterrupted: Ctrl-C.
    """
    from cavalcade.campaign.report import write_report

    warnings: list[str] = []
    with Store(out, definition, resume=resume, warn=warnings.append) as store:
        left = in_turns([trial for trial in definition.trials if trial.id not in store.done])
        total, name = len(definition.trials), definition.suite.name
        needs = needs_of_all(left) if work is run_trial else ()
        reporter = CampaignReporter(name, total, total - len(left), quiet=quiet)
        for text in warnings:
            reporter.warn(text)
        try:
            with Reporter(quiet) as before:
                warm_all(needs, before)
            with reporter:
                if left:
                    with engine:
                        for line in dispatch(
                            engine,
                            left,
                            definition.suite.time_limit,
                            work=work,
                            prepare=(warm_all, (needs,)) if needs else None,
                            tick=reporter.tick,
                        ):
                            store.append(line)
                            reporter.finished(line)
                reporter.close()
                reporter.say("writing the report ...")
                lines = store.lines()
                files = write_report(
                    store.folder,
                    definition.suite,
                    lines,
                    command=command,
                    replay=lambda line: replay(definition.trial(line["trial"])),
                )
        except KeyboardInterrupt:
            raise CampaignInterrupted(store.count(), total) from None
    return CampaignResult(_summary(definition, lines), files)


def _summary(definition: Definition, lines: Sequence[Line]) -> dict[str, Any]:
    feasible = [line for line in lines if line["feasible"]]
    groups: dict[tuple[str, str, str], list[Line]] = {}
    for line in lines:
        key = (line["scenario"], line["disturbance"], line["variant"])
        groups.setdefault(key, []).append(line)
    return {
        "suite": definition.suite.name,
        "fingerprint": definition.fingerprint,
        "trials": len(lines),
        "feasible": len(feasible),
        "success": sum(line["success"] for line in lines),
        "success_of_feasible": sum(line["success"] for line in feasible),
        "outcomes": dict(Counter(line["outcome"] for line in lines).most_common()),
        "contacts": sum(line["contacts"] for line in lines),
        "avoidable": sum(line["avoidable"] for line in lines),
        "groups": [
            {
                "scenario": scenario,
                "disturbance": disturbance,
                "variant": variant,
                "trials": len(members),
                "hopeless": sum(line["expected"] in EXPECTED for line in members),
                "refused": sum(line["success"] for line in members if line["expected"] in EXPECTED),
                "feasible": sum(line["feasible"] for line in members),
                "success_of_feasible": sum(line["success"] for line in members if line["feasible"]),
                "contacts": sum(line["contacts"] for line in members),
                "avoidable": sum(line["avoidable"] for line in members),
            }
            for (scenario, disturbance, variant), members in groups.items()
        ],
    }
