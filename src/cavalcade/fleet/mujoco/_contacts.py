"""Contacts of one physics step added to what was seen before, compiled."""

from __future__ import annotations

from numba import njit

FOOT = 4
"""Index of `foot` in the parts."""

OTHERS = 2
"""What is no robot: ground 0, obstacle 1; robot k counts as 2 + k."""


@njit(cache=True)
def note(step, robot, part, other, quiet, seen, begun, count):
    """Keep a contact that is not a foot on the ground; the new number of begun ones."""
    before = seen[robot, part, other]
    seen[robot, part, other] = step
    if (before >= 0 and step - before <= quiet) or count >= begun.shape[0]:
        return count
    begun[count, 0], begun[count, 1], begun[count, 2] = robot, part, other
    return count + 1


@njit(cache=True)
def add_contacts(geoms, frames, rows, efforts, kinds, step, quiet, impulses, seen, begun):
    """Add the forces on feet, and list the contacts that begin.

    Args:
        geoms: `(C, 2)` the two shapes of each contact.
        frames: `(C, 9)` rows of its axes; the first is the normal, from the first shape to the
            second.
        rows: `(C,)` where its normal force, followed by two tangential ones, stands in `efforts`;
            negative for contacts without force.
        efforts: `(E,)` forces of constraints, N; cones are elliptic.
        kinds: `(G, 3)` of each shape: the robot or -1; its part, or 0 ground and 1 obstacle; leg.
        step: Number of the step.
        quiet: Steps without a contact after which the same one begins anew.
        impulses: `(N, 4, 3)` sums of the forces on feet over steps, map frame, N; added to.
        seen: `(N, 5, 2 + N)` last step of each robot's part with each other; changed.
        begun: `(B, 3)` filled with robot, part and other of contacts that begin.

    Returns:
        How many begin; those that `begun` has no room for are lost.
    """
    count = 0
    for c in range(rows.shape[0]):
        row = rows[c]
        if row < 0:
            continue
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
            if part != FOOT or other != 0:
                count = note(step, robot, part, other, quiet, seen, begun, count)
    return count
