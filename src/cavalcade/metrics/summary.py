"""The summary of a job: what `summary.json`, the table of a campaign and the docs have as keys."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from importlib.metadata import PackageNotFoundError, version
from platform import python_version
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

_PACKAGES = ("cavalcade", "numpy", "numba", "scipy")
_DIGITS = 6


@dataclass(frozen=True, eq=False)
class Keys(Mapping[str, Any]):
    """Base of the dataclasses here: their fields are keys of a mapping, too, with plain values.

    They equal each mapping of the same content.
    """

    def to_dict(self) -> dict[str, Any]:
        """Plain values, lists and dictionaries, as JSON has them."""
        return {name: self[name] for name in self}

    def __getitem__(self, key: str) -> Any:
        if key not in self.__dataclass_fields__:
            raise KeyError(key)
        return _plain(getattr(self, key))

    def __iter__(self) -> Iterator[str]:
        return iter(self.__dataclass_fields__)

    def __len__(self) -> int:
        return len(self.__dataclass_fields__)


@dataclass(frozen=True, eq=False)
class Collisions(Keys):
    """Contacts of footprints or bodies, as events."""

    robot_robot: int | None = None
    robot_obstacle: int | None = None


@dataclass(frozen=True, eq=False)
class FormationError(Keys):
    """Distances of the robots to their slots, m."""

    mean: float | None = None
    p95: float | None = None
    max: float | None = None


@dataclass(frozen=True, eq=False)
class CycleTimes(Keys):
    """Wall time of the policy per cycle, ms."""

    p50: float | None = None
    p99: float | None = None
    max: float | None = None


@dataclass(frozen=True, eq=False)
class GroundContacts(Keys):
    """Contacts of parts of bodies, but for feet, with the ground."""

    trunk: int
    hip: int
    thigh: int
    calf: int


@dataclass(frozen=True, eq=False)
class BodyContacts(Keys):
    """Contacts of bodies that began."""

    robot_robot: int
    robot_obstacle: int
    ground: GroundContacts


@dataclass(frozen=True, eq=False)
class PhysicsSummary(Keys):
    """What bodies and joints did in physics."""

    contacts: BodyContacts
    max_torque_share: float | None
    max_speed_share: float | None
    max_tilt_rad: float | None
    min_height_m: float | None
    max_height_m: float | None
    carried_share: tuple[float | None, ...]


@dataclass(frozen=True, eq=False)
class CommandTracking(Keys):
    """How well commanded velocities were followed."""

    speed_error: float | None
    yaw_rate_error: float | None
    drift_m_s: float | None
    rms_m_s: float | None


@dataclass(frozen=True, eq=False)
class FootholdCount(Keys):
    """Footholds of a plan, and how many lie beyond the reach of their leg."""

    count: int
    out_of_reach: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Summary(Keys):
    """What a job came to; null where a key does not apply. Distances are of true poses.

    It is a mapping, too: `summary["cycle_ms"]["p99"]` is `summary.cycle_ms.p99`.
    """

    name: Annotated[str, "the scenario's name"]
    version: Annotated[int, "of the scenario file's format"]
    seed: Annotated[int, "what was run with"]
    method: Annotated[str, "the planner's"]
    variant: Annotated[str, "the planner's"]
    backend: Annotated[str | None, "who moved the robots; null for plans"] = None
    robots: Annotated[int, "how many"]
    success: Annotated[bool, "whether it was done as asked, without a collision"]
    reason: Annotated[
        str,
        "`arrived`, `done` (of [commands](../how-to/commands.md)), `solved`, `timeout`, `stuck`, "
        "`collision`, `fallen`, `infeasible`, `budget`, `stopped` (with the fault), "
        "`crashed`",
    ]
    detail: Annotated[str | None, "one line about the reason"] = None
    involved: Annotated[tuple[int, ...], "the robots that the reason is about"] = ()
    sim_time_s: Annotated[float | None, "simulated time"] = None
    wall_time_s: Annotated[float | None, "of everything but figures and files"] = None
    makespan_s: Annotated[float | None, "until all robots were in place"] = None
    min_obstacle_distance_m: Annotated[
        float | None,
        "least distance of a robot's centre from an obstacle's surface",
    ] = None
    min_robot_distance_m: Annotated[
        float | None,
        "least distance between two robots' centres",
    ] = None
    min_footprint_gap_m: Annotated[
        float | None,
        "least distance between oriented footprints, or a footprint and an obstacle",
    ] = None
    collisions: Annotated[
        Collisions,
        "as events; in physics of footprints or of bodies, whichever are more",
    ] = field(default_factory=Collisions)
    falls: Annotated[int | None, "robots that fell"] = None
    formation_error_m: Annotated[
        FormationError,
        "distance to the own slot of the best-fitting rigid placement of the shape",
    ] = field(default_factory=FormationError)
    leader_changes: Annotated[int | None, "how often another robot took the lead"] = None
    role_changes: Annotated[int | None, "how often a robot changed its slot"] = None
    cycle_ms: Annotated[CycleTimes, "the planner's wall time per cycle"] = field(
        default_factory=CycleTimes
    )
    planning_time_s: Annotated[float | None, "wall time spent planning"] = None
    path_length_m: Annotated[tuple[float | None, ...], "per robot; of plans in space"] = ()
    lower_bound_m: Annotated[
        tuple[float | None, ...],
        "per robot: the shortest length, alone, for a disc of half the body's width",
    ] = ()
    duration_s: Annotated[
        tuple[float | None, ...],
        "per robot: until it was in place for good",
    ] = ()
    goal_error_m: Annotated[
        tuple[float | None, ...],
        "per robot: distance from its goal at the end",
    ] = ()
    goal_moved_m: Annotated[
        float | None,
        "how far the goal was moved so that its slots fit",
    ] = None
    found_by: Annotated[str | None, "of a plan: the method that `auto` ended with"] = None
    iterations: Annotated[int | None, "of a plan's search"] = None
    limit_s: Annotated[float | None, "of a plan: the limit of wall time that it had"] = None
    counts: Annotated[Mapping[str, int] | None, "of a plan's search: nodes and the like"] = None
    margin_m: Annotated[
        tuple[float, ...] | None,
        "of a plan, per robot: inflation of its body",
    ] = None
    footholds: Annotated[FootholdCount | None, "of a plan"] = None
    delay_s: Annotated[
        tuple[float | None, ...] | None,
        "per robot: how much later than planned it was sent to the end of its path",
    ] = None
    real_time_factor: Annotated[float | None, "simulated over wall time, in physics"] = None
    physics: Annotated[
        PhysicsSummary | None,
        "what bodies and joints did in [physics](../how-to/physics.md)",
    ] = None
    commanded: Annotated[
        CommandTracking | None,
        "how well the velocities of [commands](../how-to/commands.md) were followed",
    ] = None
    versions: Annotated[Mapping[str, str], "of Python and the packages that figures depend on"]


def summary_columns() -> dict[str, str]:
    """DuckDB's type of each value of a summary, nested keys joined by `.`, in their order.

    Of `versions` those are named that every summary has; of other free mappings none.
    """
    return dict(_columns(Summary, ""))


def summary_table() -> str:
    """The keys of a summary with their meanings, as a table in Markdown."""
    hints = get_type_hints(Summary, include_extras=True)
    rows = [f"| `{key.name}` | {hints[key.name].__metadata__[0]} |" for key in fields(Summary)]
    return "\n".join(("| key | |", "|---|---|", *rows))


def rounded(value: float | None) -> float | None:
    """As summaries give it; None for what is not finite."""
    if value is None or not math.isfinite(value):
        return None
    return round(float(value), _DIGITS)


def rounded_each(values: Iterable[float | None]) -> tuple[float | None, ...]:
    """Each value as summaries give it."""
    return tuple(rounded(value) for value in values)


def package_versions(more: Sequence[str] = ()) -> dict[str, str]:
    """Python's version and those of the packages that figures depend on, `more` among them."""
    found = {"python": python_version()}
    for package in (*_PACKAGES, *more):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            if package == "cavalcade":
                from cavalcade import __version__

                found[package] = __version__
    return found


def _plain(value: Any) -> Any:
    if isinstance(value, Keys):
        return value.to_dict()
    if isinstance(value, Mapping):
        return dict(value)
    return list(value) if isinstance(value, tuple) else value


_TYPES = {str: "VARCHAR", int: "BIGINT", float: "DOUBLE", bool: "BOOLEAN"}


def _columns(cls: Any, prefix: str) -> Iterator[tuple[str, str]]:
    hints = get_type_hints(cls)
    for key in fields(cls):
        name = prefix + key.name
        kind = hints[key.name]
        if get_origin(kind) in (Union, UnionType):
            (kind,) = (one for one in get_args(kind) if one is not type(None))
        if is_dataclass(kind):
            yield from _columns(kind, f"{name}.")
        elif get_origin(kind) is tuple:
            inner = next(
                one for one in (get_args(get_args(kind)[0]) or get_args(kind)) if one in _TYPES
            )
            yield name, f"{_TYPES[inner]}[]"
        elif kind in _TYPES:
            yield name, _TYPES[kind]
        elif key.name == "versions":
            yield from ((f"{name}.{package}", "VARCHAR") for package in ("python", *_PACKAGES))
