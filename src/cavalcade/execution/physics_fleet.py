"""The walking robots of a scenario."""

from __future__ import annotations

from cavalcade.errors import InputError, ScenarioError
from cavalcade.fleet import CommandDelay, LocalisationNoise
from cavalcade.fleet.mujoco import PhysicsGround, PhysicsSettings
from cavalcade.fleet.mujoco.fleet import MujocoFleet
from cavalcade.fleet.mujoco.ground import movable_spans
from cavalcade.fleet.mujoco.own_robot import own_robot
from cavalcade.fleet.mujoco.sensing import SensingErrors
from cavalcade.lattice.ground import make_ground
from cavalcade.locomotion.settings import GaitSettings
from cavalcade.scenario import Scenario, World


def with_own_robots(scenario: Scenario) -> Scenario:
    """The scenario with the robots of the MuJoCo models that it names.

    Raises:
        ScenarioError: Such a file cannot be used.
    """
    if all(robot.mjcf is None for robot in scenario.robots):
        return scenario
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


def physics_fleet(scenario: Scenario, world: World, turning: float | None = None) -> MujocoFleet:
    """The robots of a scenario in MuJoCo, standing at their starts on its ground.

    Args:
        scenario: The resolved one.
        world: Its ground.
        turning: Change of the yaw rate that they are allowed, rad/s²; None for the gait's own.

    Raises:
        InputError: MuJoCo is not installed.
    """
    execution = scenario.execution
    said = execution.physics
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
        noise=LocalisationNoise(execution.noise.position, execution.noise.heading),
        delay=CommandDelay(execution.delay.mean, execution.delay.jitter, execution.delay.drop),
        gait=None if turning is None else GaitSettings(turning=turning),
        sensing=SensingErrors(**said.state_noise.model_dump(), delay=said.state_delay),
        seed=scenario.seed,
    )
