"""One node on the ROS 2 graph, with a thread of its own that hands messages on."""

from __future__ import annotations

import threading
import time as wall
from collections.abc import Callable
from typing import Any, Self

from cavalcade.fleet.ros2.availability import load_rclpy, message_type

_PATIENCE = 2.0
"""Longest wait for the thread and for acknowledgements at the end, s."""


class Graph:
    """A context, one node and the thread in which all its callbacks run, one after another.

    Several may live in one process. Any thread may publish. A callback that raises is not lost:
    `failure` has the first one, and `on_failure` is called with each; the others go on.

    Args:
        name: The node's.
        namespace: The node's.
        use_sim_time: Whether time is that of `/clock`.
        make_node: Makes another kind of node, such as one with a life cycle; it is called as
            `rclpy.node.Node` is.

    Raises:
        InputError: ROS 2 is not there.
    """

    def __init__(
        self,
        name: str,
        namespace: str = "",
        *,
        use_sim_time: bool = False,
        make_node: Callable[..., Any] | None = None,
        on_failure: Callable[[Exception], None] | None = None,
    ) -> None:
        rclpy = load_rclpy()
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from rclpy.parameter import Parameter

        self._context = rclpy.Context()
        # A context of one's own leaves the process's signals alone.
        rclpy.init(context=self._context)
        self._executor: Any = None
        try:
            self.node: Any = (make_node or Node)(
                name,
                namespace=namespace,
                context=self._context,
                parameter_overrides=[Parameter("use_sim_time", value=use_sim_time)],
            )
            self._executor = SingleThreadedExecutor(context=self._context)
            self._executor.add_node(self.node)
        except BaseException:
            self._context.try_shutdown()
            raise
        self.failure: Exception | None = None
        self._on_failure = on_failure
        self._closed = False
        self._thread = threading.Thread(target=self._spin, name=f"ros2-{name}", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def time(self) -> float:
        """Now, s: ROS time, which is that of `/clock` where sim time is used, else the wall's."""
        return float(self.node.get_clock().now().nanoseconds) * 1e-9

    @property
    def sim_time(self) -> bool:
        """Whether time is that of `/clock`."""
        return bool(self.node.get_clock().ros_time_is_active)

    def use_sim_time(self, wanted: bool) -> None:
        """Take time from `/clock`, or from the wall."""
        from rclpy.parameter import Parameter

        self.node.set_parameters([Parameter("use_sim_time", value=wanted)])

    def publisher(self, message: str, topic: str, qos: Any) -> Any:
        """A publisher of messages such as `geometry_msgs/msg/Twist`."""
        return self.node.create_publisher(message_type(message), topic, qos)

    def subscribe(self, message: str, topic: str, callback: Callable[[Any], None], qos: Any) -> Any:
        """Have a function called with each message, in the graph's thread."""
        handle = self.guarded(callback)
        return self.node.create_subscription(message_type(message), topic, handle, qos)

    def every(self, period: float, callback: Callable[[], None]) -> Any:
        """Have a function called every `period` s of the wall's time, in the graph's thread."""
        from rclpy.clock import Clock
        from rclpy.clock_type import ClockType

        steady = Clock(clock_type=ClockType.STEADY_TIME)
        return self.node.create_timer(period, self.guarded(callback), clock=steady)

    def guarded(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, whose errors are kept instead of ending the graph's thread."""

        def handle(*arguments: Any) -> Any:
            try:
                return function(*arguments)
            except Exception as error:
                self._failed(error)
                return None

        return handle

    def close(self) -> None:
        """Leave the graph; a second call does nothing."""
        if self._closed:
            return
        self._closed = True
        self._executor.shutdown(timeout_sec=_PATIENCE)
        if threading.current_thread() is not self._thread:
            self._thread.join(_PATIENCE)
        self.node.destroy_node()
        self._context.try_shutdown()

    def deliver(self, *publishers: Any) -> None:
        """Wait a little until what was published reliably has reached those who listen."""
        from rclpy.duration import Duration

        until = wall.monotonic() + 0.25 * _PATIENCE
        for publisher in publishers:
            left = max(until - wall.monotonic(), 0.0)
            publisher.wait_for_all_acked(Duration(seconds=left))

    def _spin(self) -> None:
        from rclpy.executors import ExternalShutdownException

        try:
            self._executor.spin()
        except ExternalShutdownException:
            pass
        except Exception as error:
            if not self._closed:
                self._failed(error)

    def _failed(self, error: Exception) -> None:
        self.failure = self.failure or error
        if self._on_failure is not None:
            self._on_failure(error)
