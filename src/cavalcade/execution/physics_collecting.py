"""From what a fleet in physics kept to the track of a run."""

from __future__ import annotations

from cavalcade.fleet import Fleet
from cavalcade.recording.physics_track import ContactEvent, FallEvent, PhysicsTrack


def track_of(fleet: Fleet, start: float) -> PhysicsTrack | None:
    """The track of a fleet since its clock showed `start` s; None of one that keeps none."""
    from cavalcade.fleet.physics.fleet import MujocoFleet

    if not isinstance(fleet, MujocoFleet):
        return None
    kept = fleet.samples()
    return PhysicsTrack(
        time=(kept.time - start).round(9),
        base=kept.qpos[..., :7],
        joints=kept.qpos[..., 7:],
        joint_rates=kept.joint_rates,
        torques=kept.torques,
        foot_forces=kept.foot_forces,
        contacts=tuple(
            ContactEvent(round(contact.time - start, 9), contact.robot, contact.part, contact.other)
            for contact in kept.contacts
        ),
        falls=tuple(FallEvent(round(fall.time - start, 9), fall.robot) for fall in fleet.falls),
    )
