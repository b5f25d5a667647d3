"""The tables of the verdict: a row per scenario, disturbance and variant."""

from __future__ import annotations

from collections.abc import Sequence

from cavalcade.campaign.report.blocks import Table, code, without_empty_columns
from cavalcade.campaign.report.comparisons import ALL
from cavalcade.campaign.report.curves import Curve
from cavalcade.campaign.report.trials import Order
from cavalcade.campaign.report.verdict import Cell, Spread, in_order
from cavalcade.campaign.report.wording import NONE, bound, count, interval, number, share
from cavalcade.campaign.statistics import wilson


def head_of(order: Order) -> tuple[str, ...]:
    """Names of the columns that say which cell a row is about."""
    head = ["scenario"]
    if len(order.disturbances) > 1:
        head.append("disturbance")
    if len(order.variants) > 1:
        head.append("variant")
    return tuple(head)


def cell_names(cell: Cell, order: Order) -> tuple[str, ...]:
    """The content of these columns."""
    names = [cell.scenario if cell.scenario == ALL else code(cell.scenario)]
    if len(order.disturbances) > 1:
        names.append(code(cell.disturbance))
    if len(order.variants) > 1:
        names.append(code(cell.variant))
    return tuple(names)


def success_table(cells: Sequence[Cell], order: Order) -> Table:
    """Success and collisions."""
    head = head_of(order)
    rows = []
    for cell in cells:
        done, feasible, trials = cell.feasible_successes, len(cell.feasible), len(cell.trials)
        rows.append(
            (
                *cell_names(cell, order),
                count(trials),
                count(feasible),
                count(done) if feasible else NONE,
                share(done, feasible),
                interval(cell.interval, feasible),
                share(len(cell.succeeded), trials),
                count(cell.hit),
                bound(cell.hit_bound, len(cell.run)),
                count(cell.touched),
            )
        )
    columns = (
        *head,
        "trials",
        "feasible",
        "succeeded",
        "success",
        "95 % interval",
        "success of all",
        "with avoidable collision",
        "95 % bound",
        "with any collision",
    )
    return Table(columns, tuple(rows), len(head))


def outcome_table(cells: Sequence[Cell], order: Order) -> Table:
    """How the trials ended, failures in worlds that cannot be crossed in brackets."""
    head = head_of(order)
    seen = in_order({outcome: 1 for cell in cells for outcome in cell.outcomes})
    rows = []
    for cell in cells:
        row = []
        for outcome in seen:
            ended = [trial for trial in cell.trials if trial.outcome == outcome]
            hopeless = sum(not trial.feasible and not trial.success for trial in ended)
            text = count(len(ended)) if ended else NONE
            row.append(f"{text} ({count(hopeless)})" if hopeless else text)
        rows.append((*cell_names(cell, order), *row))
    return Table((*head, *seen), tuple(rows), len(head))


def measure_table(cells: Sequence[Cell], order: Order) -> Table:
    """Time, formation and computing time."""
    head = head_of(order)
    rows = []
    for cell in cells:
        time, ratio, error = cell.time, cell.time_ratio, cell.formation_error
        typical, slow = cell.spread("cycle_ms.p50"), cell.spread("cycle_ms.p99")
        slowest = cell.spread("cycle_ms.max")
        rows.append(
            (
                *cell_names(cell, order),
                number(time.median, 1),
                number(time.p95, 1),
                number(ratio.median),
                number(ratio.p95),
                number(error.median, 1, 100.0),
                number(error.p95, 1, 100.0),
                number(typical.median, 1),
                number(slow.median, 1),
                number(slowest.most, 0),
            )
        )
    columns = (
        *head,
        "time p50 (s)",
        "p95",
        "over lower bound p50",
        "p95",
        "formation error p50 (cm)",
        "p95",
        "cycle p50 (ms)",
        "cycle p99 (ms)",
        "slowest cycle (ms)",
    )
    table = Table(columns, tuple(rows), len(head))
    return without_empty_columns(table, range(len(head)))


def refusal_table(cells: Sequence[Cell], order: Order) -> Table:
    """Problems without a plan: how many were refused as they have to be, and how fast.

    Args:
        cells: Of such problems.
        order: Of rows.
    """
    head = head_of(order)
    rows = []
    for cell in cells:
        done, trials = len(cell.succeeded), len(cell.trials)
        ended = ", ".join(f"{count(n)} {name}" for name, n in cell.outcomes.items())
        time = cell.planning_time
        rows.append(
            (
                *cell_names(cell, order),
                _WORDS.get(cell.trials[0].expected, cell.trials[0].expected),
                count(trials),
                share(done, trials),
                interval(wilson(done, trials), trials),
                number(time.median, 4),
                number(time.most, 4),
                ended,
            )
        )
    columns = (
        *head,
        "has to be",
        "trials",
        "as it has to be",
        "95 % interval",
        "after (s) p50",
        "slowest",
        "ended",
    )
    return Table(columns, tuple(rows), len(head) + 1, words=(len(columns) - 1,))


_WORDS = {
    "infeasible": "proven infeasible",
    "unsolved": "infeasible, or budget spent",
    "refused": "refused as bad input",
}


def clearance_table(cells: Sequence[Cell], order: Order) -> Table:
    """Closest approaches over all trials that ran."""
    head = head_of(order)
    keys = ("min_obstacle_distance_m", "min_robot_distance_m", "min_footprint_gap_m")
    rows = []
    for cell in cells:
        spreads: list[Spread] = [cell.spread(key) for key in keys]
        figures = [
            number(end, 3) for spread in spreads for end in (spread.least, spread.p5, spread.median)
        ]
        rows.append((*cell_names(cell, order), *figures))
    names = ("centre to obstacle (m)", "centre to centre (m)", "gap of footprints (m)")
    columns = [text for name in names for text in (f"{name} least", "p5", "p50")]
    table = Table((*head, *columns), tuple(rows), len(head))
    return without_empty_columns(table, range(len(head)))


def curve_table(curves: Sequence[Curve], order: Order) -> Table:
    """The numbers behind the curves of one scenario."""
    head = head_of(order)[1:]
    rows = []
    for curve in curves:
        for point in curve.points:
            error, time = point.formation_error.median, point.planning_time
            last = [number(time.median, 3), number(time.p95, 3)]
            rows.append(
                (
                    *cell_names(curve.cell, order)[1:],
                    point.label,
                    count(point.trials),
                    share(point.successes, point.trials),
                    interval(point.interval, point.trials),
                    number(point.time_ratio.median),
                    *(last if curve.cell.planned else [number(error, 1, 100.0)]),
                )
            )
    measured: tuple[str, ...]
    if curves[0].cell.planned:
        measured = ("makespan over slowest alone, median", "planning time (s), median", "p95")
    else:
        measured = ("time over lower bound, median", "formation error, median (cm)")
    columns = (
        *head,
        curves[0].axis,
        "feasible trials",
        "success",
        "95 % interval",
        *measured,
    )
    return Table(columns, tuple(rows), len(head))
