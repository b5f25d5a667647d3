"""What is said of a trial, whatever kind it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cavalcade.checking.report import Report

COLLISION, INVALID, FALLEN = "collision", "invalid", "fallen"

CONTACT = ("robot-robot", "robot-obstacle", "robot-map", "flight-over-robot")
"""The checker's kinds of violation that are collisions."""

MOST_VIOLATIONS = 5
"""So many of the checker's lines are kept."""


@dataclass(frozen=True)
class Verdict:
    """What the checker and the audit say of a run or a plan.

    Attributes:
        outcome: Its own reason, `collision` or `invalid`.
        detail: One line.
        success: As it should be, without an avoidable collision or another violation.
        contacts: How many collisions there were.
        avoidable: How many of them could have been avoided.
        violations: The checker's lines, the first few.
    """

    outcome: str
    detail: str
    success: bool
    contacts: int
    avoidable: int
    violations: tuple[str, ...]


def count_contacts(report: Report) -> int:
    """How many of the checker's violations are collisions."""
    return sum(violation.kind in CONTACT for violation in report.violations)


def lines_of(report: Report) -> tuple[str, ...]:
    """The checker's first few lines."""
    found: Sequence[Any] = report.violations[:MOST_VIOLATIONS]
    return tuple(f"{v.time:.2f} s {v.kind}: {v.message}" for v in found)
