"""What planning says while it goes on, and at its end."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from cavalcade.jobs.warm import kernels_are_cached
from cavalcade.scenario import Scenario

if TYPE_CHECKING:
    from rich.console import Console


class PlanReporter:
    """Says on stdout what planning does: a spinning clock on a terminal, plain lines elsewhere.

    Use it as a context; with `quiet` it says nothing. How long a search will take nobody knows,
    so there is no bar that pretends to.
    """

    def __init__(self, scenario: Scenario, quiet: bool = False) -> None:
        self._scenario = scenario
        self._quiet = quiet
        self._console: Console | None = None

    def __enter__(self) -> Self:
        if not self._quiet and self._console is None:
            from rich.console import Console

            self._console = Console(file=sys.stdout, highlight=False, soft_wrap=True)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        return None

    def say(self, text: str) -> None:
        """One line."""
        if self._console is not None:
            self._console.print(text, markup=False)

    @contextmanager
    def planning(self) -> Iterator[None]:
        """While the coordinator works."""
        scenario = self._scenario
        text = f"{scenario.name}: {len(scenario.robots)} robots, method {scenario.planner.method}"
        limit = scenario.planner.budget.seconds
        if limit is not None:
            text += f", at most {limit:g} s"
        if self._console is not None and not kernels_are_cached("coordination", "*"):
            text += "; compiling the numerical kernels, once after installation (a minute or two)"
        if self._console is None:
            yield
        elif self._console.is_terminal:
            from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

            columns = (
                SpinnerColumn(),
                TextColumn("{task.description}", markup=False),
                TimeElapsedColumn(),
            )
            with Progress(*columns, console=self._console, transient=True) as progress:
                progress.add_task(text, total=None)
                yield
        else:
            self.say(text)
            yield

    def finish(self, summary: Mapping[str, Any], files: Sequence[Path]) -> None:
        """The table of the result and where to look."""
        if self._console is None:
            return
        from rich import box
        from rich.table import Table
        from rich.text import Text

        table = Table(box=box.SIMPLE, show_header=False, pad_edge=False)
        table.add_column(justify="left")
        table.add_column(justify="left")
        for key, value in result_rows(summary):
            table.add_row(key, Text(value))
        self._console.print(table)
        for file in files:
            self.say(str(file))


def result_rows(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The summary's most telling figures as rows of a table."""
    result = summary["reason"]
    if summary["detail"]:
        result += f" ({summary['detail']})"
    method = summary["method"]
    if summary["found_by"] != method:
        method += f" (found by {summary['found_by']})"
    rows = [
        ("scenario", f"{summary['name']}, {summary['robots']} robots"),
        ("method", f"{method}, {summary['variant']}"),
        ("result", result),
        ("planning time", _with(summary["planning_time_s"], "s", 3)),
    ]
    if not summary["success"]:
        return rows
    length, bound = _total(summary["path_length_m"]), _total(summary["lower_bound_m"])
    ways = _with(length, "m")
    if length is not None and bound:
        ways += f", {length / bound:.3f} × the shortest ways alone"
    collisions, feet = summary["collisions"], summary["footholds"]
    rows += [
        ("all in place after", _with(summary["makespan_s"], "s", 1)),
        ("summed length", ways),
        (
            "collisions",
            f"{collisions['robot_robot']} between robots, "
            f"{collisions['robot_obstacle']} with obstacles",
        ),
        ("closest to an obstacle", _with(summary["min_obstacle_distance_m"], "m (centre)")),
        ("closest to each other", _with(summary["min_robot_distance_m"], "m (centres)")),
        ("smallest footprint gap", _with(summary["min_footprint_gap_m"], "m")),
    ]
    if feet["count"]:
        rows.append(("footholds", f"{feet['count']}, {feet['out_of_reach']} out of reach"))
    return rows


def _total(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) if len(known) == len(values) else None


def _with(value: float | None, unit: str, digits: int = 2) -> str:
    return "–" if value is None else f"{value:.{digits}f} {unit}"
