"""How the team plans and how the plan is carried out: `planner` and `execution`."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, Strict

from cavalcade.scenario.fields import (
    Choice,
    Fraction,
    Index,
    Length,
    NotNegative,
    Number,
    Point,
    Pose,
    Positive,
    Seconds,
    Section,
    Seed,
    Speed,
    in_time,
)
from cavalcade.scenario.ground import Obstacle
from cavalcade.scenario.task import FormationSection

Variant = Literal[
    "cavalcade",
    "cavalcade-fixed-roles",
    "cavalcade-no-lookahead",
    "cavalcade-no-springs",
    "cavalcade-no-avoidance",
    "cavalcade-no-recovery",
    "cavalcade-no-filter",
    "published",
    "fixed-roles",
    "no-lookahead",
    "no-springs",
    "no-avoidance",
    "virtual-structure",
    "behaviour-based",
]
Method = Literal["formation", "sequential", "joint", "cbs", "auto", "commands"]

TEAM_METHODS = ("sequential", "joint", "cbs", "auto")
"""Planners of individual goals."""

TEAM_VARIANTS = ("cavalcade", "published")
"""Variants of these."""

TEAM_KEYS = ("constraints", "conflict", "leaps", "improve", "margin")
"""Keys of `planner` for individual goals alone."""


class Budget(Section):
    """Limits on planning: iterations and seconds; null is no limit, or the planner's own.

    Iterations are cycles of a formation's planner, expansions of searches and trees with
    individual goals.
    """

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
    """What the planner is told of localisation and radio; null is what `execution` says.

    `tracking_error` is how far robots may be from where their motion limits foresee them, m; null
    is 0 for ideal robots and what was measured of their legs in physics.
    """

    noise: Noise | None = None
    delay: Delay | None = None
    tracking_error: Annotated[Number, Field(ge=0, le=1)] | None = None


class PlannerSection(Section):
    """The planner, its variant and the paper's parameters; null is the preset's or the default.

    `method` is `formation` for formations, `commands` for commands and one of the others, by
    default `auto`, for individual goals. These have `constraints` (`timed`: bodies of others
    count while they are there; `static`: always), `conflict` (which one is resolved first),
    `leaps` (whether legged robots may leap), `improve` (iterations spent on a better plan once
    there is one) and `margin` (by which bodies are grown, m: 0 by default for ideal robots, more
    for walking ones, which sway); the variant `published` means `static` and `first` unless they
    are given. What follows `budget` is for formations.

    Units: lengths m, speeds m/s, `lookahead` and `d_switch` seconds of normalised time; the `w_`
    values are velocities of the map between 0 and 1.
    """

    method: Method = "formation"
    variant: Variant = "cavalcade"
    constraints: Literal["timed", "static"] | None = None
    conflict: Literal["costly", "earliest", "first"] | None = None
    leaps: Annotated[bool, Strict()] | None = None
    improve: Annotated[int, Strict(), Field(ge=0, le=10**9)] | None = None
    margin: Annotated[Number, Field(ge=0, le=1)] | None = None
    budget: Budget = Budget()
    preset: Literal["simulation", "laboratory"] | None = None
    lookahead: Annotated[Number, Field(gt=0, le=1e4)] | None = None
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
    max_detour: NotNegative | None = None
    expect: Expectations = Expectations()


_KEYS = tuple(PlannerSection.model_fields)

FORMATION_KEYS = _KEYS[_KEYS.index("budget") + 1 :]
"""Keys of `planner` for formations alone."""


class StateNoise(Section):
    """Standard deviations of what a robot's own leg controller measures, at every step of physics.

    Of the trunk: `position` m, `velocity` m/s, `angle` rad (about each axis), `rate` rad/s; of
    each joint: `joint` rad, `joint_rate` rad/s.
    """

    position: Annotated[Number, Field(ge=0, le=10)] = 0.0
    velocity: Annotated[Number, Field(ge=0, le=10)] = 0.0
    angle: Annotated[Number, Field(ge=0, le=1)] = 0.0
    rate: Annotated[Number, Field(ge=0, le=10)] = 0.0
    joint: Annotated[Number, Field(ge=0, le=1)] = 0.0
    joint_rate: Annotated[Number, Field(ge=0, le=100)] = 0.0


class PhysicsSection(Section):
    """What robots with dynamics are like; of no account for ideal ones.

    `friction` is the coefficient between a robot and all it touches; `variation` half the width
    of the uniform distribution around 1 from which a factor on each robot's mass and one on its
    friction are drawn by the seed. `motor_limits` are the largest torques alone, or those that
    fall with speed besides. `state_noise` and `state_delay` (s) are of the state that the legs'
    controller works with, which is the true one by default.
    """

    friction: Annotated[Number, Field(gt=0, le=10)] = 0.8
    variation: Annotated[Number, Field(ge=0, lt=1)] = 0.0
    motor_limits: Literal["torque", "torque-speed"] = "torque"
    state_noise: StateNoise = StateNoise()
    state_delay: Annotated[Number, Field(ge=0, le=1)] = 0.0


class Move(Obstacle):
    """An obstacle that goes straight until its centre is at `to` (m), at `speed` m/s.

    If an obstacle of exactly this shape stands there, it is this one that moves; otherwise it
    appears and moves.
    """

    to: Point
    speed: Speed

    @property
    def obstacle(self) -> Obstacle:
        """The shape alone."""
        return Obstacle.model_construct(box=self.box, circle=self.circle, polygon=self.polygon)


Impulse = Annotated[Number, Field(ge=-1e4, le=1e4)]


class Push(Section):
    """A push on the trunk of a robot in physics: `impulse` x, y in N s, map frame, over `duration`.

    It begins with the planner's cycle.
    """

    robot: Index
    impulse: tuple[Impulse, Impulse]
    duration: Annotated[Positive, Field(le=10)] = 0.1


class Event(Choice):
    """One thing that happens `at` seconds of simulated time.

    `add` and `remove` an obstacle, `move` one, replace the `goals` or the `formation`, `lose` the
    robot of that index (from 0) or let it `rejoin`, `push` a robot in physics.
    """

    kinds = ("add", "remove", "move", "goals", "formation", "lose", "rejoin", "push")
    wanted = "expected `at` and exactly one thing that happens"

    at: Seconds
    add: Obstacle | None = None
    remove: Obstacle | None = None
    move: Move | None = None
    goals: Annotated[tuple[Pose, ...], Field(min_length=1, max_length=1000)] | None = None
    formation: FormationSection | None = None
    lose: Index | None = None
    rejoin: Index | None = None
    push: Push | None = None


class ExecutionSection(Section):
    """Who moves the robots, how long, how well, and what happens on the way.

    `rate` is the planner's, Hz; `timeout` seconds of simulated time. The backend `ideal` moves
    robots exactly as commanded within their limits; `mujoco` lets them walk.
    """

    backend: Literal["ideal", "mujoco"] = "ideal"
    rate: Annotated[Number, Field(ge=1, le=1000)] = 20.0
    timeout: Annotated[Number, Field(gt=0, le=86_400)] = 180.0
    noise: Noise = Noise()
    delay: Delay = Delay()
    physics: PhysicsSection = PhysicsSection()
    events: Annotated[tuple[Event, ...], Field(max_length=10_000), AfterValidator(in_time)] = ()
    seed: Seed = 0
