"""Obstacle shapes in the file's own words: `{box: {…}}`, `{circle: {…}}` or `{polygon: {…}}`."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, field_validator

from cavalcade.scenario.fields import Choice, Coordinate, Length, Point, Section, Size


class Box(Section):
    """A rectangle: centre in m, size along its own x and y in m, yaw in rad."""

    center: Point
    size: Size
    yaw: Coordinate = 0.0


class Circle(Section):
    """A disc: centre and radius in m."""

    center: Point
    radius: Length


class Polygon(Section):
    """A simple polygon, convex or not: its corners in order, m."""

    points: Annotated[tuple[Point, ...], Field(min_length=3, max_length=10_000)]

    @field_validator("points")
    @classmethod
    def _open(cls, points: tuple[Point, ...]) -> tuple[Point, ...]:
        # A last corner that repeats the first closes nothing that is not closed already.
        return points[:-1] if len(points) > 3 and points[0] == points[-1] else points


class Obstacle(Choice):
    """Exactly one shape in the map frame."""

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
