"""What a job says while it goes on, and at its end."""

from __future__ import annotations

import sys
import time as clock
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from cavalcade.jobs.share import ShareDone
from cavalcade.recording.frames import Frame
from cavalcade.scenario import Scenario

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress as Bar
    from rich.progress import ProgressColumn

    from cavalcade.kernels.progress import Compilation

PLAIN_PERIOD = 10.0
"""Where there is no terminal, a line is printed this often, s of simulated time."""

COMPILING_PERIOD = 5.0
"""The same while kernels are compiled, s of wall time."""

_COMPILING = "compiling (once)"

_LATE = ("cavalcade.coordination.joint",)
"""Where the kernels are that a search compiles on its way, as few searches need them."""

_TELLING = 0.05
"""How long the rest will take is told once this share is done."""


class Reporter:
    """Says on stdout how work goes on: lines, and a bar on a terminal.

    Use it as a context; with `quiet` it says nothing.
    """

    def __init__(self, quiet: bool = False) -> None:
        self._quiet = quiet
        self._console: Console | None = None
        self._bar: Bar | None = None
        self._task: Any = None
        self._compiling: float | None = None

    def __enter__(self) -> Self:
        if not self._quiet:
            from rich.console import Console

            self._console = Console(file=sys.stdout, highlight=False, soft_wrap=True)
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def say(self, text: str) -> None:
        """One line."""
        if self._console is not None:
            self._console.print(text, markup=False)

    @contextmanager
    def compiling(
        self, modules: Iterable[str], unused: Iterable[str] = ()
    ) -> Iterator[Compilation]:
        """While the kernels of modules, without those of `unused` ones, are compiled or loaded.

        Nothing is said where all of them are on disk.
        """
        from cavalcade.kernels.progress import Compilation, watched

        with watched(Compilation(modules, unused, self._tell_compiling)) as compilation:
            yield compilation
        if self._bar is not None:
            self._bar.update(self._task, completed=1.0, told="", refresh=True)
        self.close()

    def _tell_compiling(self, compilation: Compilation) -> None:
        if self._console is None:
            return
        text = f"{compilation.kernels} functions done"
        if compilation.share > 0.0:
            text += f", about {duration(compilation.seconds_left)} left"
        if not self._console.is_terminal:
            now = clock.monotonic()
            if self._compiling is None or now - self._compiling >= COMPILING_PERIOD:
                self._compiling = now
                self.say(f"{_COMPILING.capitalize()}: {100.0 * compilation.share:.0f} %, {text}")
        elif self._bar is None:
            from rich.progress import TextColumn

            told = TextColumn("{task.percentage:.0f} %, {task.fields[told]}", markup=False)
            self._show_bar([told], 5, description=_COMPILING.capitalize(), total=1.0, told=text)
        else:
            self._bar.update(self._task, completed=compilation.share, told=text)

    def close(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _show_bar(self, columns: Sequence[ProgressColumn], per_second: float, **task: Any) -> None:
        """Begin a bar, with columns before the time that has passed, drawn so many times a second.

        `task` is its description and so on, as rich takes them.
        """
        from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
        from rich.progress import Progress as Bar

        self._bar = Bar(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            *columns,
            TimeElapsedColumn(),
            console=self._console,
            transient=True,
            refresh_per_second=per_second,
        )
        self._task = self._bar.add_task(**task)
        self._bar.start()


class JobReporter(Reporter):
    """Says what one job does; it is a sink of frames."""

    def __init__(
        self, name: str, quiet: bool = False, now: Callable[[], float] = clock.monotonic
    ) -> None:
        super().__init__(quiet)
        self._name, self._now = name, now
        self._last = self._began = 0.0
        self._share = ShareDone(0.0)

    def expect(self, scenario: Scenario) -> None:
        """A run of this scenario comes."""
        goals = () if scenario.goals else getattr(scenario.task, "goals", ())
        self._share = ShareDone(scenario.execution.timeout, goals)

    @contextmanager
    def planning(self, scenario: Scenario) -> Iterator[None]:
        """While a coordinator works. How long a search will take nobody knows: there is no bar."""
        text = f"{scenario.name}: {len(scenario.robots)} robots, method {scenario.planner.method}"
        limit = scenario.planner.budget.seconds
        if limit is not None:
            text += f", at most {limit:g} s"
        if self._console is None or not self._console.is_terminal:
            self.say(text)
            with self.compiling(_LATE):
                yield
            return
        from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        from cavalcade.kernels.progress import Compilation, watched

        columns = (
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            TimeElapsedColumn(),
        )
        with Progress(*columns, console=self._console, transient=True) as progress:
            task = progress.add_task(text, total=None)

            def tell(compilation: Compilation) -> None:
                left = duration(compilation.seconds_left)
                more = f"; {_COMPILING}, about {left} left" if compilation.share < 1.0 else ""
                progress.update(task, description=text + more)

            with watched(Compilation(_LATE, (), tell)):
                yield

    def __call__(self, frame: Frame) -> None:
        """Take note of a cycle."""
        if self._console is None:
            return
        if self._console.is_terminal:
            self._update_bar(frame)
        elif frame.time - self._last >= PLAIN_PERIOD - 1e-9:
            self._last = frame.time
            self.say(f"{frame.time:6.1f} s  {frame.status.state}")
        if frame.notes:
            self.say(f"{frame.time:6.1f} s  {'; '.join(frame.notes)}")

    def complete(self) -> None:
        """The run is over: its bar is full, and goes."""
        if self._bar is not None:
            self._bar.update(self._task, completed=1.0, left="", refresh=True)
        self.close()

    def finish(self, summary: Mapping[str, Any], files: Sequence[Path]) -> None:
        """The table of the result and where to look."""
        self.close()
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

    def _update_bar(self, frame: Frame) -> None:
        if self._bar is None:
            from rich.progress import TextColumn

            told = TextColumn(
                "{task.percentage:.0f} %, {task.fields[time]:.1f} s simulated, "
                "{task.fields[state]}{task.fields[left]}",
                markup=False,
            )
            self._began = self._now()
            self._share(frame)
            task = {"description": self._name, "total": 1.0, "left": ""}
            self._show_bar([told], 5, **task, time=frame.time, state=frame.status.state)
        elif not 0.0 <= frame.time - self._last < 0.5:
            self._last = frame.time
            share = self._share(frame)
            news: dict[str, Any] = {"time": frame.time, "state": frame.status.state, "left": ""}
            if share >= _TELLING:
                left = (self._now() - self._began) * (1.0 - share) / share
                news["left"] = f", {duration(left)} left"
            self._bar.update(self._task, completed=share, **news)


def duration(seconds: float) -> str:
    """A time in the two largest units that matter: `1 h 05 min`, `3 min 20 s`, `12 s`."""
    whole = max(0, round(seconds))
    hours, minutes, rest = whole // 3600, whole // 60 % 60, whole % 60
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"


def result_rows(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The summary's most telling values as rows of a table."""
    planned = summary["backend"] is None
    scenario, result = f"{summary['name']}, {summary['robots']} robots", summary["reason"]
    if summary["detail"]:
        result += f" ({summary['detail']})"
    if planned:
        method = summary["method"]
        if summary["found_by"] != method:
            method += f" (found by {summary['found_by']})"
        rows = [
            ("scenario", scenario),
            ("method", f"{method}, {summary['variant']}"),
            ("result", result),
            ("planning time", _with(summary["planning_time_s"], "s", 3)),
        ]
        if not summary["success"]:
            return rows
    else:
        rows = [
            ("scenario", f"{scenario}, {summary['variant']}"),
            ("result", result),
            ("simulated time", _with(summary["sim_time_s"], "s", 1)),
        ]
    rows.append(("all in place after", _with(summary["makespan_s"], "s", 1)))
    if summary.get("goal_moved_m"):
        rows.append(("goal moved by", _with(summary["goal_moved_m"], "m, to where the shape fits")))
    if planned:
        length, bound = _total(summary["path_length_m"]), _total(summary["lower_bound_m"])
        ratio = f", {length / bound:.3f} × the shortest ways alone" if length and bound else ""
        rows.append(("summed length", _with(length, "m") + ratio))
    collisions = summary["collisions"]
    rows += [
        (
            "collisions",
            f"{collisions['robot_robot']} between robots, "
            f"{collisions['robot_obstacle']} with obstacles",
        ),
        ("closest to an obstacle", _with(summary["min_obstacle_distance_m"], "m (centre)")),
        ("closest to each other", _with(summary["min_robot_distance_m"], "m (centres)")),
        ("smallest footprint gap", _with(summary["min_footprint_gap_m"], "m")),
    ]
    if not planned:
        rows += _run_rows(summary)
    elif feet := summary["footholds"]["count"]:
        rows.append(("footholds", f"{feet}, {summary['footholds']['out_of_reach']} out of reach"))
    return [row for row in rows if row[1]]


def _run_rows(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the run's kind of task is judged by, and how long it took."""
    error, cycle = summary["formation_error_m"], summary["cycle_ms"]
    if summary.get("commanded") is not None:
        rows = _commanded_rows(summary["commanded"])
    elif summary["leader_changes"] is None:  # robots with goals of their own, planned ahead
        rows = [("planning time", _with(summary["planning_time_s"], "s", 3))]
    else:
        rows = [
            (
                "formation error",
                f"{_with(error['mean'], 'm')} mean, {_with(error['max'], 'm')} largest",
            ),
            ("leader changes", str(summary["leader_changes"])),
            ("role changes", str(summary["role_changes"])),
            (
                "planning per cycle",
                f"{_with(cycle['p50'], 'ms')} median, {_with(cycle['p99'], 'ms')} 99th percentile",
            ),
        ]
    return [*rows, ("wall time", _with(summary["wall_time_s"], "s", 1))]


def _commanded_rows(tracking: Mapping[str, Any]) -> list[tuple[str, str]]:
    """How well commands were followed; nothing where no velocity stood long enough."""
    speed, turn, spread = (tracking[key] for key in ("speed_error", "yaw_rate_error", "rms_m_s"))
    return [
        ("error of mean speed", "" if speed is None else f"{100.0 * speed:.1f} %"),
        ("error of mean yaw rate", "" if turn is None else f"{100.0 * turn:.1f} %"),
        ("spread of speed", "" if spread is None else f"{spread:.3f} m/s (root mean square)"),
    ]


def _total(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) if len(known) == len(values) else None


def _with(value: float | None, unit: str, digits: int = 2) -> str:
    return "–" if value is None else f"{value:.{digits}f} {unit}"
