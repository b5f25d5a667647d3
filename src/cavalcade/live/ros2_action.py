"""The action `navigate`, nav2_msgs/NavigateThroughPoses, where nav2_msgs is installed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cavalcade.errors import CavalcadeError
from cavalcade.fleet.ros2 import Graph, message_type
from cavalcade.live.navigator import TeamNavigator
from cavalcade.live.status import Pose, TeamStatus

ACTION = "nav2_msgs/action/NavigateThroughPoses"


class NavigateAction:
    """Goals of the formation as an action: one at a time, a new one takes the last one's place.

    It succeeds when the team has arrived, and is aborted when the team is stuck, the goal is
    infeasible, or others come by a topic. While the team is stopped or paused it waits.

    Args:
        graph: The node.
        active: Gives what drives the team; raises where nothing does.
        goals_of: Reads the poses of a message's header and PoseStamped messages.
        refuse: Told of goals that cannot be taken.
    """

    def __init__(
        self,
        graph: Graph,
        active: Callable[[], TeamNavigator],
        goals_of: Callable[[Any, Any], list[Pose]],
        refuse: Callable[[str], None],
    ) -> None:
        from rclpy.action import ActionServer, CancelResponse, GoalResponse

        self._active, self._goals_of, self._refuse = active, goals_of, refuse
        self._type = message_type(ACTION)
        self._accept, self._reject = GoalResponse.ACCEPT, GoalResponse.REJECT
        self._cancel = CancelResponse.ACCEPT
        self._pursued: Any = None
        self._ended: Any = None
        self._goals: tuple[Any, ...] = ()
        self._server = ActionServer(
            graph.node,
            self._type,
            "navigate",
            execute_callback=self._pursue,
            goal_callback=self._judge,
            cancel_callback=lambda handle: self._cancel,
        )

    def _judge(self, request: Any) -> Any:
        """Whether a goal can be taken."""
        try:
            self._poses(request)
            return self._accept
        except CavalcadeError as error:
            self._refuse(f"navigate: {error}")
            return self._reject

    def _poses(self, request: Any) -> list[Pose]:
        held = getattr(request.poses, "goals", request.poses)  # newer ones have nav_msgs/Goals
        header = getattr(request.poses, "header", held[0].header if held else None)
        self._active()  # refuses while the node is not active
        return self._goals_of(header, held)

    async def _pursue(self, handle: Any) -> Any:
        from rclpy.task import Future

        result = self._type.Result()
        try:
            poses = self._poses(handle.request)
            navigator = self._active()
            navigator.set_formation_goals(poses)
        except CavalcadeError as error:
            self._refuse(f"navigate: {error}")
            handle.abort()
            return result
        if self._ended is not None:
            self._ended.set_result("abort")
        ended = self._ended = Future()
        self._pursued, self._goals = handle, navigator.status.goals
        how = await ended
        if self._ended is ended:
            self._pursued = self._ended = None
        {"succeed": handle.succeed, "abort": handle.abort, "canceled": handle.canceled}[how]()
        return result

    def look(self, status: TeamStatus) -> None:
        """See what has become of the goal; called again and again."""
        handle, ended = self._pursued, self._ended
        if handle is None or ended is None or ended.done():
            return
        if handle.is_cancel_requested and status.state != "inactive":
            self._active().cancel()
            ended.set_result("canceled")
        elif status.goals != self._goals or status.state in ("stuck", "infeasible", "inactive"):
            ended.set_result("abort")
        elif status.arrived:
            ended.set_result("succeed")
        else:
            feedback = self._type.Feedback()
            if hasattr(feedback, "number_of_poses_remaining"):
                feedback.number_of_poses_remaining = len(status.goals) - status.waypoint
            handle.publish_feedback(feedback)
