"""What the scene shows of one moment, whatever it comes from: a run, real robots, a recording."""

from __future__ import annotations

from dataclasses import dataclass

from cavalcade.geometry import Array
from cavalcade.recording.status import PlannerStatus
from cavalcade.scenario import Obstacle


@dataclass(frozen=True)
class Snapshot:
    """One moment of N robots; map frame, SI units. The arrays must not be changed.

    Attributes:
        time: s since the run began.
        poses: `(N, 3)` true poses, or the best there are.
        commands: `(N, 3)` body-frame velocities; None where nobody is commanded.
        status: The policy's; None where there is none.
        trunks: `(N, 7)` x, y, z and quaternion x, y, z, w of the bodies; None where they stand
            on the ground at `poses`.
        joints: `(12,)` angles of each robot's legs, rad, as `QuadrupedDescription.joints` has
            them; None for robots whose legs are not known, which the scene lets step.
        obstacles: Those that stand now and are not there all the time.
        lost: Robots that are no part of the team.
    """

    time: float
    poses: Array
    commands: Array | None = None
    status: PlannerStatus | None = None
    trunks: Array | None = None
    joints: tuple[Array | None, ...] | None = None
    obstacles: tuple[Obstacle, ...] = ()
    lost: tuple[int, ...] = ()
