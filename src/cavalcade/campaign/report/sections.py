"""The report's parts, in a reader's order."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence

from cavalcade.campaign.report.blocks import (
    Block,
    Bullets,
    Command,
    Drawn,
    Figure,
    Heading,
    Table,
    Text,
    code,
    plain,
)
from cavalcade.campaign.report.comparisons import ALL
from cavalcade.campaign.report.tables import cell_names
from cavalcade.campaign.report.trials import Order, Trial
from cavalcade.campaign.report.verdict import Cell, in_order
from cavalcade.campaign.report.wording import bound, count, interval, number, share
from cavalcade.campaign.report.worst import Worst, bound_of, is_failure
from cavalcade.campaign.scrubbing import scrubbed

_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w)")

MOST_SENTENCES = 8
MOST_EXAMPLES = 5


def header(
    name: str, about: str, trials: Sequence[Trial], order: Order, command: str
) -> list[Block]:
    """What was run, how often, with which versions, and the command."""
    worlds = len({trial.world for trial in trials})
    factors = [f"{count(worlds)} worlds"]
    if len(order.disturbances) > 1:
        factors.append(f"{len(order.disturbances)} disturbances")
    if len(order.variants) > 1:
        factors.append(f"{len(order.variants)} variants")
    facts = [f"**Trials:** {count(len(trials))} ({' × '.join(factors)})"]
    if order.variants:
        facts.append(f"**Variants:** {', '.join(code(name) for name in order.variants)}")
    if len(order.disturbances) > 1:
        facts.append(f"**Disturbances:** {', '.join(code(name) for name in order.disturbances)}")
    facts.append(f"**Versions:** {_versions(trials)}")
    blocks: list[Block] = [Heading(f"Campaign {code(name)}", 1)]
    if about:
        blocks.append(Text(plain(about)))
    blocks.append(Bullets(tuple(facts)))
    if command:
        blocks += [Text("Made by"), Command(scrubbed(command))]
    return blocks


def _versions(trials: Sequence[Trial]) -> str:
    found: dict[str, set[str]] = {}
    for trial in trials:
        versions = trial.summary.get("versions")
        if isinstance(versions, Mapping):
            for package, version in versions.items():
                found.setdefault(str(package), set()).add(str(version))
    if not found:
        return "not recorded, no trial ran"
    names = sorted(
        found, key=lambda package: (package != "cavalcade", package != "python", package)
    )
    return ", ".join(f"{name} {' and '.join(sorted(found[name]))}" for name in names)


def sentences(cells: Sequence[Cell], order: Order) -> list[Block]:
    """The verdict in a sentence per cell, where they are few."""
    if not cells:
        return [Text("No trial has finished.")]
    told = cells if len(cells) <= MOST_SENTENCES else _over_scenarios(cells, order)
    if len(told) > MOST_SENTENCES:
        return []
    return [Bullets(tuple(_sentence(cell, order) for cell in told))]


def _over_scenarios(cells: Sequence[Cell], order: Order) -> list[Cell]:
    """One cell per disturbance and variant, with the trials of all scenarios."""
    found = []
    for disturbance in order.disturbances:
        for variant in order.variants:
            same = [
                trial
                for cell in cells
                if (cell.disturbance, cell.variant) == (disturbance, variant)
                for trial in cell.trials
            ]
            if same:
                found.append(Cell(ALL, variant, disturbance, tuple(same)))
    return found


def _sentence(cell: Cell, order: Order) -> str:
    name = ", ".join(cell_names(cell, order))
    feasible, done = len(cell.feasible), cell.feasible_successes
    what = "feasible problems solved" if cell.planned else "feasible worlds crossed"
    if cell.commanded:
        what = "tasks done"
    if feasible:
        text = (
            f"{count(done)} of {count(feasible)} {what}: "
            f"**{share(done, feasible)}** {interval(cell.interval, feasible)}"
        )
    else:
        text = "no feasible world"
    if not cell.run:
        return f"{name}: {text}; no trial ran."
    if cell.hit:
        hits = f"**{count(cell.hit)} with an avoidable collision** in {count(len(cell.run))} trials"
    else:
        hits = f"no avoidable collision in {count(len(cell.run))} trials"
    return f"{name}: {text}; {hits} (95 % bound {bound(cell.hit_bound, len(cell.run))})."


def failures(trials: Sequence[Trial], order: Order) -> list[Block]:
    """Failures that need not have been, by reason, with examples."""
    failed = [trial for trial in order.sorted(trials) if is_failure(trial)]
    hopeless = sum(
        not trial.success and not trial.feasible and not trial.hopeless for trial in trials
    )
    blocks: list[Block] = [Heading("Failures by reason")]
    if hopeless:
        noun = "trial" if hopeless == 1 else "trials"
        blocks.append(
            Text(f"{count(hopeless)} {noun} in worlds that are not feasible failed as expected.")
        )
    if not failed:
        return [*blocks, Text("No trial in a feasible world failed." if trials else "No trials.")]
    rows = []
    for outcome in in_order(Counter(trial.outcome for trial in failed)):
        same = [trial for trial in failed if trial.outcome == outcome]
        for detail, group in _by_detail(same):
            rows.append((outcome, plain(detail) or "–", count(len(group)), _some(group)))
    table = Table(("reason", "detail", "trials", "which"), tuple(rows), left=2, words=(3,))
    return [*blocks, table]


def unavoidable(trials: Sequence[Trial], order: Order) -> list[Block]:
    """Collisions that are not held against the planner, by reason, with examples."""
    touched = [trial for trial in order.sorted(trials) if trial.contacts > trial.avoidable]
    if not touched:
        return []
    counted = sum(trial.contacts - trial.avoidable for trial in touched)
    noun = "trial" if len(touched) == 1 else "trials"
    rows = [
        (plain(detail) or "–", count(len(group)), _some(group))
        for detail, group in _by_detail(touched)
    ]
    return [
        Heading("Collisions that could not be avoided"),
        Text(
            f"{count(counted)} in {count(len(touched))} {noun}. Such a trial ends as `collision`, "
            "yet it is a success if the team then arrived."
        ),
        Table(("why", "trials", "which"), tuple(rows), left=1, words=(2,)),
    ]


def _some(trials: Sequence[Trial]) -> str:
    """The names of the first few."""
    shown = ", ".join(code(trial.name) for trial in trials[:MOST_EXAMPLES])
    more = len(trials) - MOST_EXAMPLES
    return shown + (f" and {count(more)} more" if more > 0 else "")


def _by_detail(trials: Sequence[Trial]) -> list[tuple[str, list[Trial]]]:
    """Groups of the same detail but for its numbers, the largest first."""
    groups: dict[str, list[tuple[str, Trial]]] = {}
    for trial in trials:
        groups.setdefault(_without_numbers(trial.said), []).append((trial.said, trial))
    named = []
    for common, members in groups.items():
        texts = {text for text, _ in members}
        named.append((texts.pop() if len(texts) == 1 else common, [trial for _, trial in members]))
    return sorted(named, key=lambda item: (-len(item[1]), item[0]))


def _without_numbers(text: str) -> str:
    return _NUMBER.sub("…", text)


def worst(
    chosen: Sequence[Worst], pictures: Mapping[str, Drawn], remarks: Mapping[str, str]
) -> list[Block]:
    """Each with its command and, where there is one, its picture."""
    if not chosen:
        return []
    blocks: list[Block] = [
        Heading("Worst trials"),
        Text(
            "Failures first, then the smallest gap, then the longest time. Each command, given in "
            "this folder, repeats its trial bit for bit and leaves recording or plan, figures and "
            "replay."
        ),
    ]
    for item in chosen:
        trial = item.trial
        blocks += [
            Heading(code(trial.name), 3),
            Text(f"{_capital(plain(item.why))}. {_facts(trial)}"),
            Command(repeat_command(trial.name)),
        ]
        if trial.name in remarks:
            blocks.append(Text(plain(remarks[trial.name]), small=True))
        if trial.name in pictures:
            caption = f"{code(trial.name)}: the plan."
            if not trial.planned:
                caption = (
                    f"{code(trial.name)}: ways driven, bodies at the start (white) and at the end "
                    "(coloured), goals; the ring marks the tightest place, outlines and moving "
                    "obstacles are as they were then."
                )
            blocks.append(Figure(pictures[trial.name], caption))
    return blocks


def repeat_command(name: str) -> str:
    """What repeats a trial, given in the campaign's folder."""
    return f"cavalcade trial . {name} --out worst/{name}"


def _facts(trial: Trial) -> str:
    parts = [] if trial.feasible or trial.hopeless else ["the world is not feasible"]
    if trial.level is not None:
        name = trial.level_name or "level"
        parts.append(f"{trial.level:g} {name}" if name.endswith("s") else f"{name} {trial.level:g}")
    if trial.number("sim_time_s") is not None:
        parts.append(f"{number(trial.number('sim_time_s'), 1)} s simulated")
    if trial.planned and trial.number("makespan_s") is not None:
        parts.append(f"makespan {number(trial.number('makespan_s'), 1)} s")
    if trial.time_ratio is not None:
        parts.append(f"{number(trial.time_ratio)} times {bound_of(trial)}")
    if trial.length_ratio is not None:
        parts.append(f"{number(trial.length_ratio, 3)} times the shortest ways")
    if trial.planned and trial.number("planning_time_s") is not None:
        parts.append(f"planned in {number(trial.number('planning_time_s'), 3)} s")
    if trial.gap is not None:
        parts.append(f"smallest gap {number(trial.gap, 3)} m")
    if trial.contacts:
        why = f" ({plain(trial.said)})" if trial.success and trial.said else ""
        parts.append(f"contacts {trial.contacts}, avoidable {trial.avoidable}{why}")
    text = ", ".join(parts)
    return f"{_capital(text)}." if text else ""


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
