"""From a scenario to its ground: the map, exact shapes, how they change; who can stand there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cavalcade.errors import InputError, ScenarioError
from cavalcade.geometry import CLEARANCE, Array, transform_points
from cavalcade.scenario.ground import EmptySource, GenerateSource, Obstacle
from cavalcade.scenario.model import ResolvedScenario, Scenario
from cavalcade.scenario.timeline import ObstacleSpan, obstacle_spans
from cavalcade.values import instance_of
from cavalcade.world import (
    OccupancyMap,
    Polygon,
    Shape,
    generate,
    load_barn,
    load_map,
    load_movingai,
    shape_from_mapping,
    shape_to_mapping,
)
from cavalcade.world.gaps import (
    BORDER,
    CELLS,
    Body,
    body_at,
    gap_between,
    nearest_obstacle,
    squares_near,
    too_near,
)

if TYPE_CHECKING:
    from cavalcade.world import Terrain


@dataclass(frozen=True)
class World:
    """The ground of one scenario before anything has happened.

    Attributes:
        map: `seen` with all `shapes` rasterised: what a planner is given at the start.
        base: The source alone, without obstacle shapes: what is truly there.
        shapes: The exact obstacles at the start, map frame, m: `world.obstacles` in the file's
            order, then those of a `generate` or `barn` source.
        spans: Every obstacle over time, first those of `shapes` in the same order, then those
            that events bring.
        terrain: The heights, on the grid of `map`; None for level ground.
        seen: `base` as planners see it, without the specks that `planner.despeckle` takes away;
            to rasterise shapes anew when they move. None is `base` itself.
    """

    map: OccupancyMap
    base: OccupancyMap
    shapes: tuple[Shape, ...]
    spans: tuple[ObstacleSpan, ...]
    terrain: Terrain | None = None
    seen: OccupancyMap | None = None

    def map_with(self, shapes: Iterable[Shape]) -> OccupancyMap:
        """What a planner is given while these shapes stand there."""
        return (self.base if self.seen is None else self.seen).with_shapes(shapes)


def build_world(scenario: Scenario) -> World:
    """Make the world and see that the robots can stand in it.

    Raises:
        MapError: A map or terrain file cannot be used.
        ScenarioError: A source or an obstacle cannot be made, an event removes what is not there,
            or a start is outside, in an obstacle, in a hole or in another robot.
    """
    scenario = resolve_scenario(scenario)
    world = make_world(scenario)
    check_starts(scenario, world.base, world.shapes, world.terrain)
    return world


def make_world(scenario: Scenario) -> World:
    """The world alone, whoever is to stand in it.

    Raises:
        MapError: A map or terrain file cannot be used.
        ScenarioError: A source or an obstacle cannot be made, or an event removes what is not
            there.
    """
    scenario = resolve_scenario(scenario)
    world = scenario.world
    base, terrain = _ground(scenario)
    shapes = tuple(
        _shape(scenario, obstacle, f"world.obstacles[{k}]")
        for k, obstacle in enumerate(world.obstacles)
    )
    for index, event in enumerate(scenario.execution.events):
        for kind in ("add", "remove", "move"):
            said = getattr(event, kind)
            if said is not None:
                _shape(scenario, said, f"execution.events[{index}].{kind}")
    spans = obstacle_spans(scenario)
    seen = base.despeckled(scenario.planner.despeckle)
    return World(seen.with_shapes(shapes), base, shapes, spans, terrain, seen)


def _ground(scenario: Scenario) -> tuple[OccupancyMap, Terrain | None]:
    """The source alone."""
    world = scenario.world
    if world.map is not None:
        return load_map(world.map, unknown=world.unknown), None
    if world.movingai is not None:
        return load_movingai(world.movingai.file, world.movingai.resolution), None
    if world.empty is not None:
        try:
            base = OccupancyMap.empty(world.empty.size, world.resolution)
        except InputError as error:
            raise _at(scenario, "world.empty.size", error) from None
        return replace(base, origin=(*(world.empty.origin or (0.0, 0.0)), 0.0)), None
    terrain = _terrain(scenario)
    free = np.zeros(terrain.height.shape, dtype=bool)
    return OccupancyMap(free, terrain.resolution, terrain.origin), terrain


def _terrain(scenario: Scenario) -> Terrain:
    from cavalcade.world import generate_terrain, load_terrain

    world = scenario.world
    if world.terrain is not None:
        return load_terrain(world.terrain, world.resolution)
    source = world.generate
    if source is None:
        raise ScenarioError("has no source", file=scenario.file, key="world")
    try:
        seed = scenario.seed if source.seed is None else source.seed
        return generate_terrain(source.kind, source.size, seed, world.resolution, **source.options)
    except InputError as error:
        own = error.key == "resolution"
        place = "world.resolution" if own else f"world.generate.{error.key or 'kind'}"
        raise _at(scenario, place, error) from None


def resolve_scenario(scenario: Scenario) -> ResolvedScenario:
    """The same scenario with every obstacle listed: `generate` and `barn` become `empty`.

    Generated terrain stays what it is, with its seed and options written out.

    Raises:
        MapError: The BARN file cannot be used.
        ScenarioError: The generator refuses its options.
    """
    if isinstance(scenario, ResolvedScenario):
        return scenario
    world = instance_of(scenario, Scenario, "scenario").world
    if world.generate is not None and world.generate.is_terrain:
        from cavalcade.world import terrain_options

        seed = scenario.seed if world.generate.seed is None else world.generate.seed
        known, given = terrain_options(world.generate.kind), world.generate.options
        source = world.generate.model_copy(update={"seed": seed, **known, **given})
        return _with_world(scenario, generate=source)
    if world.generate is not None:
        size, shapes = _generated(scenario, world.generate)
    elif world.barn is not None:
        field = load_barn(world.barn.file)
        size, shapes = field.size, field.circles
    else:
        return ResolvedScenario.of(scenario)
    found = (Obstacle.model_validate(shape_to_mapping(shape)) for shape in shapes)
    listed = (*world.obstacles, *found)
    empty = EmptySource(size=size)
    return _with_world(scenario, generate=None, barn=None, empty=empty, obstacles=listed)


def _with_world(scenario: Scenario, **changes: Any) -> ResolvedScenario:
    world = scenario.world.model_copy(update=changes)
    return ResolvedScenario.of(scenario.model_copy(update={"world": world}))


def _generated(
    scenario: Scenario, source: GenerateSource
) -> tuple[tuple[float, float], tuple[Shape, ...]]:
    try:
        drawn = generate(
            source.kind,
            source.size,
            scenario.seed if source.seed is None else source.seed,
            scenario.world.resolution,
            radius=source.radius,
            require_feasible=source.require_feasible,
            **source.options,
        )
    except InputError as error:
        key = f"world.generate.{error.key}" if error.key else "world.generate"
        raise _at(scenario, key, error) from None
    return drawn.size, drawn.shapes


def _shape(scenario: Scenario, obstacle: Obstacle, key: str) -> Shape:
    try:
        return shape_from_mapping(obstacle.to_dict())
    except InputError as error:
        raise _at(scenario, key, error) from None


def _at(scenario: Scenario, key: str, error: InputError) -> ScenarioError:
    """The error as one of the scenario file's `key`."""
    return ScenarioError(error.message, file=scenario.file, key=key, choices=error.choices)


def check_starts(
    scenario: Scenario,
    base: OccupancyMap,
    shapes: Sequence[Shape],
    terrain: Terrain | None = None,
) -> None:
    """Refuse starts outside the map, in an obstacle, in each other or with a foot in a hole.

    Judged by the oriented footprints: against the shapes exactly, against the cells of `base`
    (the map without the shapes) as squares. All keep `CLEARANCE`.

    Raises:
        ScenarioError: Naming the robot and what it would stand in.
    """
    bodies: list[Body] = []
    for key, robot, model in scenario.team:
        x, y, yaw = robot.start
        body = body_at(model, robot.start)
        problem = _problem(body, base, shapes, bodies)
        if problem is None and terrain is not None and model.legs is not None:
            feet = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]], dtype=float)
            feet *= (model.legs.hip_x, model.legs.hip_y)
            if terrain.in_hole(transform_points((x, y, yaw), feet)).any():
                problem = "stands in a hole of the terrain"
        if problem is not None:
            raise ScenarioError(
                f"the robot at ({x:g}, {y:g}) {problem}; expected free ground and "
                f"{1e3 * CLEARANCE:g} mm around the robot",
                file=scenario.file,
                key=f"{key}.start",
            )
        bodies.append(body)


def _problem(
    body: Body, base: OccupancyMap, shapes: Sequence[Shape], bodies: Sequence[Body]
) -> str | None:
    gap, number = nearest_obstacle(body, base, shapes)
    if gap == 0.0 and number == BORDER:
        return f"reaches beyond the map, {_extent(base)}"
    if too_near(gap):
        return _near(gap, "stands in", _named(number, body, base, shapes))
    for other, standing in enumerate(bodies):
        gap = gap_between(body, standing)
        if too_near(gap):
            return _near(gap, "overlaps", f"robot {other} at {_place(standing.center)}")
    return None


def _near(gap: float, met: str, what: str) -> str:
    return f"is {1e3 * gap:.2g} mm from {what}" if gap > 0.0 else f"{met} {what}"


def _named(number: int, body: Body, base: OccupancyMap, shapes: Sequence[Shape]) -> str:
    """What `nearest_obstacle` has found, and where it is."""
    if number == BORDER:
        return f"the border of the map, {_extent(base)}"
    if number != CELLS:
        shape = shapes[number]
        middle = shape.vertices.mean(axis=0) if isinstance(shape, Polygon) else shape.center
        return f"world.obstacles[{number}] at {_place(middle)}"
    cells = np.array([square.center for square in squares_near(body, base)])
    nearest = cells[np.argmin(np.hypot(*(cells - body.center).T))]
    count = "one cell" if len(cells) == 1 else f"{len(cells)} cells"
    return f"an obstacle of the map at {_place(nearest)} ({count} of {base.resolution:g} m)"


def _place(point: Sequence[float] | Array) -> str:
    x, y = point
    return f"({x:.3f}, {y:.3f})"


def _extent(base: OccupancyMap) -> str:
    """Where a map lies, in words."""
    (x0, y0), (x1, y1) = base.to_map([(0.0, 0.0), base.size])
    if base.origin[2] == 0.0:
        return f"which spans x from {x0:g} to {x1:g} m and y from {y0:g} to {y1:g} m"
    return f"which lies between its corners {_place((x0, y0))} and {_place((x1, y1))}"
