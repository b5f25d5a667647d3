"""How the team plans and how the plan is carried out: `planner` and `execution`."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, Strict, field_validator

from cavalcade.scenario.events import Event
from cavalcade.scenario.fields import (
    Fraction,
    Length,
    NotNegative,
    Number,
    Positive,
    Seconds,
    Section,
    Seed,
    Speed,
    expected,
)

Variant = Literal[
    "cavalcade",
    "cavalcade-fixed-roles",
    "cavalcade-no-lookahead",
    "cavalcade-no-springs",
    "cavalcade-no-avoidance",
    "cavalcade-no-standoffs",
    "cavalcade-no-filter",
    "published",
    "fixed-roles",
    "no-lookahead",
    "no-springs",
    "no-avoidance",
    "virtual-structure",
    "behaviour-based",
]
_BODY_METHODS = ("sequential", "joint", "cbs", "auto")


class Budget(Section):
    """Limits on planning: cycles of the planner, and seconds of it; null is no limit."""

    iterations: Annotated[int, Strict(), Field(gt=0)] | None = None
    seconds: Positive | None = None


class Noise(Section):
    """Standard deviations of the localisation: m and rad."""

    position: Annotated[Number, Field(ge=0, le=100)] = 0.0
    heading: Annotated[Number, Field(ge=0, le=100)] = 0.0


class Delay(Section):
    """Of each command: mean delay and its standard deviation in s, fraction that is lost."""

    mean: Annotated[Number, Field(ge=0, le=60)] = 0.0
    jitter: Annotated[Number, Field(ge=0, le=60)] = 0.0
    drop: Fraction = 0.0


class Expectations(Section):
    """What the planner is told of localisation and radio; null is what `execution` says."""

    noise: Noise | None = None
    delay: Delay | None = None


class PlannerSection(Section):
    """The planner, its variant and the paper's parameters; null is the preset's or the default.

    Units: lengths m, speeds m/s, `lookahead` and `d_switch` seconds of normalised time; the `w_`
    values are velocities of the map between 0 and 1.
    """

    method: Literal["formation"] = "formation"
    variant: Variant = "cavalcade"
    preset: Literal["simulation", "laboratory"] | None = None
    lookahead: Annotated[Number, Field(gt=0, le=1e4)] | None = None
    budget: Budget = Budget()
    r_max: Length | None = None
    d_safe_a: Length | None = None
    d_safe_b: Length | None = None
    d_switch: Seconds | None = None
    w_min_partial: Fraction | None = None
    w_min_avoid: Annotated[Number, Field(ge=0, lt=1)] | None = None
    v_max_x: Speed | None = None
    v_max_y: Speed | None = None
    v_min: NotNegative | None = None
    d_slowdown: Length | None = None
    expect: Expectations = Expectations()

    @field_validator("method", mode="before")
    @classmethod
    def _method(cls, value: Any) -> Any:
        if value in _BODY_METHODS:
            raise expected(f"method {value} arrives with body planning; expected formation")
        return value


class ExecutionSection(Section):
    """Who moves the robots, how long, how well, and what happens on the way.

    `rate` is the planner's, Hz; `timeout` seconds of simulated time.
    """

    backend: Literal["ideal"] = "ideal"
    rate: Annotated[Number, Field(ge=1, le=1000)] = 20.0
    timeout: Annotated[Number, Field(gt=0, le=86_400)] = 180.0
    noise: Noise = Noise()
    delay: Delay = Delay()
    events: Annotated[tuple[Event, ...], Field(max_length=10_000)] = ()
    seed: Seed = 0

    @field_validator("backend", mode="before")
    @classmethod
    def _backend(cls, value: Any) -> Any:
        if value == "mujoco":
            raise expected("backend mujoco arrives with the physics; expected ideal")
        return value

    @field_validator("events")
    @classmethod
    def _in_time(cls, events: tuple[Event, ...]) -> tuple[Event, ...]:
        return tuple(sorted(events, key=lambda event: event.at))
