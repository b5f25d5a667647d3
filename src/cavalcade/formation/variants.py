"""What the planner's variants switch on and off."""

from __future__ import annotations

from dataclasses import dataclass, replace

from cavalcade.errors import InputError
from cavalcade.formation.settings import IMPROVED, FormationSettings


@dataclass(frozen=True)
class Variant:
    """Parts of the planner.

    Attributes:
        name: What scenario files and the command line call it.
        adaptive_roles: Leader and roles follow the situation; else they stay as first assigned.
        lookahead: Partial goals lie ahead on the leader's path; else at the leader's own place.
        springs: Virtual springs and dampers act.
        avoidance: The obstacle avoidance layer acts (eq. 6).
        common_plan: There is a plan for the team; else each robot follows weighted behaviours.
        rigid: The shape is planned through the map as one rigid body.
        improved: Our additions: pacing, less inflation where paths are barred, dynamic avoidance.
        recovery: Deadlocks are detected and resolved; stuck robots turn where there is room.
        filter: The safety filter keeps footprints apart.
    """

    name: str
    adaptive_roles: bool = True
    lookahead: bool = True
    springs: bool = True
    avoidance: bool = True
    common_plan: bool = True
    rigid: bool = False
    improved: bool = False
    recovery: bool = False
    filter: bool = False


_OURS = Variant("cavalcade", improved=True, recovery=True, filter=True)

VARIANTS: dict[str, Variant] = {
    variant.name: variant
    for variant in (
        _OURS,
        replace(_OURS, name="cavalcade-fixed-roles", adaptive_roles=False),
        replace(_OURS, name="cavalcade-no-lookahead", lookahead=False),
        replace(_OURS, name="cavalcade-no-springs", springs=False),
        replace(_OURS, name="cavalcade-no-avoidance", avoidance=False),
        replace(_OURS, name="cavalcade-no-recovery", recovery=False),
        replace(_OURS, name="cavalcade-no-filter", filter=False),
        Variant("published"),
        Variant("fixed-roles", adaptive_roles=False),
        Variant("no-lookahead", lookahead=False),
        Variant("no-springs", springs=False),
        Variant("no-avoidance", avoidance=False),
        Variant("virtual-structure", adaptive_roles=False, springs=False, rigid=True),
        Variant("behaviour-based", adaptive_roles=False, springs=False, common_plan=False),
    )
}


def default_settings(name: str) -> FormationSettings:
    """The parameters a variant has if none are given: the paper's but for our own variant."""
    return IMPROVED if variant_named(name).improved else FormationSettings()


def variant_named(name: str) -> Variant:
    """The variant of that name.

    Raises:
        InputError: There is none; the message lists those there are.
    """
    if name not in VARIANTS:
        raise InputError(f"unknown variant {name!r}", key="planner.variant", choices=VARIANTS)
    return VARIANTS[name]
