"""The walking robots of a scenario."""

from __future__ import annotations

from cavalcade.body.ground import make_ground
from cavalcade.fleet import CommandDelay, LocalisationNoise
from cavalcade.fleet.physics import PhysicsGround, PhysicsSettings
from cavalcade.fleet.physics.fleet import MujocoFleet
from cavalcade.fleet.physics.ground import movable_spans
from cavalcade.fleet.physics.sensing import SensingErrors
from cavalcade.scenario import Scenario, World


def physics_fleet(scenario: Scenario, world: World) -> MujocoFleet:
    """The robots of a scenario in MuJoCo, standing at their starts on its ground.

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
        sensing=SensingErrors(**said.state_noise.model_dump(), delay=said.state_delay),
        seed=scenario.seed,
    )
