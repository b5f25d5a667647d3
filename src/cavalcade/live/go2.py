"""A team file's Go2s: located by their odometry, or by poses on a ROS 2 graph."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from cavalcade.errors import FleetError
from cavalcade.fleet.protocol import Fault, Observation
from cavalcade.fleet.ros2 import Graph, qos
from cavalcade.fleet.ros2.messages import POSE_TYPES, read_report
from cavalcade.fleet.ros2.tracking import PoseTrack
from cavalcade.fleet.unitree import Go2Fleet, Go2Link
from cavalcade.live.team_file import Team


class Go2Team(Go2Fleet):
    """The Go2s of a team, driven through the vendor's SDK.

    Robots with a `start` are located by their odometry from there; the poses of the others, such
    as those of motion capture, come by their `pose` topics, and faults of these (`frame`, `stamp`)
    are faults of the observation. In a dry run robots are listened to, and asked for nothing.

    Args:
        team: With `fleet: unitree`.
        dry_run: Command nobody, not even to stand up.

    Raises:
        InputError: The SDK, ROS 2 or a type of message is not there.
    """

    def __init__(self, team: Team, dry_run: bool = False) -> None:
        links = [
            Go2Link(
                *robot.place,
                pose_source="external" if robot.start is None else "sport",
                battery_min=robot.battery_min,
            )
            for robot in team.robots
        ]
        starts = [robot.start or (0.0, 0.0, 0.0) for robot in team.robots]
        super().__init__(links, starts=starts, lie_down=team.lie_down, names=team.names)
        self._dry_run = dry_run
        external = [k for k, robot in enumerate(team.robots) if robot.start is None]
        tracks = team.ros2_robots()
        self._tracks = {number: PoseTrack(tracks[number]) for number in external}
        self._graph = Graph("cavalcade_go2s") if external else None
        try:
            for number in external:
                self._subscribe(number, team)
        except BaseException:
            self.close()
            raise

    def connect(self, timeout: float) -> None:
        """Wait until every robot has been heard, and located; nobody moves.

        Raises:
            FleetError: Somebody was not within `timeout` s; it says who and where.
        """
        try:
            super().connect(timeout)
        except FleetError as error:
            with self._lock:
                lacks = [text for track in self._tracks.values() if (text := track.missing())]
            raise FleetError("; ".join([str(error), *lacks])) from None

    def start(self, timeout: float) -> None:
        """Connect, and have all robots stand up, ready to walk, unless it is a dry run.

        Raises:
            FleetError: See `Go2Fleet.start`.
        """
        if self._dry_run:
            self.connect(timeout)
        else:
            super().start(timeout)

    def damp(self, robot: int | None = None) -> None:
        """Damp the motors of a robot or of all, unless it is a dry run."""
        if not self._dry_run:
            super().damp(robot)

    def observe(self) -> Observation:
        """The newest pose of every robot, and what is wrong with robots or their poses."""
        seen = super().observe()
        with self._lock:
            found = [
                Fault(number, *fault)
                for number, track in self._tracks.items()
                if (fault := track.fault(seen.time)) is not None
            ]
        return replace(seen, faults=(*seen.faults, *found))

    def close(self) -> None:
        """Command all robots to stop, or to lie down, and leave; a second call does nothing."""
        super().close()
        if self._graph is not None:
            self._graph.close()

    def _subscribe(self, number: int, team: Team) -> None:
        robot, graph = team.ros2_robots()[number], self._graph
        assert graph is not None
        kind = POSE_TYPES[robot.pose_type]
        graph.subscribe(kind, robot.pose_source, partial(self._hear, number), qos.sensor_data())

    def _hear(self, number: int, message: Any) -> None:
        track, report = self._tracks[number], read_report(message)
        with self._lock:
            track.hear(report, self.time)
            if track.heard:
                self.set_pose(number, track.pose, track.stamp)
