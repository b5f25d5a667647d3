"""What is said of a trial, whatever kind it is."""

from __future__ import annotations

from dataclasses import dataclass

from cavalcade.checking.report import Report, Violation

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


def contacts_of(report: Report) -> list[Violation]:
    """Those of the checker's violations that are collisions."""
    return [violation for violation in report.violations if violation.kind in CONTACT]


def verdict_of(
    report: Report, reason: str, detail: str, *, success: bool, avoidable: int
) -> Verdict:
    """The verdict on what ended for a `reason` of its own, unless the checker knows better."""
    contacts = contacts_of(report)
    if reason == FALLEN or not report.violations:  # whatever was touched in a fall
        outcome = reason
    else:
        outcome = COLLISION if contacts else INVALID
    first = report.violations[:MOST_VIOLATIONS]
    lines = tuple(f"{v.time:.2f} s {v.kind}: {v.message}" for v in first)
    return Verdict(outcome, detail, success, len(contacts), avoidable, lines)
