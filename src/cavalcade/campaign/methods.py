"""What a suite's `variants` may name: variants of the formation planner, or planning methods.

Methods are for robots with individual goals. A method's name may end in `-published`: then it
plans with the paper's options.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, get_args

from cavalcade.errors import ScenarioError
from cavalcade.scenario.messages import short
from cavalcade.scenario.settings import TEAM_VARIANTS, Variant
from cavalcade.values import did_you_mean

PUBLISHED = "published"
_SUFFIX = f"-{PUBLISHED}"

FORMATION_VARIANTS: tuple[str, ...] = get_args(Variant)
"""Of groups whose teams keep a formation."""

METHODS = ("auto", "cbs", "joint", "sequential")

METHOD_VARIANTS: tuple[str, ...] = (*METHODS, *(f"{method}{_SUFFIX}" for method in METHODS))
"""Of groups whose robots have goals of their own."""

VARIANTS = {False: FORMATION_VARIANTS, True: METHOD_VARIANTS}
"""What the variants of a group may be, by whether its goals are individual."""

_TASKS = {True: "individual goals", False: "formations"}


def check_variant(name: str, individual_goals: bool, key: str) -> None:
    """Refuse a variant that a group cannot be run with."""
    known = VARIANTS[individual_goals]
    if name in known:
        return
    if name in VARIANTS[not individual_goals]:
        other, this = _TASKS[not individual_goals], _TASKS[individual_goals]
        text = f"{short(name)} is for {other}, not for {this}"
    else:
        text = f"unknown value {short(name)}{did_you_mean(name, known)}"
    raise ScenarioError(text, key=key, choices=known)


def planner_settings(name: str, individual_goals: bool) -> dict[str, Any]:
    """What a variant sets in a scenario's planner section."""
    if not individual_goals:
        return {"variant": name}
    method, variant = _parts(name)
    return {"method": method, "variant": variant}


def changed(names: Iterable[str], method: str | None, variant: str | None) -> tuple[str, ...]:
    """Some of `METHOD_VARIANTS` with another method, another variant or both; each once.

    Raises:
        ScenarioError: There is no such method or variant.
    """
    for key, said, known in (
        ("planner.method", method, METHODS),
        ("planner.variant", variant, TEAM_VARIANTS),
    ):
        if said is not None and said not in known:
            text = f"unknown value {short(said)}{did_you_mean(str(said), known)}"
            raise ScenarioError(text, key=f"--set {key}", choices=known)
    found = ((method or own, variant or plain) for own, plain in (_parts(name) for name in names))
    return tuple(dict.fromkeys(f"{a}{_SUFFIX}" if b == PUBLISHED else a for a, b in found))


def _parts(name: str) -> tuple[str, str]:
    """Method and variant of one of `METHOD_VARIANTS`."""
    if name.endswith(_SUFFIX):
        return name.removesuffix(_SUFFIX), PUBLISHED
    return name, TEAM_VARIANTS[0]
