"""Tables of campaigns whose robots have goals of their own."""

from __future__ import annotations

from collections.abc import Sequence

from cavalcade.campaign.report.blocks import Table, code, without_empty_columns
from cavalcade.campaign.report.tables import cell_names, head_of
from cavalcade.campaign.report.trials import Order
from cavalcade.campaign.report.verdict import Cell
from cavalcade.campaign.report.wording import NONE, number
from cavalcade.campaign.statistics import quantile

PAPER_GROUP = "random-goals"
"""The group of worlds that follows the paper's protocol."""

PAPER = (
    ("sequential", "18.2", "0.094", "11/16"),
    ("joint", "16.85", "1.067", "13/16"),
    ("cbs", "15.12", "0.254", "5/5"),
)
"""Its Table I: method, average path length (m), average computing time (s), success."""

_HIGHEST = 0.99


def paper_table(cells: Sequence[Cell]) -> Table | None:
    """What the paper reports, and the same figures of our methods; None without such worlds."""
    ours = [cell for cell in cells if cell.scenario == PAPER_GROUP and cell.planned]
    if not ours:
        return None
    rows = [("the paper's", code(method), *figures, NONE) for method, *figures in PAPER]
    for cell in ours:
        rows.append(
            (
                "this campaign's",
                code(cell.variant),
                number(_mean([trial.length for trial in cell.succeeded])),
                number(_mean([trial.number("planning_time_s") for trial in cell.trials]), 3),
                f"{len(cell.succeeded)}/{len(cell.trials)}",
                number(cell.length_ratio.median, 3),
            )
        )
    columns = (
        "whose",
        "method",
        "average summed length (m)",
        "average planning time (s)",
        "success",
        "length over bound, median",
    )
    return Table(columns, tuple(rows), 2)


def plan_measure_table(cells: Sequence[Cell], order: Order) -> Table:
    """Lengths, makespans and planning times."""
    head = head_of(order)
    rows = []
    for cell in cells:
        length, ratio, time = cell.length_ratio, cell.time_ratio, cell.planning_time
        seconds = [trial.number("planning_time_s") for trial in cell.trials]
        rows.append(
            (
                *cell_names(cell, order),
                number(_mean([trial.length for trial in cell.succeeded])),
                number(length.median, 3),
                number(length.p95, 3),
                number(cell.time.median, 1),
                number(ratio.median),
                number(ratio.p95),
                number(_mean(seconds), 3),
                number(time.median, 3),
                number(quantile(seconds, _HIGHEST), 3),
                number(time.most, 3),
                number(cell.single_time_ratio.median),
            )
        )
    columns = (
        *head,
        "average summed length (m)",
        "over lower bound p50",
        "p95",
        "makespan p50 (s)",
        "over slowest alone p50",
        "p95",
        "average planning time (s)",
        "p50",
        "p99",
        "slowest",
        "over single plans p50",
    )
    table = Table(columns, tuple(rows), len(head))
    return without_empty_columns(table, range(len(head)))


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None
