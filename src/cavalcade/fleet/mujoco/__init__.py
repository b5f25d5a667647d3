"""Robots with full rigid-body dynamics in MuJoCo, an extra: `pip install 'cavalcade[physics]'`.

Importing this package does not load MuJoCo; making a simulator does.
"""

from cavalcade.fleet.mujoco.fleet import MujocoFleet
from cavalcade.fleet.mujoco.ground import PhysicsGround
from cavalcade.fleet.mujoco.own_robot import own_robot
from cavalcade.fleet.mujoco.sampling import ContactRecorder
from cavalcade.fleet.mujoco.settings import PhysicsSettings
from cavalcade.fleet.mujoco.simulator import TeamSimulator

__all__ = [
    "ContactRecorder",
    "MujocoFleet",
    "PhysicsGround",
    "PhysicsSettings",
    "TeamSimulator",
    "own_robot",
]
