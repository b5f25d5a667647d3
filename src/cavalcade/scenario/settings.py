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
    NotNegativeOrInf,
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
    """Limits on planning; null is no limit, or the planner's own.

    Attributes:
        iterations: Cycles of a formation's planner; with individual goals, expansions of searches
            and trees.
        seconds (s): Wall-clock time.
    """

    iterations: Annotated[int, Strict(), Field(gt=0)] | None = None
    seconds: Positive | None = None


class Noise(Section):
    """Standard deviations of the localisation.

    Attributes:
        position (m): Of x and of y.
        heading (rad): Of yaw.
    """

    position: Annotated[Number, Field(ge=0, le=100)] = 0.0
    heading: Annotated[Number, Field(ge=0, le=100)] = 0.0


class Delay(Section):
    """How late commands arrive, each by itself.

    Attributes:
        mean (s): Mean delay.
        jitter (s): Its standard deviation.
        drop: Share of the commands that are lost.
    """

    mean: Annotated[Number, Field(ge=0, le=60)] = 0.0
    jitter: Annotated[Number, Field(ge=0, le=60)] = 0.0
    drop: Fraction = 0.0


class Expectations(Section):
    """What the planner is told of localisation and radio; null is what `execution` says.

    Attributes:
        noise: Of the localisation.
        delay: Of the commands.
        tracking_error (m): How far robots may be from where their motion limits foresee them; null
            is 0 for ideal robots and what was measured of their legs in physics.
    """

    noise: Noise | None = None
    delay: Delay | None = None
    tracking_error: Annotated[Number, Field(ge=0, le=1)] | None = None


class PlannerSection(Section):
    """The planner, its variant and its parameters; null is the preset's or the default.

    What follows `budget` is for formations, `constraints` to `margin` for individual goals.

    Attributes:
        method: `formation` for formations, `commands` for commands; with individual goals one of
            the others, by default `auto`.
        variant: Of the planner: the default, or one to compare it with.
        constraints: Whether bodies of others count while they are there (`timed`, the default)
            or always (`static`, the default of `published`).
        conflict: Which conflict is resolved first; by default `costly`, in `published` `first`.
        leaps: Whether robots with legs may leap; they may by default.
        improve: Iterations spent on a better plan once there is one; 0 by default.
        margin (m): By how much bodies are inflated: 0 by default for ideal robots, 0.05 for walking
            ones, which sway.
        despeckle (m): Groups of obstacle cells that fit into a square of this side are taken out
            of the map that the planner is given; the world keeps them, and what drives over one
            has collided.
        budget: Limits on planning.
        preset: Parameters of one of the paper's two experiments.
        lookahead (s): Normalised time from the leader to the partial goal.
        r_max (m): Inflation radius of a robot.
        d_safe_a (m): Distance from inflated obstacles from which on the leader goes at full speed.
        d_safe_b (m): The same for followers, and for all near the goal.
        d_switch (s): Normalised time by which a challenger has to be ahead to take the lead.
        w_min_partial: Least value of the velocity map at a partial goal.
        w_min_avoid: Value of the velocity map at which obstacle avoidance is full.
        v_max_x (m/s): Largest speed along the body.
        v_max_y (m/s): Largest speed across it.
        v_min (m/s): Speed limit where the velocity map is 0.
        d_slowdown (m): Distance from its final slot at which a robot begins to slow down.
        max_detour: By which share of a way paths may be longer for the sake of room, where bodies
            pass with 0.30 m to spare on each side; inf as in the paper.
        expect: What the planner is told of localisation and radio.
    """

    method: Method = "formation"
    variant: Variant = "cavalcade"
    constraints: Literal["timed", "static"] | None = None
    conflict: Literal["costly", "earliest", "first"] | None = None
    leaps: Annotated[bool, Strict()] | None = None
    improve: Annotated[int, Strict(), Field(ge=0, le=10**9)] | None = None
    margin: Annotated[Number, Field(ge=0, le=1)] | None = None
    despeckle: Annotated[Number, Field(ge=0, le=1)] = 0.0
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
    max_detour: NotNegativeOrInf | None = None
    expect: Expectations = Expectations()


_KEYS = tuple(PlannerSection.model_fields)

FORMATION_KEYS = _KEYS[_KEYS.index("budget") + 1 :]
"""Keys of `planner` for formations alone."""


class StateNoise(Section):
    """Standard deviations of what leg control measures, at every step of physics.

    Attributes:
        position (m): Of the trunk.
        velocity (m/s): Of the trunk.
        angle (rad): Of the trunk, about each axis.
        rate (rad/s): Of the trunk, about each axis.
        joint (rad): Of each joint.
        joint_rate (rad/s): Of each joint.
    """

    position: Annotated[Number, Field(ge=0, le=10)] = 0.0
    velocity: Annotated[Number, Field(ge=0, le=10)] = 0.0
    angle: Annotated[Number, Field(ge=0, le=1)] = 0.0
    rate: Annotated[Number, Field(ge=0, le=10)] = 0.0
    joint: Annotated[Number, Field(ge=0, le=1)] = 0.0
    joint_rate: Annotated[Number, Field(ge=0, le=100)] = 0.0


class PhysicsSection(Section):
    """What robots with dynamics are like; of no account for ideal ones.

    Attributes:
        friction: Coefficient between a robot and all it touches.
        variation: Half width of the uniform distribution around 1 from which a factor on each
            robot's mass and one on its friction are drawn by the seed.
        motor_limits: Largest torques alone, or torques that fall with speed, too.
        state_noise: Of the state that leg control works with, which is the true one by default.
        state_delay (s): How old that state is.
    """

    friction: Annotated[Number, Field(gt=0, le=10)] = 0.8
    variation: Annotated[Number, Field(ge=0, lt=1)] = 0.0
    motor_limits: Literal["torque", "torque-speed"] = "torque"
    state_noise: StateNoise = StateNoise()
    state_delay: Annotated[Number, Field(ge=0, le=1)] = 0.0


class Move(Obstacle):
    """An obstacle that goes straight until its centre is somewhere else.

    If an obstacle of exactly this shape stands there, it is this one that moves; otherwise it
    appears and moves.

    Attributes:
        to (m): Where its centre [x, y] ends, of a polygon the mean of its corners.
        speed (m/s): How fast it goes.
    """

    to: Point
    speed: Speed

    @property
    def obstacle(self) -> Obstacle:
        """The shape alone."""
        return Obstacle.model_construct(box=self.box, circle=self.circle, polygon=self.polygon)


Impulse = Annotated[Number, Field(ge=-1e4, le=1e4)]


class Push(Section):
    """A push on the trunk of a robot in physics; it begins with the planner's cycle.

    Attributes:
        robot: Which one, from 0.
        impulse (N s): Its x and y in the map frame.
        duration (s): How long it lasts.
    """

    robot: Index
    impulse: tuple[Impulse, Impulse]
    duration: Annotated[Positive, Field(le=10)] = 0.1


class Event(Choice):
    """One thing that happens at some time.

    Attributes:
        at (s): When, in simulated time.
        add: An obstacle appears.
        remove: The obstacle of exactly this shape disappears.
        move: An obstacle moves.
        goals (m, m, rad): Poses [x, y, yaw] in the place of the goals so far.
        formation: A shape in the place of the one so far.
        lose: The robot of this index, from 0, stops for good and is no longer part of the team.
        rejoin: The lost robot of this index is part of the team again.
        push: A robot is pushed, in physics.
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


class Go2Section(Section):
    """Where a Go2 is on the network; each needs a domain or an interface of its own.

    Attributes:
        domain: DDS domain; a robot as it is delivered is in 0.
        interface: Network interface that it is behind; null is the one that the system prefers.
        offset (m, m, rad): Pose of its odometry's origin in the map; null: it stands at its start.
        battery_min (%): Charge below which the team stops.
    """

    domain: Annotated[int, Strict(), Field(ge=0, le=232)] = 0
    interface: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    offset: Pose | None = None
    battery_min: Annotated[Number, Field(ge=0, le=100)] = 20.0


class UnitreeSection(Section):
    """How Go2s are reached by backend `unitree`; of no account for others.

    Attributes:
        robots: One for each robot of the team, in its order.
        lie_down: Whether they lie down at the end; otherwise they stay standing.
    """

    robots: Annotated[tuple[Go2Section, ...], Field(max_length=256)] = ()
    lie_down: Annotated[bool, Strict()] = False


class ExecutionSection(Section):
    """Who moves the robots, how long, how well, and what happens on the way.

    Attributes:
        backend: `ideal` moves robots exactly as commanded within their limits; `mujoco` lets them
            walk on legs in physics; `ros2` are robots on a ROS 2 graph, `unitree` Go2s without ROS.
        rate (Hz): How often the planner is asked.
        timeout (s): Simulated time after which the run ends.
        noise: Of the localisation that the planner works with.
        delay: Of the commands.
        physics: What robots with dynamics are like.
        unitree: Where Go2s are on the network.
        events: What happens on the way, in any order.
        seed: Of everything random.
    """

    backend: Literal["ideal", "mujoco", "ros2", "unitree"] = "ideal"
    rate: Annotated[Number, Field(ge=1, le=1000)] = 20.0
    timeout: Annotated[Number, Field(gt=0, le=86_400)] = 180.0
    noise: Noise = Noise()
    delay: Delay = Delay()
    physics: PhysicsSection = PhysicsSection()
    unitree: UnitreeSection = UnitreeSection()
    events: Annotated[tuple[Event, ...], Field(max_length=10_000), AfterValidator(in_time)] = ()
    seed: Seed = 0
