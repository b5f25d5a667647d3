"""What body planners need to know of a robot with legs."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class LegModel:
    """Figures of a quadruped for planning its body's motion over terrain.

    Heights are clearances of the body's centre above the ground. The trunk that terrain is
    tested against is smaller than the footprint that keeps robots apart.

    Attributes:
        h_min, h_nom, h_max: Least clearance, that of walking, and the reach of the legs, m.
        v_nom, v_max: Walking speed and the largest speed of the body, m/s.
        yaw_rate: Largest when walking in a bend or turning on the spot, rad/s.
        acceleration: That walking robots speed up and slow down with, m/s².
        trunk_length, trunk_width, trunk_height: m.
        hip_x, hip_y: Hips stand at (±hip_x, ±hip_y) in the body frame, m.
        mass: kg.
        mu: Friction of the ground, which bounds horizontal accelerations by mu g.
        grf_max: Largest ground reaction force in body weights.
        gait_period, duty: Of the trot: s, and the share of it that a foot stands.
        swing_height: Of a foot over the ground between steps, m.
        source: Where the figures come from.
    """

    h_min: float
    h_nom: float
    h_max: float
    v_nom: float
    v_max: float
    yaw_rate: float
    acceleration: float
    trunk_length: float
    trunk_width: float
    trunk_height: float
    hip_x: float
    hip_y: float
    mass: float
    mu: float
    grf_max: float
    gait_period: float
    duty: float
    swing_height: float
    source: str


SPIRIT = LegModel(
    h_min=0.075,
    h_nom=0.30,
    h_max=0.375,
    v_nom=0.75,
    v_max=2.0,
    yaw_rate=1.2,
    acceleration=1.0,
    trunk_length=0.3,
    trunk_width=0.3,
    trunk_height=0.05,
    hip_x=0.2263,
    hip_y=0.07,
    mass=13.0,
    mu=0.25,
    grf_max=5.0,
    gait_period=0.36,
    duty=0.5,
    swing_height=0.07,
    source="Quad-SDK: its global body planner's parameters and its description of Spirit 40; "
    "yaw rate and acceleration as for formations",
)
GO1 = replace(
    SPIRIT,
    h_nom=0.25,
    hip_x=0.1881,
    hip_y=0.04675,
    mass=12.0,
    source="Unitree's description of Go1: hips; Quad-SDK's parameters for Go1: nominal height, "
    "mass; the rest as for Spirit, the gait too: it is the one that leg control walks with",
)
GO2 = replace(
    SPIRIT,
    h_nom=0.26,
    hip_x=0.1934,
    hip_y=0.0465,
    mass=15.0,
    source="Unitree's description and data sheet of Go2: hips, mass; Quad-SDK's parameters for "
    "Go2: nominal height; the rest as for Spirit, the gait too",
)
