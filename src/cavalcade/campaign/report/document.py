"""What the report says, as values that its templates lay out."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, get_args

from cavalcade.campaign.report import charts, tables
from cavalcade.campaign.report.canvas import MOST_ROWS, Artist, Figure
from cavalcade.campaign.report.cells import Cell, cells_of, curves_of, in_order
from cavalcade.campaign.report.comparisons import (
    Comparison,
    Factor,
    compare,
    comparison_tables,
    references_of,
)
from cavalcade.campaign.report.tables import Table, cell_names, cell_table
from cavalcade.campaign.report.trials import Order, Trial, TrialTable
from cavalcade.campaign.report.wording import bound, code, count, interval, plain, share
from cavalcade.campaign.report.worst import Replay, shown_worst
from cavalcade.campaign.table import scrubbed

if TYPE_CHECKING:
    from cavalcade.campaign.suite import Suite

MOST_SENTENCES = 8
MOST_EXAMPLES = 5

_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w)")


def document(
    suite: Suite,
    table: TrialTable,
    lines: Mapping[str, Mapping[str, Any]],
    command: str,
    artist: Artist,
    replay: Replay | None,
) -> dict[str, Any]:
    """The variables of the templates; pictures are drawn on the way.

    Arguments as of `write_report`; `lines` are given by their trials' names.

    Raises:
        OutputError: A picture cannot be written.
    """
    order = table.order
    cells = cells_of(table, "NOT unsolvable")
    refused = cells_of(table, "unsolvable")
    formations = [cell for cell in cells if not cell.planned and not cell.commanded]
    planned = [cell for cell in cells if cell.planned]
    commanded = [cell for cell in cells if cell.commanded]
    walked = [cell for cell in cells if cell.in_physics]
    judged = cells if any(cell.ran for cell in cells) else []
    query = """
        SELECT count(*), bool_or(NOT planned AND NOT commanded), bool_or(planned),
            bool_or(commanded), bool_or(in_physics)
        FROM trials
    """
    kinds = ("trials", "any_formation", "any_planned", "any_commanded", "any_physics")
    excused = table.trials("contacts > avoidable")
    return {
        "suite": suite.suite,
        "about": plain(suite.about),
        "facts": _facts(table),
        "command": scrubbed(command),
        "sentences": _sentences(table, cells),
        "success": cell_table(cells, order, tables.SUCCESS, every=True),
        "success_charts": artist.charts(
            "Success in feasible worlds with 95 % interval, and how the failures ended.",
            charts.draw_success,
            cells,
            "success",
        ),
        "outcomes": cell_table(cells, order, tables.outcome_columns(cells), every=True),
        "excused_outcomes": any(cell.excused for cell in cells),
        "paper": tables.paper_table(planned),
        "formations": cell_table(formations, order, tables.FORMATION),
        "plans": cell_table(planned, order, tables.PLAN),
        "commanded": cell_table(commanded, order, tables.COMMANDED),
        "physics": cell_table(walked, order, tables.PHYSICS),
        "refusals": tables.refusal_table(refused, order),
        "spread_charts": _spread_charts(judged, artist),
        "clearances": cell_table(judged, order, tables.CLEARANCE),
        "comparisons": [
            _comparisons(table, factor, found, artist)
            for factor in get_args(Factor)
            if (found := compare(table, factor))
        ],
        "curves": _curves(table, cells, artist),
        "failures": _failure_table(table.failures()),
        "excused_failures": len(table.trials("NOT success AND NOT feasible AND NOT unsolvable")),
        "unavoidable": Table(("why", "trials", "which"), _by_reason(excused), 1, last=True),
        "unavoidable_trials": len(excused),
        "unavoidable_contacts": sum(trial.contacts - trial.avoidable for trial in excused),
        "worst": shown_worst(table, lines, artist, replay),
        "disturbed": len(order.disturbances) > 1,
        **dict(zip(kinds, table.rows(query)[0], strict=True)),
    }


def _facts(table: TrialTable) -> list[str]:
    """What was run, how often, and with which versions."""
    order = table.order
    ((trials, worlds),) = table.rows(
        "SELECT count(*), count(DISTINCT (scenario, seed)) FROM trials"
    )
    factors = [f"{count(worlds)} worlds"]
    factors += [f"{len(getattr(order, f'{part}s'))} {part}s" for part in order.parts[1:]]
    facts = [f"**Trials:** {count(trials)} ({' × '.join(factors)})"]
    if order.variants:
        facts.append(f"**Variants:** {', '.join(code(name) for name in order.variants)}")
    if len(order.disturbances) > 1:
        facts.append(f"**Disturbances:** {', '.join(code(name) for name in order.disturbances)}")
    versions = [f"{name} {' and '.join(found)}" for name, found in table.versions()]
    facts.append(f"**Versions:** {', '.join(versions) or 'not recorded, no trial ran'}")
    return facts


def _sentences(table: TrialTable, cells: Sequence[Cell]) -> list[str]:
    """The verdict in a sentence per cell or, where they are many, over all scenarios."""
    told = list(cells)
    if len(cells) > MOST_SENTENCES:
        told = cells_of(table, "NOT unsolvable", over_scenarios=True)
    if len(told) > MOST_SENTENCES:
        return []
    return [_sentence(cell, table.order) for cell in told]


def _sentence(cell: Cell, order: Order) -> str:
    name = ", ".join(cell_names(cell, order))
    what = "feasible problems solved" if cell.planned else "feasible worlds crossed"
    if cell.commanded:
        what = "tasks done"
    if cell.feasible:
        text = (
            f"{count(cell.feasible_successes)} of {count(cell.feasible)} {what}: "
            f"**{share(cell.feasible_successes, cell.feasible)}** "
            f"{interval(cell.interval, cell.feasible)}"
        )
    else:
        text = "no feasible world"
    if not cell.ran:
        return f"{name}: {text}; no trial ran."
    hits = f"no avoidable collision in {count(cell.ran)} trials"
    if cell.hit:
        hits = f"**{count(cell.hit)} with an avoidable collision** in {count(cell.ran)} trials"
    return f"{name}: {text}; {hits} (95 % bound {bound(cell.hit_bound, cell.ran)})."


def _spread_charts(cells: Sequence[Cell], artist: Artist) -> list[Figure]:
    caption = "Median (mark), quartiles (bar) and 5 % to 95 % (line) over single trials."
    figures: list[Figure] = []
    for planned in (False, True):
        alike = [c for c in cells if c.planned == planned and not c.commanded]
        name = "spread-plans" if planned and len(alike) < len(cells) else "spread"
        figures += artist.charts(caption, charts.draw_spreads, alike, name)
    return figures


def _comparisons(
    table: TrialTable, factor: Factor, found: Sequence[Comparison], artist: Artist
) -> dict[str, Any]:
    """What is compared, the reference `first`, charts of the differences, and titles with tables.

    None stands in the place of a table without any collision.
    """
    firsts = references_of(found)
    single = len(firsts) == 1
    settings, setting = table.order.disturbances, "disturbance"
    if factor == "disturbance":
        settings, setting = table.order.variants, "variant"
    figures: list[Figure] = []
    for part in settings if len(found) > MOST_ROWS else ("",):
        rows: list[Comparison] = [one for one in found if part in ("", one.setting)]
        if rows:
            caption = (
                f"Mean paired differences to {code(firsts[0]) if single else 'the reference'} "
                "with 95 % intervals; hollow where the interval includes zero."
            )
            if not single:
                caption += f" The reference is {code(firsts[0])} unless a row names another."
            if part:
                caption += f" {setting.capitalize()} {code(part)}."
            name = f"{factor}s-{part}" if part else f"{factor}s"
            named = len(settings) > 1 and not part
            figures += artist.chart(caption, charts.draw_comparisons, rows, named, name=name)
    return {
        "factor": factor,
        "first": code(firsts[0]) if single else "its reference",
        "figures": figures,
        "tables": comparison_tables(found, factor, setting if len(settings) > 1 else ""),
    }


def _curves(table: TrialTable, cells: Sequence[Cell], artist: Artist) -> list[dict[str, Any]]:
    """Success and quantities of each scenario over its levels."""
    order = table.order
    sections = []
    for scenario, curves in curves_of(table, cells).items():
        figures: list[Figure] = []
        # Lines by variant; a chart per disturbance where both vary.
        for part in order.disturbances if len(order.parts) == 3 else ("",):
            shown = [curve for curve in curves if part in ("", curve.cell.disturbance)]
            if not shown:
                continue
            labels = [getattr(c.cell, order.parts[-1]) for c in shown]
            third = "planning time" if shown[0].cell.planned else "formation error"
            text = f"success; median time and {third}"
            if len(shown) <= charts.FEW_CURVES:
                text = f"success with 95 % interval; median and quartiles of time and {third}"
            where = f" Disturbance {code(part)}." if part else ""
            caption = f"{code(scenario)}: {text} of the trials that succeeded.{where}"
            name = f"curves-{scenario}-{part}" if part else f"curves-{scenario}"
            figures += artist.chart(caption, charts.draw_curves, shown, labels, name=name)
        section = {"scenario": scenario, "axis": curves[0].axis, "figures": figures}
        sections.append(section | {"table": tables.curve_table(curves, order)})
    return sections


def _failure_table(failed: Sequence[Trial]) -> Table | None:
    """Failures that need not have been, by reason, with examples; None without any."""
    rows = [
        (outcome, *row)
        for outcome in in_order(Counter(trial.outcome for trial in failed))
        for row in _by_reason([trial for trial in failed if trial.outcome == outcome])
    ]
    return Table(("reason", "detail", "trials", "which"), rows, 2, last=True) if rows else None


def _by_reason(trials: Sequence[Trial]) -> list[tuple[str, str, str]]:
    """Reason, number and first names of those with the same reason but for its numbers.

    The largest group comes first.
    """
    groups: dict[str, list[Trial]] = {}
    for trial in trials:
        groups.setdefault(_NUMBER.sub("…", trial.reason), []).append(trial)
    named = []
    for common, members in groups.items():
        texts = {trial.reason for trial in members}
        named.append((texts.pop() if len(texts) == 1 else common, members))
    rows = []
    for reason, members in sorted(named, key=lambda item: (-len(item[1]), item[0])):
        which = ", ".join(code(trial.name) for trial in members[:MOST_EXAMPLES])
        more = len(members) - MOST_EXAMPLES
        which += f" and {count(more)} more" if more > 0 else ""
        rows.append((plain(reason) or "–", count(len(members)), which))
    return rows


def trial_list(trials: Sequence[Trial]) -> dict[str, Any]:
    """Trials for the page: `columns`, each name with its decimals, or null for texts; `rows`."""
    planned = bool(trials) and all(trial.planned for trial in trials)
    whole = all(trial.level is None or trial.level.is_integer() for trial in trials)
    columns: list[tuple[str, int | None, Callable[[Trial], Any]]] = [
        ("trial", None, lambda t: t.name),
        ("feasible", None, lambda t: "yes" if t.feasible else "no"),
        ("success", None, lambda t: "yes" if t.success else "no"),
        ("outcome", None, lambda t: t.outcome),
        ("level", 0 if whole else 2, lambda t: t.level),
        ("end (s)", 1, lambda t: _rounded(t.makespan if t.planned else t.duration, 2)),
        ("over alone" if planned else "over bound", 2, lambda t: _rounded(t.time_ratio, 3)),
        ("planned in (s)", 3, lambda t: _rounded(t.planning_time, 4))
        if planned
        else ("error (cm)", 1, lambda t: _rounded(t.formation_error, 2, 100.0)),
        ("gap (m)", 3, lambda t: _rounded(t.gap, 4)),
        ("collisions", 0, lambda t: t.contacts),
        ("detail", None, lambda t: t.reason),
    ]
    return {
        "columns": [[name, digits] for name, digits, _ in columns],
        "rows": [[value(trial) for _, _, value in columns] for trial in trials],
    }


def _rounded(value: float | None, digits: int, factor: float = 1.0) -> float | None:
    return None if value is None else round(factor * value, digits)
