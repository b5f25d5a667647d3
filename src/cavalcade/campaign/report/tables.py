"""Tables of the report with a row per cell or per point of a curve."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

from cavalcade.campaign.report.cells import ALL, Cell, Curve, in_order
from cavalcade.campaign.report.trials import Order
from cavalcade.campaign.report.wording import (
    NONE,
    bound,
    code,
    count,
    interval,
    number,
    share,
)
from cavalcade.campaign.statistics import upper_bound, wilson

_LONG = 40
"""On the page a column with a text longer than this has its lines broken."""


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        head: Column names.
        rows: Cells as texts.
        texts: Columns that hold texts rather than numbers, by index.
    """

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    texts: frozenset[int]

    @property
    def kinds(self) -> tuple[str, ...]:
        """Of each column: `number`, `text`, or `long` for a text with broken lines."""
        found = []
        for k in range(len(self.head)):
            longest = max((len(row[k]) for row in self.rows), default=0)
            text = "long" if longest > _LONG else "text"
            found.append(text if k in self.texts else "number")
        return tuple(found)


def table_of(
    head: Sequence[str], rows: Iterable[Sequence[str]], left: int, *, last: bool = False
) -> Table:
    """A table whose first `left` columns, and the last one if so said, are texts."""
    return Table(
        tuple(head),
        tuple(tuple(row) for row in rows),
        frozenset([*range(left), *([len(head) - 1] if last else [])]),
    )


def cell_names(cell: Cell, order: Order) -> tuple[str, ...]:
    """Which cell it is: its scenario, and what else there are several of."""
    names = [cell.scenario if cell.scenario == ALL else code(cell.scenario)]
    if len(order.disturbances) > 1:
        names.append(code(cell.disturbance))
    if len(order.variants) > 1:
        names.append(code(cell.variant))
    return tuple(names)


def _head(order: Order) -> tuple[str, ...]:
    """Names of the columns that say which cell a row is about."""
    parts = (("disturbance", order.disturbances), ("variant", order.variants))
    return ("scenario", *(name for name, values in parts if len(values) > 1))


_Column = tuple[str, Callable[[Cell], str]]
"""Its name, and its text for a cell."""


def _cell_table(
    cells: Sequence[Cell],
    order: Order,
    columns: Sequence[_Column],
    *,
    every: bool = False,
    left: int = 0,
    last: bool = False,
) -> Table:
    """A row per cell, with what says which cell it is in front.

    Args:
        cells: At least one.
        order: Of rows.
        columns: All others.
        every: Keep columns that hold nothing but dashes.
        left, last: How many of these columns are texts, and whether the last one is.
    """
    made = [(name, [text(cell) for cell in cells]) for name, text in columns]
    shown = [(name, texts) for name, texts in made if every or any(t != NONE for t in texts)]
    head = (*_head(order), *(name for name, _ in shown))
    rows = [
        (*cell_names(cell, order), *(texts[k] for _, texts in shown))
        for k, cell in enumerate(cells)
    ]
    return table_of(head, rows, len(_head(order)) + left, last=last)


def _spread(name: str, end: str, digits: int = 2, factor: float = 1.0) -> Callable[[Cell], str]:
    """The column's text: one figure of a spread, such as its `median`."""
    return lambda cell: number(getattr(cell.spread(name), end), digits, factor)


def success_table(cells: Sequence[Cell], order: Order) -> Table:
    """Success and collisions."""
    columns: Sequence[_Column] = (
        ("trials", lambda c: count(c.trials)),
        ("feasible", lambda c: count(c.feasible)),
        ("succeeded", lambda c: count(c.feasible_successes) if c.feasible else NONE),
        ("success", lambda c: share(c.feasible_successes, c.feasible)),
        ("95 % interval", lambda c: interval(c.interval, c.feasible)),
        ("success of all", lambda c: share(c.successes, c.trials)),
        ("with avoidable collision", lambda c: count(c.hit)),
        ("95 % bound", lambda c: bound(c.hit_bound, c.ran)),
        ("with any collision", lambda c: count(c.touched)),
    )
    return _cell_table(cells, order, columns, every=True)


def outcome_table(cells: Sequence[Cell], order: Order) -> Table:
    """How the trials ended, failures in worlds that cannot be crossed in brackets."""

    def ended(cell: Cell, outcome: str) -> str:
        times, excused = cell.outcomes.get(outcome, 0), cell.excused.get(outcome, 0)
        text = count(times) if times else NONE
        return f"{text} ({count(excused)})" if excused else text

    seen = in_order({outcome: 1 for cell in cells for outcome in cell.outcomes})
    columns = [(outcome, partial(ended, outcome=outcome)) for outcome in seen]
    return _cell_table(cells, order, columns, every=True)


def formation_table(cells: Sequence[Cell], order: Order) -> Table:
    """Time, formation and computing time of teams in formation."""
    columns = (
        ("time p50 (s)", _spread("time", "median", 1)),
        ("p95", _spread("time", "p95", 1)),
        ("over lower bound p50", _spread("time_ratio", "median")),
        ("p95", _spread("time_ratio", "p95")),
        ("formation error p50 (cm)", _spread("formation_error", "median", 1, 100.0)),
        ("p95", _spread("formation_error", "p95", 1, 100.0)),
        ("cycle p50 (ms)", _spread("cycle_p50", "median", 1)),
        ("cycle p99 (ms)", _spread("cycle_p99", "median", 1)),
        ("slowest cycle (ms)", _spread("cycle_max", "most", 0)),
    )
    return _cell_table(cells, order, columns)


def plan_table(cells: Sequence[Cell], order: Order) -> Table:
    """Lengths, makespans and planning times of robots with individual goals."""
    columns = (
        ("average summed length (m)", _spread("length", "mean")),
        ("over lower bound p50", _spread("length_ratio", "median", 3)),
        ("p95", _spread("length_ratio", "p95", 3)),
        ("makespan p50 (s)", _spread("time", "median", 1)),
        ("over slowest alone p50", _spread("time_ratio", "median")),
        ("p95", _spread("time_ratio", "p95")),
        ("average planning time (s)", _spread("planning_time", "mean", 3)),
        ("p50", _spread("planning_time", "median", 3)),
        ("p99", _spread("planning_time", "p99", 3)),
        ("slowest", _spread("planning_time", "most", 3)),
        ("over single plans p50", _spread("single_time_ratio", "median")),
    )
    return _cell_table(cells, order, columns)


def commanded_table(cells: Sequence[Cell], order: Order) -> Table:
    """How robots followed commanded velocities; errors are the largest over a cell's trials."""
    columns = (
        ("time p50 (s)", _spread("duration", "median", 1)),
        ("summed lengths p50 (m)", _spread("length", "median", 1)),
        ("error of mean speed (%)", _spread("speed_error", "most", 2, 100.0)),
        ("of mean yaw rate (%)", _spread("yaw_rate_error", "most", 2, 100.0)),
        ("mean drift aside (m/s)", _spread("drift", "most", 3)),
        ("spread of speed (m/s)", _spread("speed_rms", "most", 3)),
    )
    return _cell_table(cells, order, columns)


def physics_table(cells: Sequence[Cell], order: Order) -> Table:
    """Falls, and what bodies and joints went through."""
    columns = (
        ("trials", lambda cell: count(cell.ran)),
        ("robots", lambda cell: count(cell.robots)),
        ("simulated (s)", lambda cell: count(round(cell.seconds))),
        ("with a fall", lambda cell: count(cell.fell)),
        ("95 % bound", lambda cell: bound(upper_bound(cell.fell, cell.ran), cell.ran)),
        ("crossed gap or step", lambda cell: count(cell.crossings) if cell.crossings else NONE),
        ("strictly", lambda cell: share(cell.strict_crossings, cell.crossings)),
        ("tilt p50 (rad)", _spread("tilt", "median")),
        ("most", _spread("tilt", "most")),
        ("torque p50", _spread("torque", "median")),
        ("most", _spread("torque", "most")),
        ("simulated over wall time", _spread("real_time_factor", "median", 1)),
    )
    return _cell_table(cells, order, columns)


def clearance_table(cells: Sequence[Cell], order: Order) -> Table:
    """Closest approaches over all trials that ran."""
    distances = (
        ("centre to obstacle (m)", "obstacle_distance"),
        ("centre to centre (m)", "robot_distance"),
        ("gap of footprints (m)", "gap"),
    )
    columns = [
        (text, _spread(name, end, 3))
        for label, name in distances
        for text, end in ((f"{label} least", "least"), ("p5", "p5"), ("p50", "median"))
    ]
    return _cell_table(cells, order, columns)


_HAS_TO_BE = {
    "infeasible": "proven infeasible",
    "unsolved": "infeasible, or budget spent",
    "refused": "refused as bad input",
}


def refusal_table(cells: Sequence[Cell], order: Order) -> Table:
    """Problems without a plan: how many were refused as they have to be, and how fast."""
    columns: Sequence[_Column] = (
        ("has to be", lambda c: _HAS_TO_BE.get(c.expected, c.expected)),
        ("trials", lambda c: count(c.trials)),
        ("as it has to be", lambda c: share(c.successes, c.trials)),
        ("95 % interval", lambda c: interval(wilson(c.successes, c.trials), c.trials)),
        ("after (s) p50", _spread("planning_time", "median", 4)),
        ("slowest", _spread("planning_time", "most", 4)),
        ("ended", lambda c: ", ".join(f"{count(n)} {name}" for name, n in c.outcomes.items())),
    )
    return _cell_table(cells, order, columns, every=True, left=1, last=True)


PAPER_GROUP = "random-goals"
"""The group of worlds that follows the paper's protocol."""

PAPER = (
    ("sequential", "18.2", "0.094", "11/16"),
    ("joint", "16.85", "1.067", "13/16"),
    ("cbs", "15.12", "0.254", "5/5"),
)
"""Its Table I: method, average path length (m), average computing time (s), success."""


def paper_table(cells: Sequence[Cell]) -> Table | None:
    """What the paper reports, and the same figures of our methods; None without such worlds."""
    ours = [cell for cell in cells if cell.scenario == PAPER_GROUP and cell.planned]
    if not ours:
        return None
    head = (
        "whose",
        "method",
        "average summed length (m)",
        "average planning time (s)",
        "success",
        "length over bound, median",
    )
    rows = [("the paper's", code(method), *figures, NONE) for method, *figures in PAPER]
    rows += [
        (
            "this campaign's",
            code(cell.variant),
            number(cell.spread("length").mean),
            number(cell.spread("planning_time").mean, 3),
            f"{cell.successes}/{cell.trials}",
            number(cell.spread("length_ratio").median, 3),
        )
        for cell in ours
    ]
    return table_of(head, rows, 2)


def curve_table(curves: Sequence[Curve], order: Order) -> Table:
    """The numbers behind the curves of one scenario."""
    if curves[0].cell.planned:
        columns: tuple[_Column, ...] = (
            ("makespan over slowest alone, median", _spread("time_ratio", "median")),
            ("planning time (s), median", _spread("solving_time", "median", 3)),
            ("p95", _spread("solving_time", "p95", 3)),
        )
    else:
        columns = (
            ("time over lower bound, median", _spread("time_ratio", "median")),
            ("formation error, median (cm)", _spread("formation_error", "median", 1, 100.0)),
        )
    head = (
        *_head(order)[1:],
        curves[0].axis,
        "feasible trials",
        "success",
        "95 % interval",
        *(name for name, _ in columns),
    )
    rows = [
        (
            *cell_names(curve.cell, order)[1:],
            point.label,
            count(point.cell.trials),
            share(point.cell.successes, point.cell.trials),
            interval(point.cell.interval, point.cell.trials),
            *(text(point.cell) for _, text in columns),
        )
        for curve in curves
        for point in curve.points
    ]
    return table_of(head, rows, len(_head(order)) - 1)
