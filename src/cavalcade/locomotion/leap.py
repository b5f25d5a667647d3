"""Leaps: what one is to be, and how it is laid out from the feet that push to those that land."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cavalcade.errors import InputError
from cavalcade.geometry import GRAVITY, Array, wrap_angle
from cavalcade.locomotion.records import LEAP, Row
from cavalcade.locomotion.settings import Weights

Pose = tuple[float, float, float, float]


@dataclass(frozen=True)
class LeapManoeuvre:
    """A leap from one standing pose to another.

    Attributes:
        take_off, landing: Of the trunk seen from above, and the ground below it: x, y, z of the
            ground in m, yaw in rad; world frame.
        edges: m along the line from `take_off` to `landing` where the ground of the take-off ends
            and that of the landing begins, the same for a step; None where it does not break.
    """

    take_off: Pose
    landing: Pose
    edges: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name in ("take_off", "landing"):
            pose = getattr(self, name)
            if len(pose) != 4 or not np.isfinite(pose).all():
                raise InputError("expected x, y, z, yaw", key=name)
        if self.edges is not None and not (
            np.isfinite(self.edges).all() and self.edges[0] <= self.edges[1]
        ):
            raise InputError("expected two numbers, the second not smaller", key="edges")

    @property
    def direction(self) -> Array:
        """Unit vector `(2,)` from take-off to landing."""
        direction = np.array(self.landing[:2]) - np.array(self.take_off[:2])
        length = math.hypot(*direction)
        if length < 0.05:
            return np.array([math.cos(self.take_off[3]), math.sin(self.take_off[3])])
        return np.asarray(direction / length)


@dataclass(frozen=True)
class LeapSettings:
    """How robots leap. Heights are of the trunk's origin over the ground.

    Attributes:
        crouch, landing: How long these take, s.
        absorb: In the landing, how long sinking lasts, s.
        push: Shortest and longest push, s.
        squat: Lowest height in the crouch, m.
        lift, down: Heights at lift-off and touch-down, m.
        duck: At touch-down it is that much lower per m that the landing is higher: there is less to
            fall, and less to rise.
        lean: At lift-off the body is so far ahead of the feet's middle, and
        reach: at touch-down behind it, at a leap of `far` m or more; m.
        far: m.
        flight: Shortest flight, s.
        fastest: Greatest velocity at lift-off, m/s.
        tuck: In flight feet are drawn up so far below the centre of mass, m.
        margin: A foot's centre lands at least so far beyond an edge, m, and
        drop: that much further per m that the landing is lower, at most `clear` m: rear knees,
            which trail behind their hips, pass the edge.
        before: Front feet stand so far before an edge, m, and
        head: that much further per m that the landing is higher: the head rises past the edge;
        brink: that much further where it is lower: nobody steps onto a brink.
        pitch: In the squat, at lift-off and at touch-down, rad; noses go up with negative ones.
        weights, land_weights: Of squared errors of the state, as in `GaitSettings`.
        force_weight: Of squared forces, 1/N².
        mu: Friction that is counted on.
        max_force: On one foot, in body weights.
        step, interval: Of the horizon and between solutions, s.
        stiffness, joint_damping: Of flying legs' joints, N m/rad and N m s/rad.
        touch: Force from which a foot is known to stand, N.
    """

    crouch: float = 0.5
    landing: float = 0.35
    absorb: float = 0.2
    push: tuple[float, float] = (0.13, 0.22)
    squat: float = 0.19
    lift: float = 0.33
    down: float = 0.28
    duck: float = 0.25
    lean: float = 0.10
    reach: float = 0.10
    far: float = 0.7
    flight: float = 0.30
    fastest: float = 2.75
    tuck: float = 0.16
    margin: float = 0.05
    drop: float = 2.2
    clear: float = 0.26
    before: float = 0.04
    head: float = 0.5
    brink: float = 0.05
    pitch: tuple[float, float, float] = (0.0, 0.0, 0.0)
    weights: Weights = (5.0, 10.0, 5.0, 20.0, 20.0, 50.0, 0.1, 0.2, 0.2, 2.0, 2.0, 2.0)
    land_weights: Weights = (5.0, 5.0, 2.0, 4.0, 4.0, 50.0, 0.05, 0.05, 0.15, 0.6, 0.6, 0.6)
    force_weight: float = 2e-6
    mu: float = 0.6
    max_force: float = 1.6
    step: float = 0.025
    interval: float = 0.01
    stiffness: float = 60.0
    joint_damping: float = 1.5
    touch: float = 8.0


def plan_leap(
    manoeuvre: LeapManoeuvre,
    robot: Row,
    height: float,
    feet: Array,
    yaw: float,
    settings: LeapSettings,
) -> Row:
    """A row `()` of `LEAP` that begins where the robot, a row of `ROBOT`, stands.

    Its trunk's origin is at `height` then, m, turned by `yaw`, unwrapped, rad; the centres of its
    feet are at `feet` `(4, 3)`, world, m.

    Raises:
        InputError: The leap is too far or too high.
    """
    leap = np.zeros((), LEAP)
    along = manoeuvre.direction
    above, radius = float(robot["centre"][2]), float(robot["foot_radius"])
    # Where the feet push and where they land: turned with the trunk, and beyond the far edge.
    start = feet.mean(axis=0) - (0.0, 0.0, radius)
    turn = float(wrap_angle(manoeuvre.landing[3] - yaw))
    c, s = math.cos(yaw + turn), math.sin(yaw + turn)
    ahead = np.asarray(robot["hip"][:, 0])
    aside = np.asarray(robot["hip"][:, 1] + robot["side"])
    holds = np.empty((4, 3))
    holds[:, 0] = manoeuvre.landing[0] + c * ahead - s * aside
    holds[:, 1] = manoeuvre.landing[1] + s * ahead + c * aside
    holds[:, 2] = manoeuvre.landing[2] + radius
    bound = -math.inf
    if manoeuvre.edges is not None:
        bound = float(np.dot(manoeuvre.take_off[:2], along)) + manoeuvre.edges[1]
        lower = max(float(start[2]) - manoeuvre.landing[2], 0.0)
        bound += settings.margin + min(settings.drop * lower, settings.clear)
        short = bound - float((holds[:, :2] @ along).min())
        if short > 0.0:
            holds[:, :2] += short * along
    end = holds.mean(axis=0) - (0.0, 0.0, radius)
    # The centre of mass at lift-off and touch-down.
    far = float(np.dot(end[:2] - start[:2], along))
    share = min(max(far / settings.far, 0.0), 1.0)
    lift = np.append(start[:2] + share * settings.lean * along, start[2] + settings.lift + above)
    down = np.append(end[:2] - share * settings.reach * along, end[2] + settings.down + above)
    down[2] -= settings.duck * max(float(end[2] - start[2]), 0.0)
    flown = down - lift
    # The least speed that gets there leaves for this time; less would not clear an edge.
    flight = max(math.sqrt(2.0 * float(np.linalg.norm(flown)) / GRAVITY), settings.flight)
    velocity = flown / flight
    velocity[2] += 0.5 * GRAVITY * flight
    speed = float(np.linalg.norm(velocity))
    if speed > settings.fastest:
        raise InputError(
            f"a leap at {speed:.2f} m/s; legs reach {settings.fastest:.2f} m/s", key="landing"
        )
    # A push that reaches this velocity, from a squat that it begins in.
    stroke = settings.lift - settings.squat
    push = 2.0 * stroke / max(velocity[2], 0.1)
    push = min(max(push, settings.push[0]), settings.push[1])
    leap["lasts"] = (settings.crouch, push, flight, settings.landing)
    leap["began"] = -1.0
    leap["lift"], leap["down"] = lift, down
    leap["squat"] = lift - 0.5 * push * velocity
    leap["squat"][2] = max(leap["squat"][2], start[2] + settings.squat + above)
    leap["lift_velocity"] = velocity
    leap["down_velocity"] = velocity - (0.0, 0.0, GRAVITY * flight)
    leap["rest"] = np.append(end[:2], end[2] + height + above)
    leap["yaws"], leap["pitches"] = (yaw, yaw + turn), settings.pitch
    leap["foothold"], leap["along"], leap["bound"] = holds, along, bound
    leap["max_force"] = settings.max_force * float(robot["mass"]) * GRAVITY
    for name in (
        "absorb", "tuck", "weights", "land_weights", "force_weight", "mu", "step", "interval",
        "stiffness", "joint_damping", "touch",
    ):  # fmt: skip
        leap[name] = getattr(settings, name)
    return leap
