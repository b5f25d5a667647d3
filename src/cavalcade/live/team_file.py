"""TEAM.yaml: which robots there are, how they are reached, and what the team may do."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    Strict,
    ValidationError,
    model_validator,
)

from cavalcade.errors import InputError, ScenarioError
from cavalcade.execution import Supervision
from cavalcade.execution.formation_policy import expected_of
from cavalcade.fleet.ros2.robot import PoseSource, Ros2Robot, VelocityType
from cavalcade.formation import Imperfections
from cavalcade.robots import RobotModel
from cavalcade.scenario import FormationSection, PlannerSection, Scenario, build_world
from cavalcade.scenario.fields import File, Number, Point, Pose, Positive, Section, Seed, expected
from cavalcade.scenario.loading import parse_scenario, schema_of
from cavalcade.scenario.messages import scenario_error
from cavalcade.scenario.settings import Expectations, Go2Section, UnitreeSection
from cavalcade.scenario.shipped import find_scenario, read_text, scenario_names
from cavalcade.scenario.task import ModelSection, check_formation
from cavalcade.values import described
from cavalcade.world import OccupancyMap, load_map
from cavalcade.yaml_text import parse_yaml

_NAME = r"[A-Za-z_][A-Za-z0-9_]*"


def _name(text: str) -> str:
    if not re.fullmatch(rf"{_NAME}(/{_NAME})*", text):
        raise expected("expected a name of letters, digits and _, as ROS has it")
    return text


def _topic(text: str) -> str:
    if not re.fullmatch(rf"/?{_NAME}(/{_NAME})*", text):
        raise expected("expected a topic of letters, digits, _ and /, such as pose or /go1/pose")
    return text


def _frame(text: str) -> str:
    text = text.removeprefix("/")
    if not re.fullmatch(r"[\w.-]+(/[\w.-]+)*", text):
        raise expected("expected a frame's name, such as map")
    return text


Name = Annotated[str, AfterValidator(_name)]
Topic = Annotated[str, AfterValidator(_topic)]
FrameName = Annotated[str, AfterValidator(_frame)]


class PoseSection(Section):
    """Where a robot's poses come from.

    Attributes:
        type: Of the messages; `tf` takes the transform from the team's frame to `base_frame`.
        topic: Where they are published; relative to the robot's name without a leading slash.
        base_frame: The robot's own frame; null is `NAME/base_link`.
    """

    type: PoseSource = "PoseStamped"
    topic: Topic = "pose"
    base_frame: FrameName | None = None


class VelocitySection(Section):
    """How a robot is commanded.

    Attributes:
        type: Of the messages.
        topic: What it listens to; relative to the robot's name without a leading slash.
    """

    type: VelocityType = "Twist"
    topic: Topic = "cmd_vel"


class TeamRobotSection(ModelSection):
    """One robot of the team.

    Attributes:
        name: What it is called, and the namespace of its topics.
        pose: Where its poses come from.
        velocity: How it is commanded, with `fleet: ros2`.
        interface: The network interface that it is reached by, with `fleet: unitree`.
        domain: The DDS domain that it is in, with `fleet: unitree`.
        start (m, m, rad): Pose [x, y, yaw] at which a Go2 stands when the team is configured: its
            own odometry locates it from there, and drifts. Null takes poses from `pose`.
        battery_min (%): Charge below which a Go2 is to stop.
    """

    name: Name
    pose: PoseSection = PoseSection()
    velocity: VelocitySection = VelocitySection()
    interface: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    domain: Annotated[int, Strict(), Field(ge=0, le=232)] | None = None
    start: Pose | None = None
    battery_min: Annotated[Number, Field(ge=0, le=100)] = 20.0

    @property
    def place(self) -> tuple[int, str | None]:
        """The DDS domain and the interface of a Go2; as it is delivered it is in domain 0."""
        return self.domain or 0, self.interface

    @property
    def topics(self) -> tuple[str, ...]:
        """Where it is heard and told, whole names; a transform is no topic."""
        found = () if self.pose.type == "tf" else (self.pose.topic,)
        whole = (*found, self.velocity.topic)
        return tuple(name if name.startswith("/") else f"/{self.name}/{name}" for name in whole)


def _map_schema(schema: dict[str, Any]) -> None:
    """A mapping, or a file's name."""
    kept = {key: schema.pop(key) for key in ("$ref", "allOf") if key in schema}
    schema["anyOf"] = [kept, {"type": "string"}]


class MapSection(Section):
    """The ground; a file's name alone stands for `{file: NAME}`.

    Attributes:
        file: A ROS map to begin with: its YAML file; null waits for the topic.
        topic: Where maps (nav_msgs/OccupancyGrid) are taken from, also while robots move; they
            replace the file's. Null for nowhere, which is the default where a file is named.
        unknown: What unknown cells count as.
    """

    file: File | None = None
    topic: Topic | None = "/map"
    unknown: Literal["occupied", "free"] = "occupied"

    @model_validator(mode="before")
    @classmethod
    def _file_alone(cls, data: Any) -> Any:
        data = {"file": data} if isinstance(data, str) else data
        if isinstance(data, dict) and data.get("file") is not None:
            return {"topic": None} | data
        return data

    @model_validator(mode="after")
    def _some_source(self) -> Self:
        if self.file is None and self.topic is None:
            raise expected("expected a file, a topic or both", choices=("file", "topic"))
        return self


class LimitsSection(Section):
    """What robots may not exceed; the planner's own limits are below `planner`.

    Attributes:
        max_speed (m/s): Cap of commanded speeds.
        max_yaw_rate (rad/s): Cap of commanded yaw rates.
        geofence (m): Corners [x, y] of the polygon that robots' centres must stay in; null is the
            map's area alone.
    """

    max_speed: Annotated[Positive, Field(le=100)] | None = None
    max_yaw_rate: Annotated[Positive, Field(le=100)] | None = None
    geofence: Annotated[tuple[Point, ...], Field(min_length=3, max_length=1000)] | None = None


class SupervisionSection(Section):
    """When the team is stopped.

    Attributes:
        max_age (s): Oldest pose by which robots may be driven.
        max_jump (m): Longest displacement between two reports beyond what the top speed explains.
        max_turn (rad): The same of headings.
        deadline (s): How long a cycle may take, one period if null; one of more than twice that
            stops the team.
        unresponsive: Whether the others go on (`continue`) without a robot that does not follow,
            or all `stop`.
        dry_run: Do everything, but command nobody.
    """

    max_age: Annotated[Positive, Field(le=10)] = 0.5
    max_jump: Annotated[Positive, Field(le=100)] = 0.5
    max_turn: Annotated[Positive, Field(le=10)] = 1.0
    deadline: Annotated[Positive, Field(le=10)] | None = None
    unresponsive: Literal["continue", "stop"] = "continue"
    dry_run: Annotated[bool, Strict()] = False

    @model_validator(mode="before")
    @classmethod
    def _limits_are_elsewhere(cls, data: Any) -> Any:
        for key in LimitsSection.model_fields:
            if isinstance(data, dict) and key in data:
                raise expected(f"stands below limits: expected limits.{key}", key=key)
        return data


class Team(Section):
    """A team of robots that are to be driven; immutable.

    Attributes:
        version: Of the format.
        name: What it is called, also in results.
        fleet: What robots are reached by: a `ros2` graph, or `unitree` for Go2s by their vendor's
            SDK.
        lie_down: Whether Go2s lie down at the end; otherwise they stay standing.
        frame: In which poses, goals and maps are given.
        use_sim_time: Whether time is that of `/clock`; null where somebody publishes that.
        robots: The team; robots are numbered from 0 in this order.
        formation: The shape; null for goals of single robots alone.
        map: The ground.
        rate (Hz): How often robots are commanded.
        limits: What robots may not exceed.
        supervision: When the team is stopped.
        planner: How it plans, as in a scenario; `method` is for goals of single robots.
        seed: Of everything random.
    """

    version: Literal[1]
    name: Annotated[str, Field(min_length=1, max_length=200)] = "team"
    fleet: Literal["ros2", "unitree"] = "ros2"
    lie_down: Annotated[bool, Strict()] = False
    frame: FrameName = "map"
    use_sim_time: Annotated[bool, Strict()] | None = None
    robots: Annotated[tuple[TeamRobotSection, ...], Field(min_length=1, max_length=256)]
    formation: FormationSection | None = None
    map: Annotated[MapSection, Field(json_schema_extra=_map_schema)] = MapSection()
    rate: Annotated[Number, Field(ge=2.5, le=500)] = 20.0
    limits: LimitsSection = LimitsSection()
    supervision: SupervisionSection = SupervisionSection()
    planner: PlannerSection = PlannerSection()
    seed: Seed = 0

    model_config = ConfigDict(extra="forbid", frozen=True, validate_default=True)

    _file: Path | None = PrivateAttr(default=None)
    _area: OccupancyMap | None = PrivateAttr(default=None)
    _models: tuple[RobotModel, ...] | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        known: dict[str, int] = {}
        for index, robot in enumerate(self.robots):
            key = f"robots[{index}]"
            if robot.name in (other.name for other in self.robots[:index]):
                raise expected(f"{robot.name} is there twice", key=f"{key}.name")
            for topic in robot.topics if self.fleet == "ros2" else ():
                if topic in known:
                    text = f"{topic} is robot {known[topic]}'s topic, too"
                    raise expected(text, key=key)
                known[topic] = index
            self._check_fleet(index, robot)
            if robot.the_model.legs is None and self.formation is not None:
                text = f"a {robot.model} has no place in a formation; expected a robot with legs"
                raise expected(text, key=f"{key}.model")
        if self.formation is not None:
            width = min(robot.the_model.width for robot in self.robots)
            check_formation(self.formation, len(self.robots), width, place="formation")
        if self.planner.method == "commands":
            raise expected("follows no goals; expected formation", key="planner.method")
        try:
            self.what_is_allowed()
        except InputError as error:
            raise expected(error.message, key=f"limits.{error.key}") from None
        return self

    def _check_fleet(self, index: int, robot: TeamRobotSection) -> None:
        """Refuse keys of the other kind of fleet, and two Go2s that would hear the same."""
        key = f"robots[{index}]"
        if self.fleet == "ros2":
            for name in ("interface", "domain", "start", "battery_min"):
                if name in robot.model_fields_set and getattr(robot, name) is not None:
                    raise expected("is for fleet: unitree", key=f"{key}.{name}")
            return
        if robot.start is not None and "pose" in robot.model_fields_set:
            raise expected("is not needed where start is said", key=f"{key}.pose")
        if robot.start is None and robot.pose.type == "tf":
            raise expected("is for fleet: ros2", key=f"{key}.pose.type")
        if robot.velocity != VelocitySection():
            raise expected("is for fleet: ros2", key=f"{key}.velocity")
        if robot.interface is None and robot.domain is None:
            raise expected("expected its network interface, its DDS domain or both", key=key)
        for other, known in enumerate(self.robots[:index]):
            if known.place == robot.place:
                text = f"is where robot {other} is; each needs its own interface or domain"
                raise expected(text, key=key)

    @property
    def file(self) -> Path | None:
        """The file it was read from, None if there is none."""
        return self._file

    @property
    def models(self) -> tuple[RobotModel, ...]:
        """The model of each robot."""
        return self._models or tuple(robot.the_model for robot in self.robots)

    @property
    def names(self) -> tuple[str, ...]:
        """The name of each robot."""
        return tuple(robot.name for robot in self.robots)

    @property
    def go2s(self) -> UnitreeSection | None:
        """How its Go2s are reached, as a scenario says it; None of another fleet.

        Each is said to stand at its start, wherever its odometry began.
        """
        if self.fleet != "unitree":
            return None
        robots = tuple(
            Go2Section(domain=domain, interface=interface, battery_min=robot.battery_min)
            for robot in self.robots
            for domain, interface in [robot.place]
        )
        return UnitreeSection(robots=robots, lie_down=self.lie_down)

    @property
    def expected(self) -> Imperfections:
        """How well robots are located and reached: what `planner.expect` says, else perfectly.

        That they stray a little from where they are told to go is what was measured of their legs.
        """
        said = self.planner.expect
        noise, delay, error = said.noise, said.delay, said.tracking_error
        if error is None:
            error = max(model.tracking_error for model in self.models)
        return Imperfections(
            position=noise.position if noise else 0.0,
            heading=noise.heading if noise else 0.0,
            delay=delay.mean if delay else 0.0,
            jitter=delay.jitter if delay else 0.0,
            drop=delay.drop if delay else 0.0,
            tracking_error=error,
        )

    def what_is_allowed(self, dry_run: bool = False) -> Supervision:
        """The supervisor's settings, a dry run's if that is asked for here or in the file.

        Raises:
            InputError: The geofence is no polygon.
        """
        said = self.supervision.model_dump() | self.limits.model_dump()
        return Supervision(**said | {"dry_run": dry_run or self.supervision.dry_run})

    def ros2_robots(self) -> tuple[Ros2Robot, ...]:
        """How each robot is found on a graph."""
        return tuple(
            Ros2Robot(
                robot.name,
                robot.pose.type,
                robot.pose.topic,
                robot.velocity.type,
                robot.velocity.topic,
                self.frame,
                robot.pose.base_frame or "",
            )
            for robot in self.robots
        )

    def first_map(self) -> OccupancyMap | None:
        """The map to begin with, None where it is to come by the topic.

        Raises:
            MapError: The file cannot be used.
        """
        if self._area is None and self.map.file is not None:
            self._area = load_map(self.map.file, unknown=self.map.unknown)
        return self._area


def load_team(name_or_path: str | Path) -> Team:
    """Read a team from its file, or take the robots of a scenario, shipped or in a file.

    A scenario's robots are `robot_0`, `robot_1` and so on; poses are PoseStamped on
    `/robot_0/pose`, velocities Twist on `/robot_0/cmd_vel`. Its map and its formation are those to
    begin with, its goals and events are left out.

    Raises:
        ScenarioError: It does not exist or does not fit the schema.
        MapError: The scenario's map cannot be used.
    """
    file = find_scenario(name_or_path)
    data = parse_yaml(read_text(file), file=str(file))
    if not isinstance(data, dict):
        raise ScenarioError("expected a mapping with version, robots, …", file=file)
    if str(name_or_path) in scenario_names() or "world" in data or "task" in data:
        return team_of(parse_scenario(data, file))
    return parse_team(data, file)


def parse_team(data: Mapping[str, Any], file: str | Path | None = None) -> Team:
    """A team from the plain data of a file; file names in it are relative to `file`.

    Raises:
        ScenarioError: It does not fit the schema.
    """
    if not isinstance(data, Mapping):
        raise ScenarioError(f"expected a mapping, got {described(data)}", file=file, key="data")
    base = Path.cwd() if file is None else Path(file).resolve().parent
    try:
        team = Team.model_validate(dict(data), context={"base": base})
    except ValidationError as error:
        raise scenario_error(error, Team, file) from None
    team._file = None if file is None else Path(file)
    return team


def team_of(scenario: Scenario) -> Team:
    """The robots of a scenario as a team.

    Raises:
        ScenarioError: It has commands instead of a task for planners, or its ground has heights.
        MapError: Its map cannot be used.
    """
    if scenario.world.has_heights:
        text = "robots are driven on level ground; expected a map"
        raise ScenarioError(text, file=scenario.file, key="world")
    if scenario.task.commands is not None:
        text = "commands are carried out by cavalcade run; expected a formation or goals"
        raise ScenarioError(text, file=scenario.file, key="task.commands")
    told, delay = expected_of(scenario), scenario.execution.delay
    noise = scenario.planner.expect.noise or scenario.execution.noise
    delay = scenario.planner.expect.delay or delay
    expect = Expectations(noise=noise, delay=delay, tracking_error=told.tracking_error)
    try:
        team = Team(
            version=1,
            name=scenario.name,
            robots=tuple(
                TeamRobotSection(name=f"robot_{number}", model=robot.model)
                for number, robot in enumerate(scenario.robots)
            ),
            formation=scenario.task.formation,
            rate=scenario.execution.rate,
            planner=scenario.planner.model_copy(update={"expect": expect}),
            seed=scenario.seed,
        )
    except ValidationError as error:
        raise scenario_error(error, Team, scenario.file) from None
    team._file, team._models = scenario.file, scenario.models
    team._area = build_world(scenario).map
    return team


def team_schema() -> dict[str, Any]:
    """The JSON Schema of team files; `unit` is the unit of a key's value."""
    return schema_of(Team)
