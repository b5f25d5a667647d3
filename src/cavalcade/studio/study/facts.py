"""Summaries for people: rows of names and values, of one result or of two side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class _Row:
    """A fact: what it is called, where it stands in the summary, and how it is written."""

    label: str
    key: str
    shape: str = "{}"


_ROWS = (
    _Row("outcome", "reason"),
    _Row("detail", "detail"),
    _Row("robots", "robots"),
    _Row("planner", "method"),
    _Row("variant", "variant"),
    _Row("backend", "backend"),
    _Row("seed", "seed"),
    _Row("simulated time", "sim_time_s", "{:.1f} s"),
    _Row("all in place after", "makespan_s", "{:.1f} s"),
    _Row("closest to an obstacle", "min_obstacle_distance_m", "{:.2f} m"),
    _Row("closest two robots", "min_robot_distance_m", "{:.2f} m"),
    _Row("smallest gap of bodies", "min_footprint_gap_m", "{:.2f} m"),
    _Row("collisions of robots", "collisions.robot_robot"),
    _Row("collisions with obstacles", "collisions.robot_obstacle"),
    _Row("falls", "falls"),
    _Row("formation error, mean", "formation_error_m.mean", "{:.2f} m"),
    _Row("formation error, largest", "formation_error_m.max", "{:.2f} m"),
    _Row("leader changes", "leader_changes"),
    _Row("slot changes", "role_changes"),
    _Row("cycle, median", "cycle_ms.p50", "{:.1f} ms"),
    _Row("cycle, 99 %", "cycle_ms.p99", "{:.1f} ms"),
    _Row("planning time", "planning_time_s", "{:.2f} s"),
    _Row("path length, all robots", "path_length_m", "{:.2f} m"),
)


def facts(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(name, value) of what the summary says."""
    return [(row.label, text) for row in _ROWS if (text := _text(summary, row)) is not None]


def compared(one: Mapping[str, Any], other: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """(name, value, other value, difference) of what either of two summaries says.

    The difference is the second less the first; empty where they are the same or no numbers.
    """
    found = []
    for row in _ROWS:
        texts = [_text(summary, row) for summary in (one, other)]
        if any(text is not None for text in texts):
            first, second = (text if text is not None else "–" for text in texts)
            found.append((row.label, first, second, _difference(one, other, row)))
    return found


def _difference(one: Mapping[str, Any], other: Mapping[str, Any], row: _Row) -> str:
    first, second = _value(one, row.key), _value(other, row.key)
    if not (_is_number(first) and _is_number(second)) or row.key == "seed":
        same = first == second
        return "" if same else "differs"
    if row.shape.format(first) == row.shape.format(second):
        return ""
    sign = "+" if second > first else "\N{MINUS SIGN}"
    return sign + row.shape.format(abs(second - first))


def _text(summary: Mapping[str, Any], row: _Row) -> str | None:
    value = _value(summary, row.key)
    if value is None or value == "":
        return None
    if row.shape != "{}" and not _is_number(value):
        return None
    return row.shape.format(value)


def _value(summary: Mapping[str, Any], key: str) -> Any:
    """What stands there; of a list of numbers, one per robot, their sum."""
    value: Any = summary
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    if isinstance(value, list | tuple):
        return sum(value) if value and all(map(_is_number, value)) else None
    return value


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
