"""Every robot's step, whatever it is doing, compiled."""

from __future__ import annotations

from numba import njit

from cavalcade.locomotion._control import control
from cavalcade.locomotion._leap import leap_on
from cavalcade.locomotion.records import LEAPING


@njit(cache=True)
def move_team(robots, gaits, states, leaps, bodies, ground, frame, time, qpos, qvel, feet,
              torques):  # fmt: skip
    """Torques for every robot: `control` for those that walk, `leap_on` for those that leap.

    Args:
        robots, gaits, states, leaps: `(N,)` of `ROBOT`, `GAIT`, `STATE`, `LEAP`; the last two
            change.
        bodies: `(N,)` of `BODY`, overwritten; a row of an array made here would be freed while it
            is in use, as rows do not keep their array alive.
        ground, frame: `Ground`, and the pose of its grid in the world `(3,)`.
        time: Now, s.
        qpos, qvel: `(N, 19)`, `(N, 18)` as MuJoCo has them.
        feet: `(N, 4)` normal forces on the feet, N.
        torques: `(N, 12)`, overwritten, N m.
    """
    for n in range(robots.shape[0]):
        if states[n].mode == LEAPING:
            leap_on(robots[n], states[n], leaps[n], bodies[n], time, qpos[n], qvel[n], feet[n],
                    torques[n])  # fmt: skip
        else:
            control(robots[n], gaits[n], states[n], bodies[n], ground, frame, time, qpos[n],
                    qvel[n], feet[n], torques[n])  # fmt: skip
