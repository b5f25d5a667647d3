"""The robots of a scenario at their starts: ideal, able to follow a plan, or walking in physics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.errors import InputError, ScenarioError
from cavalcade.fleet import CommandDelay, IdealFleet, LocalisationNoise
from cavalcade.geometry import GRAVITY
from cavalcade.geometry.trajectory import FLIGHT, Trajectory
from cavalcade.lattice.ground import make_ground
from cavalcade.robots import RobotModel
from cavalcade.scenario import Scenario, World

if TYPE_CHECKING:
    from cavalcade.fleet.mujoco import MujocoFleet
    from cavalcade.fleet.ros2 import Ros2Fleet
    from cavalcade.fleet.unitree import Go2Fleet

PATIENCE = 15.0
"""How long robots on a network are waited for, s."""

_SIDEWAYS = 1e-3
"""Of a robot that cannot move sideways, m/s."""


def ideal_fleet(scenario: Scenario) -> IdealFleet:
    """Ideal robots with the scenario's noise and delays."""
    return IdealFleet(scenario.models, scenario.starts, **_imperfections(scenario))


def tracking_fleet(scenario: Scenario, paths: Sequence[Trajectory | None]) -> IdealFleet:
    """Ideal robots that are able to follow these trajectories, and nothing more."""
    models = [
        tracking_model(model, path is not None and bool(np.any(path.phase == FLIGHT)))
        for model, path in zip(scenario.models, paths, strict=True)
    ]
    return IdealFleet(models, scenario.starts, seed=scenario.seed)


def tracking_model(model: RobotModel, leaps: bool) -> RobotModel:
    """The model with the limits that plans keep to, in the place of those under formations.

    Legs that leap push with their largest force.
    """
    if model.drive == "legged" and model.legs is not None:
        legs = model.legs
        return model.with_limits(
            max_speed_x=legs.v_max,
            max_speed_y=legs.v_max,
            max_yaw_rate=legs.yaw_rate,
            max_acceleration=legs.mu * GRAVITY * (legs.grf_max if leaps else 1.0),
            max_yaw_acceleration=math.inf,
        )
    second = model.drive.endswith("-2")
    if model.drive.startswith("unicycle"):
        # The limit is that of the speed; in a bend the velocity turns besides.
        bend = model.max_speed_x * model.max_yaw_rate
        return model.with_limits(
            max_speed_y=_SIDEWAYS,
            max_acceleration=math.hypot(model.max_acceleration, bend) if second else math.inf,
            max_yaw_acceleration=model.max_yaw_acceleration if second else math.inf,
        )
    return model.with_limits(
        max_speed_y=model.max_speed_x,
        max_acceleration=model.max_acceleration if second else math.inf,
        max_yaw_acceleration=math.inf,
    )


def physics_fleet(scenario: Scenario, world: World, turning: float | None = None) -> MujocoFleet:
    """Robots in MuJoCo, standing on the scenario's ground.

    They may change their yaw rate by `turning`, rad/s², instead of what the gait's settings say.
    """
    from cavalcade.fleet.mujoco import MujocoFleet, PhysicsGround, PhysicsSettings
    from cavalcade.fleet.mujoco.ground import movable_spans
    from cavalcade.fleet.mujoco.sensing import SensingErrors
    from cavalcade.locomotion.settings import GaitSettings

    said = scenario.execution.physics
    return MujocoFleet(
        scenario.models,
        scenario.starts,
        ground=PhysicsGround.of_world(world),
        footing=make_ground(world.map, world.terrain),
        origin=world.map.origin,
        obstacles=movable_spans(world),
        physics=PhysicsSettings(
            friction=said.friction,
            variation=said.variation,
            torque_speed=said.motor_limits == "torque-speed",
            seed=scenario.seed,
        ),
        gait=None if turning is None else GaitSettings(turning=turning),
        sensing=SensingErrors(**said.state_noise.model_dump(), delay=said.state_delay),
        **_imperfections(scenario),
    )


def ros2_fleet(scenario: Scenario) -> Ros2Fleet:
    """Robots `robot_0`, `robot_1` and so on of a ROS 2 graph, once all have been heard.

    Raises:
        InputError: ROS 2 is not there.
        FleetError: Somebody was not heard; it says who and where.
    """
    from cavalcade.fleet.ros2 import Ros2Fleet, scenario_robots

    fleet = Ros2Fleet(scenario_robots(len(scenario.robots)))
    try:
        fleet.start(PATIENCE)
    except BaseException:
        fleet.close()
        raise
    return fleet


def go2_fleet(scenario: Scenario) -> Go2Fleet:
    """Go2s at the scenario's starts, once all have been heard; nobody has stood up yet.

    Raises:
        InputError: The vendor's SDK is not there.
        FleetError: Somebody was not heard; it says who and where.
    """
    from cavalcade.fleet.unitree import Go2Fleet, Go2Link

    said = scenario.execution.unitree
    links = [
        Go2Link(robot.domain, robot.interface, "sport", robot.offset, robot.battery_min)
        for robot in said.robots
    ]
    fleet = Go2Fleet(links, starts=scenario.starts, lie_down=said.lie_down)
    try:
        fleet.connect(PATIENCE)
    except BaseException:
        fleet.close()
        raise
    return fleet


def with_own_robots(scenario: Scenario) -> Scenario:
    """The scenario with the robots of the MuJoCo models that it names.

    Raises:
        ScenarioError: Such a file cannot be used.
    """
    if all(robot.mjcf is None for robot in scenario.robots):
        return scenario
    from cavalcade.fleet.mujoco.own_robot import own_robot

    models = []
    for index, (robot, model) in enumerate(zip(scenario.robots, scenario.models, strict=True)):
        if robot.mjcf is not None:
            try:
                model = own_robot(robot.mjcf, like=model)
            except InputError as error:
                raise ScenarioError(
                    str(error), file=scenario.file, key=f"robots[{index}].mjcf"
                ) from None
        models.append(model)
    return scenario.with_models(models)


def _imperfections(scenario: Scenario) -> dict[str, Any]:
    """Noise, delays and the seed, as fleets take them."""
    noise, delay = scenario.execution.noise, scenario.execution.delay
    return {
        "noise": LocalisationNoise(noise.position, noise.heading),
        "delay": CommandDelay(delay.mean, delay.jitter, delay.drop),
        "seed": scenario.seed,
    }
