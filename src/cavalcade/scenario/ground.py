"""Where it takes place: the `world` of a scenario file, and obstacles in the file's own words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, Strict, field_validator, model_validator

from cavalcade.scenario.fields import (
    Choice,
    Coordinate,
    File,
    Fraction,
    Length,
    NotNegative,
    Point,
    Section,
    Seed,
    Size,
    expected,
)
from cavalcade.world.generators import GENERATORS
from cavalcade.world.generators.model import options_of

KIND_OPTIONS: Mapping[str, tuple[str, ...]] = {
    kind: tuple(options_of(generator)) for kind, generator in GENERATORS.items()
}
"""What each kind of generated world of obstacles may be told."""

TERRAIN_OPTIONS: Mapping[str, tuple[str, ...]] = {
    "blocks": ("height", "side", "zone"),
    "gap": ("width", "depth", "at"),
    "rough": ("height", "spacing", "zone"),
    "slope": ("angle", "length", "at"),
    "stairs": ("steps", "height", "tread", "at"),
    "step": ("height", "at"),
    "stepping-stones": ("stone", "width", "height", "depth", "zone"),
}
"""What each kind of generated terrain may be told."""

_ONLY_OBSTACLES = ("radius", "require_feasible")
"""What makes sense for generated obstacles alone."""

Count = Annotated[int, Strict(), Field(ge=0, le=100_000)]


ObstacleKind = Literal["clutter", "forest", "rooms", "corridor", "maze"]
TerrainKind = Literal["gap", "step", "stairs", "slope", "rough", "stepping-stones", "blocks"]


class Box(Section):
    """A rectangle, turned about its centre.

    Attributes:
        center (m): Its centre [x, y] in the map frame.
        size (m): Its sides [length, width], along its own x and y.
        yaw (rad): Its heading, counter-clockwise from the map's x.
    """

    center: Point
    size: Size
    yaw: Coordinate = 0.0


class Circle(Section):
    """A disc.

    Attributes:
        center (m): Its centre [x, y] in the map frame.
        radius (m): Its radius.
    """

    center: Point
    radius: Length


class Polygon(Section):
    """A simple polygon, convex or not.

    Attributes:
        points (m): Its corners [x, y] in order, in the map frame.
    """

    points: Annotated[tuple[Point, ...], Field(min_length=3, max_length=10_000)]

    @field_validator("points")
    @classmethod
    def _open(cls, points: tuple[Point, ...]) -> tuple[Point, ...]:
        # A last corner that repeats the first closes nothing that is not closed already.
        return points[:-1] if len(points) > 3 and points[0] == points[-1] else points


class Obstacle(Choice):
    """Exactly one shape in the map frame.

    Attributes:
        box: A rectangle.
        circle: A disc.
        polygon: A simple polygon.
    """

    kinds = ("box", "circle", "polygon")
    wanted = "expected exactly one shape"

    box: Box | None = None
    circle: Circle | None = None
    polygon: Polygon | None = None

    def to_dict(self) -> dict[str, Any]:
        """The shape as a scenario file writes it, e.g. `{"circle": {"center": [x, y], …}}`."""
        return {self.kind: self.value.model_dump(mode="json")}

    @property
    def center(self) -> tuple[float, float]:
        """What `move: {…, to: [x, y]}` brings to `to`; of a polygon, the mean of its corners."""
        part: Box | Circle | Polygon = self.value
        if not isinstance(part, Polygon):
            return part.center
        count = len(part.points)
        return sum(x for x, _ in part.points) / count, sum(y for _, y in part.points) / count

    def moved(self, offset: tuple[float, float]) -> Obstacle:
        """The same shape displaced by (x, y) in m."""
        dx, dy = offset
        part: Box | Circle | Polygon = self.value
        if isinstance(part, Polygon):
            points = tuple((x + dx, y + dy) for x, y in part.points)
            changed: Section = part.model_copy(update={"points": points})
        else:
            x, y = part.center
            changed = part.model_copy(update={"center": (x + dx, y + dy)})
        return self.model_copy(update={self.kind: changed})


class EmptySource(Section):
    """Free ground.

    Attributes:
        size (m): Its extent [width, height], along x and y.
        origin (m): Its lower-left corner [x, y]; (0, 0) if not given.
    """

    size: Size
    origin: Point | None = None


class GenerateSource(Section):
    """A seeded random world or terrain; its lower left corner is at (0, 0).

    Each kind takes some of the options and has defaults of its own, which null stands for.

    Attributes:
        kind: What is generated: obstacles, or terrain for robots with legs.
        size (m): Extent [width, height], along x and y.
        seed: Of the generator; null takes `execution.seed`.
        radius (m): Of the disc that `require_feasible` sends through; obstacles only.
        require_feasible: Whether worlds are sampled anew until a disc of `radius` gets from one end
            to the other; obstacles only.
        obstacles: How many obstacles.
        zone (m): Width of the zones at the left and the right edge: free ground for start and goal;
            of terrain, level ground.
        trees: How many trunks, fewer where no more fit; by default as many as fit.
        spacing (m): Least free gap between two trunks; of rough ground, distance of its nodes.
        room (m): Wanted side of a room, wall included.
        door (m): Width of doors, at least 1.0.
        wall (m): Thickness of walls.
        extra: Share of the remaining walls that get a door as well.
        width (m): Free width of a corridor; of a pit, its extent along the way.
        bends: How many bends a corridor has, at least 2.
        angle (degrees or rad): Least angle of a corridor's bends in degrees, up to 75;
            inclination of a slope in rad.
        passage (m): Least width of a maze's passages, which are widened to fill the world evenly.
        loops: Share of a maze's remaining walls that are taken away.
        height (m): Of a step or of each stair, negative is down; of random ground, from the lowest
            to the highest point.
        depth (m): Of pits.
        length (m): Of a slope, seen from above.
        tread (m): Depth of a stair.
        stone (m): Side of a stepping stone.
        side (m): Side of a block.
        steps: How many stairs.
        at (m): The x of its middle, or of a step's edge; the middle of the terrain if not given.
    """

    kind: Literal[ObstacleKind, TerrainKind]
    size: Size
    seed: Seed | None = None
    radius: Length = 0.30
    require_feasible: Annotated[bool, Strict()] = True
    obstacles: Count | None = None
    zone: NotNegative | None = None
    trees: Count | None = None
    spacing: Length | None = None
    room: Length | None = None
    door: Length | None = None
    wall: Length | None = None
    extra: Fraction | None = None
    width: Length | None = None
    bends: Count | None = None
    angle: Coordinate | None = None
    passage: Length | None = None
    loops: Fraction | None = None
    height: Coordinate | None = None
    depth: Length | None = None
    length: Length | None = None
    tread: Length | None = None
    stone: Length | None = None
    side: Length | None = None
    steps: Count | None = None
    at: Coordinate | None = None

    @model_validator(mode="after")
    def _known_options(self) -> Self:
        known = self._known
        every = set().union(*KIND_OPTIONS.values(), *TERRAIN_OPTIONS.values())
        foreign = [*sorted(every - set(known)), *(_ONLY_OBSTACLES if self.is_terrain else ())]
        for name in foreign:
            if getattr(self, name) != type(self).model_fields[name].default:
                raise expected(f"a {self.kind} has no such option", key=name, choices=known)
        return self

    @property
    def is_terrain(self) -> bool:
        """Whether it has heights instead of obstacles."""
        return self.kind in TERRAIN_OPTIONS

    @property
    def options(self) -> dict[str, Any]:
        """The options of the kind that are given."""
        found = {name: getattr(self, name) for name in self._known}
        return {name: value for name, value in found.items() if value is not None}

    def to_dict(self) -> dict[str, Any]:
        """What a scenario file says of it."""
        said = self.model_dump(mode="json", exclude_none=True)
        return {k: v for k, v in said.items() if not (self.is_terrain and k in _ONLY_OBSTACLES)}

    @property
    def _known(self) -> tuple[str, ...]:
        return TERRAIN_OPTIONS[self.kind] if self.is_terrain else KIND_OPTIONS[self.kind]


class MovingAISource(Section):
    """A grid map of the MovingAI benchmark.

    Attributes:
        file: The `.map` file.
        resolution (m): Side of one of its cells.
    """

    file: File
    resolution: Length = 0.25


class BarnSource(Section):
    """A world of the BARN data set, moved so that its lower left is (0, 0).

    Attributes:
        file: Its list of circles, `.npy`.
    """

    file: File


class WorldSection(Choice):
    """Exactly one source, then optional extra obstacles.

    Attributes:
        map: A ROS map: its YAML file, which names the picture.
        terrain: Heights: a description in YAML, or a mesh, table or picture.
        generate: A seeded random world or terrain.
        empty: Free ground.
        movingai: A grid map of the MovingAI benchmark.
        barn: A world of the BARN data set.
        resolution (m): Side of a cell, for sources that do not bring one and for terrain, which is
            brought to it.
        unknown: What the unknown cells of a map count as.
        obstacles: Obstacles besides.
    """

    kinds = ("map", "terrain", "generate", "empty", "movingai", "barn")
    wanted = "expected exactly one source"

    map: File | None = None
    terrain: File | None = None
    generate: GenerateSource | None = None
    empty: EmptySource | None = None
    movingai: MovingAISource | None = None
    barn: BarnSource | None = None
    resolution: Annotated[Length, Field(ge=0.001)] = 0.05
    unknown: Literal["occupied", "free"] = "occupied"
    obstacles: Annotated[tuple[Obstacle, ...], Field(max_length=100_000)] = ()

    @property
    def has_heights(self) -> bool:
        """Whether the ground is terrain."""
        return self.terrain is not None or (self.generate is not None and self.generate.is_terrain)
