"""Robots with full rigid-body dynamics in MuJoCo, an extra: `pip install 'cavalcade[physics]'`.

Importing this package does not load MuJoCo; making a simulator does.
"""

from cavalcade.fleet.physics.contacts import Contact, ContactRecorder
from cavalcade.fleet.physics.fleet import MujocoFleet
from cavalcade.fleet.physics.ground import PhysicsGround
from cavalcade.fleet.physics.own_robot import own_robot
from cavalcade.fleet.physics.settings import PhysicsSettings
from cavalcade.fleet.physics.simulator import TeamSimulator

__all__ = [
    "Contact",
    "ContactRecorder",
    "MujocoFleet",
    "PhysicsGround",
    "PhysicsSettings",
    "TeamSimulator",
    "own_robot",
]
