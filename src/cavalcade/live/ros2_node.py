"""A team's navigation as a ROS 2 node with a life cycle: topics, services, an action."""

from __future__ import annotations

import logging
import threading
import time as wall
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Self

from cavalcade.errors import CavalcadeError, FleetError, InputError
from cavalcade.execution.real_time import prepare_process
from cavalcade.fleet import LiveFleet
from cavalcade.fleet.ros2 import Graph, has_message_type, message_type, qos
from cavalcade.fleet.ros2.messages import read_map, read_pose
from cavalcade.geometry import Array
from cavalcade.live.navigator import TeamNavigator
from cavalcade.live.planners import kernels_of
from cavalcade.live.ros2_action import ACTION, NavigateAction
from cavalcade.live.ros2_views import Ros2Views
from cavalcade.live.status import RobotStatus, TeamStatus
from cavalcade.live.team_file import Team
from cavalcade.recording.frames import FrameSink
from cavalcade.world import OccupancyMap
from cavalcade.yaml_text import parse_yaml

_LOG = logging.getLogger(__name__)

PATIENCE = 30.0
"""Robots and the map are waited for so long, s."""

_LOOK, _SHOW, _TELL, _DIAGNOSE = 0.05, 0.2, 0.5, 1.0
"""How often is looked for news, and at most how long until plans and markers, the status and
diagnostics are published again, s."""

_TOLD = ("arrived", "paused", "stale", "stuck", "infeasible")
"""States that are said on the terminal, besides what a message says."""

_ANSWER = 5
"""Cycles in which a resumed team has to be found good."""


class NavigationNode:
    """The node `/team/navigator`; robots and the team are commanded by topics and services.

    Its life cycle is that of every managed node: configured, it knows all robots; active, it
    drives them. On every way out of `active` robots are told to stop.

    Args:
        team: Whose robots they are.
        make_fleet: Makes what they are reached by, not yet started.
        record: Makes a sink of the `Frame` of each cycle when robots are about to be driven, of the
            map and their poses `(N, 3)`.
        dry_run: Do everything, but command nobody.
        say: Told what happens, line by line.

    Attributes:
        problem: Why the last transition failed; empty if it did not.

    Raises:
        InputError: ROS 2 or a type of message is not there.
    """

    def __init__(
        self,
        team: Team,
        make_fleet: Callable[[Team], LiveFleet],
        *,
        record: Callable[[OccupancyMap, Array], FrameSink] | None = None,
        dry_run: bool = False,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.team = team
        self._make_fleet = make_fleet
        self._record, self._dry_run, self._say = record, dry_run, say
        self._lock = threading.RLock()
        self._fleet: LiveFleet | None = None
        self._navigator: TeamNavigator | None = None
        self._map: OccupancyMap | None = None
        self._map_heard = threading.Event()
        self.lifecycle = "unconfigured"
        self.problem = self._refused = ""
        self._shown: tuple[Any, ...] = ()
        self._told = self._drawn = self._diagnosed = 0.0
        self._told_text = ""
        self._error: Exception | None = None
        self._closed = False
        self.graph = Graph(
            "navigator", "team", make_node=partial(_managed_node, self), on_failure=self._failed
        )
        try:
            self._views = Ros2Views(self.graph, team)
            self._connect()
        except BaseException:
            self.graph.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def bring_up(self) -> None:
        """Configure and activate, as a lifecycle manager would do it.

        Raises:
            InputError: The team cannot be driven as its file says.
            FleetError: Robots were not heard, or no map; it says who and where.
        """
        self._transition(self.graph.node.trigger_configure)
        self._transition(self.graph.node.trigger_activate)

    def close(self) -> None:
        """Command all robots to stop and leave the graph; a second call does nothing."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self._map_heard.set()  # nobody waits for it any more
        try:
            self.let_go()
        finally:
            self.lifecycle = "finalized"
            self._publish(force=True)
            self.graph.close()

    # What the life cycle's transitions do.

    def configure(self) -> None:
        """Hear all robots, and compile what driving them takes."""
        from cavalcade.jobs import warming
        from cavalcade.jobs.reporter import Reporter

        self.lifecycle = "configuring"
        fleet = self._make_fleet(self.team)
        try:
            with Reporter(quiet=True) as reporter:
                warming.warm(kernels_of(self.team), reporter)
            fleet.start(PATIENCE)
            with self._lock:
                self._check_open()
                self._fleet = fleet
                self.lifecycle = "inactive"
        except BaseException:
            fleet.close()
            raise
        self._say(f"{self.team.name}: all of {', '.join(self.team.names)} were heard")

    def activate(self) -> None:
        """Begin to drive."""
        fleet = self._fleet
        assert fleet is not None  # a node that is not configured has no such transition
        self.lifecycle = "activating"
        area = self._await_map()
        sinks = () if self._record is None else (self._record(area, fleet.observe().poses),)
        navigator = TeamNavigator(self.team, fleet, map=area, sinks=sinks, dry_run=self._dry_run)
        prepare_process()
        try:
            navigator.start()
            with self._lock:
                self._check_open()
                self._navigator = navigator
                self.lifecycle = "active"
                newest = self._map
        except BaseException:
            navigator.close()
            raise
        if newest is not None:
            navigator.set_map(newest)
        dry = "; dry run: nobody is commanded" if navigator.status.dry_run else ""
        self._say(f"{self.team.name}: active{dry}")

    def deactivate(self) -> None:
        """Command all robots to stop; they stay known."""
        with self._lock:
            navigator, self._navigator = self._navigator, None
            self.lifecycle = "inactive"
        if navigator is not None:
            navigator.close()
            self._say(f"{self.team.name}: inactive")

    def let_go(self) -> None:
        """Command all robots to stop and forget them."""
        self.deactivate()
        with self._lock:
            fleet, self._fleet = self._fleet, None
            self.lifecycle = "unconfigured"
        if fleet is not None:
            fleet.close()

    def _check_open(self) -> None:
        """Who was closed while robots were waited for must not drive them any more."""
        if self._closed:
            raise FleetError("the node was closed meanwhile")

    def attempt(self, act: Callable[[], None]) -> bool:
        """Carry out a transition; False where it could not be, and `problem` says why."""
        before = self.lifecycle
        try:
            act()
        except Exception as error:
            self.lifecycle = before
            known = isinstance(error, CavalcadeError)
            self.problem = str(error) if known else f"{type(error).__name__}: {error}"
            if not known:
                _LOG.exception("a transition of the life cycle has failed")
            self._error = error
            self.graph.node.get_logger().error(self.problem)
            return False
        self.problem = ""
        return True

    def _transition(self, trigger: Callable[[], Any]) -> None:
        self._error = None
        trigger()
        if self.problem:
            raise self._error or FleetError(self.problem)

    def _first_map(self) -> OccupancyMap | None:
        with self._lock:
            heard = self._map
        return heard if heard is not None else self.team.first_map()

    def _await_map(self) -> OccupancyMap:
        """The map, waited for."""
        topic = self.team.map.topic
        if self._first_map() is None and topic is not None:
            # A transition that a lifecycle manager asks for keeps the node's own thread.
            with Graph("navigator_map", "team") as graph:
                self._hear_map(graph, topic)
                self._map_heard.wait(PATIENCE)
        area = self._first_map()
        if self._closed:
            raise FleetError("the node was closed meanwhile")
        if area is None:
            raise FleetError(
                f"no map was heard on {topic} (nav_msgs/OccupancyGrid, transient local)"
            )
        return area

    # Inputs.

    def _connect(self) -> None:
        graph = self.graph
        if self.team.map.topic is not None:
            self._hear_map(graph, self.team.map.topic)
        stamped = "geometry_msgs/msg/PoseStamped"
        self._hear(stamped, "goal_pose", self._on_goal)
        self._hear("nav_msgs/msg/Path", "goals", self._on_goals)
        self._hear("std_msgs/msg/String", "formation", self._on_formation)
        for name in self.team.names:
            self._hear(stamped, f"/{name}/goal_pose", partial(self._on_robot_goal, name))
        trigger = message_type("std_srvs/srv/Trigger")
        for name in ("pause", "resume", "cancel", "stop", "reset_stop"):
            handle = partial(self._on_service, name)
            graph.node.create_service(trigger, name, handle)
        self.action: NavigateAction | None = None
        if has_message_type(ACTION):
            self.action = NavigateAction(graph, lambda: self.active, self.goals_of, self.refuse)
        else:
            self._say("nav2_msgs is not there: no action team/navigate; topics do the same")
        graph.every(_LOOK, self._publish)

    def _hear_map(self, graph: Graph, topic: str) -> None:
        handle = self._using(topic, self._on_map)
        graph.subscribe("nav_msgs/msg/OccupancyGrid", topic, handle, qos.latched())

    def _hear(self, kind: str, topic: str, act: Callable[[Any], None]) -> None:
        self.graph.subscribe(kind, topic, self._using(topic, act), qos.reliable())

    def _using(self, topic: str, act: Callable[[Any], None]) -> Callable[[Any], None]:
        """Has a message used; one that cannot be is refused with a reason."""

        def handle(message: Any) -> None:
            try:
                act(message)
            except CavalcadeError as error:
                text = str(error)
                self.refuse(text if text.startswith(topic) else f"{topic}: {text}")
            except Exception as error:
                _LOG.exception("a message on %s could not be used", topic)
                self.refuse(f"{topic}: {type(error).__name__}: {error}")

        return handle

    def refuse(self, text: str) -> None:
        """Say in log and status that an input could not be used."""
        with self._lock:
            self._refused = text
        navigator = self._navigator
        if navigator is not None:
            navigator.refuse(text)
        self.graph.node.get_logger().warning(f"refused: {text}")

    @property
    def active(self) -> TeamNavigator:
        """What drives the team.

        Raises:
            InputError: The node is not active.
        """
        navigator = self._navigator
        if navigator is None:
            raise InputError(f"the node is {self.lifecycle}; activate it first")
        return navigator

    def goals_of(self, header: Any, poses: Sequence[Any]) -> list[tuple[float, float, float]]:
        """Poses of PoseStamped messages, all in the team's frame.

        Raises:
            InputError: Another frame, or a pose that is not finite or has no heading.
        """
        found = []
        for number, stamped in enumerate(poses):
            frame = stamped.header.frame_id or header.frame_id
            self._check_frame(frame)
            pose = read_pose(stamped.pose)
            if pose[0] != pose[0]:
                which = f"pose {number} " if len(poses) > 1 else ""
                raise InputError(
                    f"{which}holds numbers that are not finite, or a quaternion without a heading"
                )
            found.append(pose)
        return found

    def _check_frame(self, frame: str) -> None:
        if frame.removeprefix("/") != self.team.frame:
            said = f"in frame {frame!r}" if frame else "without a frame"
            raise InputError(f"{said}; expected {self.team.frame!r}")

    def _on_goal(self, message: Any) -> None:
        self.active.set_formation_goals(self.goals_of(message.header, [message]))

    def _on_goals(self, message: Any) -> None:
        self.active.set_formation_goals(self.goals_of(message.header, message.poses))

    def _on_robot_goal(self, name: str, message: Any) -> None:
        self.active.set_robot_goal(name, self.goals_of(message.header, [message])[0])

    def _on_formation(self, message: Any) -> None:
        self.active.set_formation(parse_yaml(message.data, key="formation"))

    def _on_map(self, message: Any) -> None:
        self._check_frame(message.header.frame_id)
        area = read_map(message, self.team.map.unknown)
        with self._lock:
            self._map = area
            navigator = self._navigator
        self._map_heard.set()
        if navigator is not None:
            navigator.set_map(area)

    def _on_service(self, name: str, request: Any, response: Any) -> Any:
        try:
            navigator = self.active
            getattr(navigator, name)()
            response.success, response.message = True, _DONE[name]
            if name == "resume":
                response.success, response.message = self._resumed(navigator)
        except Exception as error:
            # Nobody moves where the node is not active.
            response.success, response.message = name == "stop", str(error)
        self.graph.node.get_logger().info(f"{name}: {response.message}")
        return response

    def _resumed(self, navigator: TeamNavigator) -> tuple[bool, str]:
        """Whether the team may move after a request to resume, and if not, why."""
        before = navigator.frame
        end = wall.monotonic() + max(_ANSWER / self.team.rate, 0.5)
        while wall.monotonic() < end:
            wall.sleep(0.25 / self.team.rate)
            frame = navigator.frame
            if frame is not before and navigator.status.ok:
                return True, _DONE["resume"]
        return False, navigator.status.message or "no cycle was carried out since"

    def _failed(self, error: Exception) -> None:
        """A callback has failed: robots stop."""
        _LOG.error("a callback has failed", exc_info=error)
        navigator = getattr(self, "_navigator", None)
        if navigator is not None:
            navigator.stop(f"a callback has failed: {type(error).__name__}: {error}")

    # Outputs.

    def status(self) -> TeamStatus:
        """The team's, or that it is not driven."""
        navigator = self._navigator
        if navigator is not None:
            return navigator.status
        robots = tuple(RobotStatus(name) for name in self.team.names)
        mode = "formation" if self.team.formation is not None else "individual"
        return TeamStatus(
            "inactive", mode, self._now, robots, message=self.problem, refused=self._refused
        )

    @property
    def _now(self) -> float:
        fleet = self._fleet
        return self.graph.time if fleet is None else fleet.time

    def _tell(self, status: TeamStatus) -> None:
        """Say what the team has come to, where that is another than before."""
        text = status.message or (status.state if status.state in _TOLD else "")
        if text != self._told_text:
            self._told_text = text
            if text:
                self._say(f"{self.team.name}: {text}")

    def _publish(self, force: bool = False) -> None:
        """What is due; news at once."""
        navigator, now, status = self._navigator, wall.monotonic(), self.status()
        news = (self.lifecycle, *status.turning_point)
        changed = force or news != self._shown
        stamp = self._now
        if navigator is not None:
            self._tell(status)
        if changed or now - self._told >= _TELL:
            self._shown, self._told = news, now
            self._views.show_status(self.lifecycle, status)
        if changed or now - self._diagnosed >= _DIAGNOSE:
            self._diagnosed = now
            self._views.show_diagnostics(self.lifecycle, status, stamp)
        frame = None if navigator is None else navigator.frame
        if frame is not None and now - self._drawn >= _SHOW:
            self._drawn = now
            self._views.show_plans(frame, stamp)
            self._views.show_markers(frame, status, stamp)
        if self.action is not None:
            self.action.look(status)


_DONE = {
    "pause": "the team brakes and stands until resume",
    "resume": "the team goes on",
    "cancel": "all goals are forgotten; the team stands",
    "stop": "stopped: all robots are commanded zero until reset_stop and resume",
    "reset_stop": "the e-stop is lifted; the team stands until resume",
}


def _managed_node(owner: NavigationNode, name: str, **options: Any) -> Any:
    """A node with a life cycle whose transitions are its owner's."""
    from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

    def outcome(act: Callable[[], None]) -> Any:
        done = owner.attempt(act)
        return TransitionCallbackReturn.SUCCESS if done else TransitionCallbackReturn.FAILURE

    class ManagedNode(LifecycleNode):  # type: ignore[misc]
        def on_configure(self, state: Any) -> Any:
            return outcome(owner.configure)

        def on_activate(self, state: Any) -> Any:
            return outcome(owner.activate)

        def on_deactivate(self, state: Any) -> Any:
            return outcome(owner.deactivate)

        def on_cleanup(self, state: Any) -> Any:
            return outcome(owner.let_go)

        def on_shutdown(self, state: Any) -> Any:
            return outcome(owner.let_go)

        def on_error(self, state: Any) -> Any:
            return outcome(owner.let_go)

    return ManagedNode(name, **options)
