"""A simulated robot as RViz and Foxglove know it: its URDF, and the transforms of its links."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cavalcade.geometry import Array
from cavalcade.robots import LEGS, LINK_NAMES, RobotModel, body_of, urdf_of

Transform = tuple[str, str, Array]
"""Parent, child and the place `(7,)` of the child in it: x, y, z in m, quaternion x, y, z, w."""


class RobotFrames:
    """Names and places of one robot's frames.

    Args:
        model: The robot.
        name: That all of its frames begin with: `robot_0` has `robot_0/base_link`, the trunk's.

    Attributes:
        base: The trunk's frame.
        urdf: The robot's description; its links are called as the frames are.
        fixed: The frames that never change.
    """

    def __init__(self, model: RobotModel, name: str) -> None:
        self.base = f"{name}/base_link"
        self.urdf = urdf_of(model, name, root="base_link")
        self._body = body = body_of(model)
        if body is None:
            below = np.array([0.0, 0.0, -0.5 * model.height, 0.0, 0.0, 0.0, 1.0])
            self.fixed: list[Transform] = [(self.base, f"{name}/base", below)]
            return
        self._links = [self.base, *(f"{name}/{link}" for link in LINK_NAMES[1:])]
        self.fixed = [
            (f"{name}/{leg}_calf", f"{name}/{leg}_foot", np.array([*part.foot, 0.0, 0.0, 0.0, 1.0]))
            for leg, part in zip(LEGS, body.legs, strict=True)
        ]

    def legs(self, joints: Array | None) -> Iterator[Transform]:
        """The links of the legs at joint angles `(12,)`, rad."""
        if self._body is None or joints is None:
            return
        for number, place in enumerate(self._body.link_poses(joints)):
            parent = number if number % 3 else 0
            yield self._links[parent], self._links[number + 1], place
