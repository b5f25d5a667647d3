"""What is done at every physics step, compiled: motors' torques, their peaks, contacts."""

from __future__ import annotations

import numpy as np

from cavalcade.kernels import kernel

FOOT = 4  # index of `foot` in the parts
OTHERS = 2  # what is no robot: ground 0, obstacle 1; robot k counts as 2 + k


MOTOR = np.dtype(
    [
        ("limit", np.float64),  # largest torque, N m
        ("stall", np.float64),  # torque at rest, N m
        ("no_load", np.float64),  # speed without load, rad/s
        ("rate", np.int64),  # place of the joint's rate in MuJoCo's `qvel`
        ("place", np.int64),  # place of the motor in MuJoCo's `ctrl`
    ],
    align=True,
)
"""What a joint's motor can give, and where it is in MuJoCo's arrays."""


@kernel
def limit_torques(wanted, motors, torque_speed, qvel, given, ctrl):
    """Cut torques to what motors can give.

    Args:
        wanted: `(N, 12)` N m; values that are not numbers count as 0.
        motors: `(N, 12)` of `MOTOR`.
        torque_speed: Whether torque falls with speed where a motor drives.
        qvel, ctrl: MuJoCo's; `ctrl` is filled at the motors' places.
        given: `(N, 12)` filled with what is given, N m.
    """
    for k in range(wanted.shape[0]):
        for j in range(12):
            torque = wanted[k, j]
            if torque != torque:
                torque = 0.0
            motor = motors[k, j]
            most = motor.limit
            if torque_speed:
                rate = qvel[motor.rate]
                if torque * rate > 0.0:
                    most = min(most, max(motor.stall * (1.0 - abs(rate) / motor.no_load), 0.0))
            torque = min(max(torque, -most), most)
            given[k, j] = torque
            ctrl[motor.place] = torque


@kernel
def keep_peaks(torques, peaks):
    """Keep in `peaks` `(N, 12)` each joint's torque of largest magnitude; `torques` are newer."""
    for k in range(peaks.shape[0]):
        for j in range(peaks.shape[1]):
            if abs(torques[k, j]) > abs(peaks[k, j]):
                peaks[k, j] = torques[k, j]


@kernel
def add_contacts(contacts, kinds, step, quiet, impulses, seen, begun):
    """Add a step's forces on feet, and list the contacts that begin.

    Args:
        contacts: Of the step as MuJoCo has them, a tuple of `geoms` `(C, 2)`, the two shapes of
            each; `frames` `(C, 9)`, rows of its axes, of which the first is the normal, from the
            first shape to the second; `rows` `(C,)`, where its normal force, followed by two
            tangential ones, stands in `efforts`, negative for contacts without force; `efforts`
            `(E,)`, forces of constraints, N, with elliptic cones.
        kinds: `(G, 3)` of each shape: the robot or -1; its part, or 0 ground and 1 obstacle; leg.
        step: Number of the step.
        quiet: Steps without a contact after which the same one begins anew.
        impulses: `(N, 4, 3)` sums of the forces on feet over steps, map frame, N; added to.
        seen: `(N, 5, 2 + N)` last step of each robot's part with each other; changed.
        begun: `(B, 3)` filled with robot, part and other of contacts that begin.

    Returns:
        How many begin; those that `begun` has no room for are lost.
    """
    geoms, frames, rows, efforts = contacts
    count = 0
    for c in range(rows.shape[0]):
        row = rows[c]
        if row < 0:
            continue
        # Both shapes may be a robot's: each is looked at as the one that the other touches.
        for side in range(2):
            mine, its = geoms[c, side], geoms[c, 1 - side]
            robot = kinds[mine, 0]
            if robot < 0:
                continue
            part = kinds[mine, 1]
            if part == FOOT:
                sign = 1.0 if side == 1 else -1.0
                leg = kinds[mine, 2]
                for axis in range(3):
                    force = 0.0
                    for k in range(3):
                        force += frames[c, 3 * k + axis] * efforts[row + k]
                    impulses[robot, leg, axis] += sign * force
            other = kinds[its, 1] if kinds[its, 0] < 0 else OTHERS + kinds[its, 0]
            if part == FOOT and other == 0:
                continue
            # Everything but a foot on the ground is noted when it begins.
            before = seen[robot, part, other]
            seen[robot, part, other] = step
            begins = before < 0 or step - before > quiet
            if begins and count < begun.shape[0]:
                begun[count, 0], begun[count, 1], begun[count, 2] = robot, part, other
                count += 1
    return count
