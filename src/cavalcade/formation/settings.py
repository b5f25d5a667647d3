"""The formation planner's parameters, named as in Norén et al., and its variants.

The paper marks parameters with a tilde. `SIMULATION` and `LABORATORY` are the values of its two
experiments (section 3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

from cavalcade.errors import InputError
from cavalcade.values import MAX_VALUE, described, instance_of, number_in


@dataclass(frozen=True)
class SpringLaw:
    """How one spring-damper acts on the velocities of its two robots (eqs. 3 and 4).

    Attributes:
        k_rep, k_att: Stiffness when shortened and when stretched, 1/(m s).
        dv_max_att: Largest velocity change by attraction, m/s.
        b_att, b_rep: Damping while approaching and while drifting apart, without unit.
    """

    k_rep: float
    k_att: float
    dv_max_att: float
    b_att: float
    b_rep: float

    def __post_init__(self) -> None:
        for field in fields(self):
            number_in(getattr(self, field.name), field.name, 0.0)


@dataclass(frozen=True)
class Springs:
    """The laws a shape gives its connections: its sides' and its diagonals'."""

    sides: SpringLaw
    diagonals: SpringLaw

    def __post_init__(self) -> None:
        instance_of(self.sides, SpringLaw, "springs.sides")
        instance_of(self.diagonals, SpringLaw, "springs.diagonals")


SIMULATION_SPRINGS = Springs(
    sides=SpringLaw(k_rep=4.5, k_att=1.25, dv_max_att=0.40, b_att=0.10, b_rep=0.04),
    diagonals=SpringLaw(k_rep=3.0, k_att=0.90, dv_max_att=0.30, b_att=0.10, b_rep=0.04),
)
_LAB_LAW = SpringLaw(k_rep=4.0, k_att=2.0, dv_max_att=0.50, b_att=0.10, b_rep=0.10)
LABORATORY_SPRINGS = Springs(sides=_LAB_LAW, diagonals=_LAB_LAW)


_MAY_BE_ZERO = ("d_switch", "w_min_partial", "w_min_avoid", "v_min", "max_detour")
_MAY_BE_INFINITE = ("max_detour",)


@dataclass(frozen=True)
class FormationSettings:
    """Parameters of the planner. Lengths in m, speeds in m/s, normalised times in s.

    Attributes:
        r_max: Inflation radius of a robot.
        d_safe_a: Distance from the inflated obstacles at which the leader may go at full speed.
        d_safe_b: The same for followers, and for all near the goal.
        d_switch: Lead in ETA that a challenger needs to take over.
        lookahead: Normalised time to the partial goal, and to the goal's Final Goal state.
        w_min_partial: Least velocity-map value of a follower's partial goal.
        w_min_avoid: Velocity-map value up to which motion towards obstacles is fully removed.
        v_max_x, v_max_y: Semi-axes of the velocity ellipse along and across the body.
        v_min: Speed limit where the velocity map is 0. The experiments' 0.50 m/s equals v_max_x
            and makes this limit inert; the default lets it act.
        d_slowdown: Distance to the final goal from which on a robot slows down.
        max_detour: By which share of a way paths may be longer for the sake of room, where bodies
            pass with 0.30 m to spare on each side; inf for what the velocity maps make of it, as
            in the paper.
    """

    r_max: float = 0.30
    d_safe_a: float = 1.50
    d_safe_b: float = 0.50
    d_switch: float = 0.05
    lookahead: float = 5.0
    w_min_partial: float = 0.70
    w_min_avoid: float = 0.50
    v_max_x: float = 0.50
    v_max_y: float = 0.20
    v_min: float = 0.25
    d_slowdown: float = 0.40
    max_detour: float = math.inf

    def __post_init__(self) -> None:
        for field in fields(self):
            most = math.inf if field.name in _MAY_BE_INFINITE else MAX_VALUE
            value = number_in(getattr(self, field.name), field.name, 0.0, most)
            if value == 0.0 and field.name not in _MAY_BE_ZERO:
                raise InputError("expected a number above 0", key=field.name)
        if self.w_min_avoid >= 1.0:
            raise InputError("expected a number below 1", key="w_min_avoid")

    def with_values(self, **values: Any) -> FormationSettings:
        """A copy in which the given values that are not None stand instead."""
        return replace(self, **{name: v for name, v in values.items() if v is not None})


IMPROVED = FormationSettings(d_safe_a=0.80, v_min=0.35, max_detour=0.20)
"""Defaults of the variant `cavalcade`: shorter paths and more pace, as its safety filter allows."""

SIMULATION = FormationSettings(lookahead=5.0, v_min=0.50)
LABORATORY = FormationSettings(lookahead=2.5, v_min=0.50)
PRESETS: dict[str, tuple[FormationSettings, Springs]] = {
    "simulation": (SIMULATION, SIMULATION_SPRINGS),
    "laboratory": (LABORATORY, LABORATORY_SPRINGS),
}


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
    if not isinstance(name, str) or name not in VARIANTS:
        raise InputError(
            f"unknown variant {described(name)}", key="planner.variant", choices=VARIANTS
        )
    return VARIANTS[name]
