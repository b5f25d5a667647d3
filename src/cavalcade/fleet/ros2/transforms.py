"""Poses of robots from TF, where `tf2_ros` is there."""

from __future__ import annotations

import importlib
from typing import Any

from cavalcade.errors import InputError
from cavalcade.fleet.ros2.graph import Graph
from cavalcade.fleet.ros2.messages import PoseReport, read_transform


class TransformPoses:
    """Looks transforms up that somebody publishes on `/tf`.

    Raises:
        InputError: `tf2_ros` is not there.
    """

    def __init__(self, graph: Graph) -> None:
        try:
            self._tf2: Any = importlib.import_module("tf2_ros")
        except ImportError:
            raise InputError(
                "poses from tf need tf2_ros, which comes with a ROS 2 distribution; expected "
                "another pose type",
                key="pose_type",
                choices=("PoseStamped", "PoseWithCovarianceStamped", "Odometry"),
            ) from None
        from rclpy.time import Time

        self._latest = Time()
        self._buffer = self._tf2.Buffer(node=graph.node)
        self._listener = self._tf2.TransformListener(self._buffer, graph.node)

    def newest(self, frame: str, child: str) -> PoseReport | None:
        """Where `child` is in `frame`, None as long as nobody has said that."""
        try:
            found = self._buffer.lookup_transform(frame, child, self._latest)
        except self._tf2.TransformException:
            return None
        return read_transform(found)
