"""Tables of the report with a row per cell or per point of a curve."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
        left: The first so many columns hold texts rather than numbers,
        last: and the last one, if so said.
    """

    head: Sequence[str]
    rows: Sequence[tuple[str, ...]]
    left: int
    last: bool = False

    @property
    def kinds(self) -> tuple[str, ...]:
        """Of each column: `number`, `text`, or `long` for a text with broken lines."""
        found = []
        for k in range(len(self.head)):
            longest = max((len(row[k]) for row in self.rows), default=0)
            text = "long" if longest > _LONG else "text"
            is_text = k < self.left or (self.last and k == len(self.head) - 1)
            found.append(text if is_text else "number")
        return tuple(found)


def table_of(
    front: Sequence[tuple[str, Sequence[str]]],
    columns: Sequence[tuple[str, Sequence[str]]],
    last: bool = False,
) -> Table:
    """A table of columns, each with its name; those in `front` hold texts."""
    head, texts = zip(*front, *columns, strict=True)
    return Table(head, tuple(zip(*texts, strict=True)), len(front), last)


def scenario_text(name: str) -> str:
    """The name of a scenario as code, but for `ALL`."""
    return name if name == ALL else code(name)


def cell_names(cell: Cell, order: Order) -> tuple[str, ...]:
    """Which cell it is: its scenario, and what else there are several of."""
    return (scenario_text(cell.scenario), *(code(getattr(cell, one)) for one in order.parts[1:]))


Columns = Sequence[tuple[str, Callable[[Cell], str]]]
"""Each with its name, and its text for a cell."""


def cell_table(
    cells: Sequence[Cell], order: Order, columns: Columns, every: bool = False
) -> Table | None:
    """A row per cell, with what says which cell it is in front; None without cells.

    Columns that hold nothing but dashes are left out unless `every` one is wanted.
    """
    if not cells:
        return None
    made = [(name, [text(cell) for cell in cells]) for name, text in columns]
    shown = [(name, texts) for name, texts in made if every or any(t != NONE for t in texts)]
    return table_of(_front(cells, order), shown)


def _front(cells: Sequence[Cell], order: Order) -> list[tuple[str, tuple[str, ...]]]:
    names = zip(*(cell_names(cell, order) for cell in cells), strict=True)
    return list(zip(order.parts, names, strict=True))


def _spread(name: str, end: str, digits: int = 2, factor: float = 1.0) -> Callable[[Cell], str]:
    """The column's text: one figure of a spread, such as its `median`."""
    return lambda cell: number(getattr(cell.spreads[name], end), digits, factor)


SUCCESS: Columns = (
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
"""Success and collisions."""


def outcome_columns(cells: Sequence[Cell]) -> Columns:
    """How the trials ended, failures in worlds that cannot be crossed in brackets."""

    def ended(cell: Cell, outcome: str) -> str:
        times, excused = cell.outcomes.get(outcome, 0), cell.excused.get(outcome, 0)
        text = count(times) if times else NONE
        return f"{text} ({count(excused)})" if excused else text

    seen = in_order({outcome: 1 for cell in cells for outcome in cell.outcomes})
    return [(outcome, partial(ended, outcome=outcome)) for outcome in seen]


FORMATION: Columns = (
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
"""Time, formation and computing time of teams in formation."""

PLAN: Columns = (
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
"""Lengths, makespans and planning times of robots with individual goals."""

COMMANDED: Columns = (
    ("time p50 (s)", _spread("duration", "median", 1)),
    ("summed lengths p50 (m)", _spread("length", "median", 1)),
    ("error of mean speed (%)", _spread("speed_error", "most", 2, 100.0)),
    ("of mean yaw rate (%)", _spread("yaw_rate_error", "most", 2, 100.0)),
    ("mean drift aside (m/s)", _spread("drift", "most", 3)),
    ("spread of speed (m/s)", _spread("speed_rms", "most", 3)),
)
"""How robots followed commanded velocities; errors are the largest over a cell's trials."""

PHYSICS: Columns = (
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
"""Falls, and what bodies and joints went through."""

CLEARANCE: Columns = [
    (text, _spread(name, end, 3))
    for label, name in (
        ("centre to obstacle (m)", "obstacle_distance"),
        ("centre to centre (m)", "robot_distance"),
        ("gap of footprints (m)", "gap"),
    )
    for text, end in ((f"{label} least", "least"), ("p5", "p5"), ("p50", "median"))
]
"""Closest approaches over all trials that ran."""

_HAS_TO_BE = {
    "infeasible": "proven infeasible",
    "unsolved": "infeasible, or budget spent",
    "refused": "refused as bad input",
}


def refusal_table(cells: Sequence[Cell], order: Order) -> Table | None:
    """Problems without a plan: how many were refused as they have to be, and how fast."""
    if not cells:
        return None
    columns: Columns = (
        ("trials", lambda c: count(c.trials)),
        ("as it has to be", lambda c: share(c.successes, c.trials)),
        ("95 % interval", lambda c: interval(wilson(c.successes, c.trials), c.trials)),
        ("after (s) p50", _spread("planning_time", "median", 4)),
        ("slowest", _spread("planning_time", "most", 4)),
        ("ended", lambda c: ", ".join(f"{count(n)} {name}" for name, n in c.outcomes.items())),
    )
    has_to_be = [_HAS_TO_BE.get(cell.expected, cell.expected) for cell in cells]
    front = [*_front(cells, order), ("has to be", has_to_be)]
    return table_of(front, [(name, [text(c) for c in cells]) for name, text in columns], last=True)


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
            number(cell.spreads["length"].mean),
            number(cell.spreads["planning_time"].mean, 3),
            f"{cell.successes}/{cell.trials}",
            number(cell.spreads["length_ratio"].median, 3),
        )
        for cell in ours
    ]
    return Table(head, rows, 2)


def curve_table(curves: Sequence[Curve], order: Order) -> Table:
    """The numbers behind the curves of one scenario."""
    measured: Columns = (
        ("time over lower bound, median", _spread("time_ratio", "median")),
        ("formation error, median (cm)", _spread("formation_error", "median", 1, 100.0)),
    )
    if curves[0].cell.planned:
        measured = (
            ("makespan over slowest alone, median", _spread("time_ratio", "median")),
            ("planning time (s), median", _spread("solving_time", "median", 3)),
            ("p95", _spread("solving_time", "p95", 3)),
        )
    columns: Columns = (
        ("feasible trials", lambda c: count(c.trials)),
        ("success", lambda c: share(c.successes, c.trials)),
        ("95 % interval", lambda c: interval(c.interval, c.trials)),
        *measured,
    )
    points = [point for curve in curves for point in curve.points]
    cells = [point.cell for point in points]
    levels = (curves[0].axis, [point.label for point in points])
    made = [(name, [text(cell) for cell in cells]) for name, text in columns]
    return table_of(_front(cells, order)[1:], [levels, *made])
