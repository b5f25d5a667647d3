"""The ground of the scene: map, heights, obstacles, and where a ray from the eye meets it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cavalcade.drawing.outlines import shape_ring
from cavalcade.drawing.replay.ground import WALL
from cavalcade.geometry import Array
from cavalcade.locomotion.footholds import LEAST_TRAVERSABILITY
from cavalcade.scenario import World
from cavalcade.studio.scene import meshes, rotations
from cavalcade.studio.scene.clicks import Clicks
from cavalcade.studio.scene.meshes import Mesh
from cavalcade.studio.scene.palette import Palette
from cavalcade.world import OccupancyMap, Shape, Terrain
from cavalcade.world.occupancy import UNKNOWN

_MOST_QUADS = 150_000
"""More faces than these are not sent: walls of very ragged maps are drawn flat."""

_MOST_NODES = 60_000
"""Of a terrain's surface; finer ones are drawn with every so many-th node."""


class Ground:
    """Map, terrain and obstacles of one world.

    Args:
        scene: `viser.SceneApi`.
        palette: Its colours.
    """

    def __init__(self, scene: Any, palette: Palette) -> None:
        self._scene, self._palette = scene, palette
        self._clicks = Clicks(scene, self.meet)
        self._clickable = False
        self._nodes: list[Any] = []
        self._obstacles: dict[tuple[str, int], tuple[Shape, Any]] = {}
        self._terrain: Terrain | None = None
        self._map: OccupancyMap | None = None

    @property
    def terrain(self) -> Terrain | None:
        """Its heights; None for level ground."""
        return self._terrain

    @property
    def corners(self) -> Array | None:
        """`(4, 2)` corners of the map, map frame, m; None without one."""
        if self._map is None:
            return None
        width, height = self._map.size
        return self._map.to_map([(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)])

    @property
    def bounds(self) -> Array | None:
        """`(2, 2)` lowest and highest x, y of the map, m; None without one."""
        corners = self.corners
        if corners is None:
            return None
        return np.array([corners.min(axis=0), corners.max(axis=0)])

    def heights_at(self, points: Array) -> Array:
        """Heights `(N,)` of the ground at points `(N, 2)`, m."""
        if self._terrain is None:
            return np.zeros(len(points))
        return self._terrain.heights_at(points)

    @property
    def clicks(self) -> Clicks:
        """Where clicks into the scene go."""
        return self._clicks

    def set_clickable(self, clickable: bool) -> None:
        """Whether clicks on obstacles are told."""
        if clickable == self._clickable:
            return
        self._clickable = clickable
        for (kind, index), (_, node) in self._obstacles.items():
            if clickable:
                node.on_click(self._clicks.on_thing(kind, self._only(index)))
            else:
                node.remove_click_callback("all")

    def clear(self) -> None:
        """Take everything away."""
        for node in (*self._nodes, *(node for _, node in self._obstacles.values())):
            node.remove()
        self._nodes.clear()
        self._obstacles.clear()
        self._terrain = self._map = None

    def recolor(self, palette: Palette) -> None:
        """Other colours."""
        self._palette = palette

    def show(self, world: World) -> bool:
        """Show a world without its obstacle shapes; whether it was another one before."""
        if self._map == world.base and self._terrain == world.terrain:
            return False
        self.clear()
        self._map, self._terrain = world.base, world.terrain
        if world.terrain is None:
            self._show_floor(world.base)
        else:
            self._show_terrain(world.terrain)
        self._show_cells(world.base)
        return True

    def show_obstacles(self, kind: str, shapes: Sequence[Shape]) -> None:
        """Show these shapes as those of a kind; a click on one says kind and index."""
        for index, shape in enumerate(shapes):
            known = self._obstacles.get((kind, index))
            if known is not None and known[0] == shape:
                continue
            self._obstacles[kind, index] = (shape, self._add_obstacle(kind, index, shape))
        for key in [k for k in self._obstacles if k[0] == kind and k[1] >= len(shapes)]:
            self._obstacles.pop(key)[1].remove()

    def _add_obstacle(self, kind: str, index: int, shape: Shape) -> Any:
        ring = shape_ring(shape, corners=32)
        low, high = 0.0, WALL
        if self._terrain is not None:
            around = self.heights_at(np.concatenate([ring, ring.mean(axis=0)[None]]))
            low, high = float(around.min()) - 0.05, float(around.max()) + WALL
        color = self._palette.obstacle if kind == "obstacle" else self._palette.mover
        node = self._add(f"/{kind}/{index}", meshes.prism(ring, low, high), color)
        if self._clickable:
            node.on_click(self._clicks.on_thing(kind, self._only(index)))
        return node

    @staticmethod
    def _only(index: int) -> Callable[[int], int]:
        return lambda _: index

    def _add(self, name: str, mesh: Mesh, color: Any, **options: Any) -> Any:
        return self._scene.add_mesh_simple(
            name, mesh.vertices, mesh.faces, color=color, flat_shading=True, **options
        )

    def _show_floor(self, base: OccupancyMap) -> None:
        # A picture of one colour: it fills most of the view, and lit ground takes far longer.
        width, height = base.size
        x, y = base.to_map([(width / 2.0, height / 2.0)])[0]
        picture = np.tile(np.array(self._palette.floor, dtype=np.uint8), (2, 2, 1))
        turn = tuple(float(part) for part in rotations.about_z(base.origin[2]))
        place = (float(x), float(y), 0.0)
        self._nodes.append(
            self._scene.add_image(
                "/ground/floor", picture, width, height, format="png", position=place, wxyz=turn
            )
        )

    def _show_terrain(self, terrain: Terrain) -> None:
        stride = max(1, int(np.ceil(np.sqrt(terrain.rows * terrain.cols / _MOST_NODES))))
        rows, cols = (
            np.unique(np.append(np.arange(0, n, stride), n - 1))
            for n in (terrain.rows, terrain.cols)
        )
        x, y = (cols + 0.5) * terrain.resolution, (rows + 0.5) * terrain.resolution
        mesh = meshes.height_grid(terrain.height[np.ix_(rows, cols)], x, y)
        # Ground that feet do not use has a colour of its own.
        barred = terrain.traversability[np.ix_(rows, cols)].ravel() < LEAST_TRAVERSABILITY
        apart = barred[mesh.faces].any(axis=1)
        for name, chosen, color in (
            ("terrain", ~apart, self._palette.terrain),
            ("barred", apart, self._palette.barred),
        ):
            if chosen.any():
                part = Mesh(mesh.vertices, mesh.faces[chosen])
                self._nodes.append(self._placed(f"/ground/{name}", part, color))

    def _show_cells(self, base: OccupancyMap) -> None:
        unknown = np.asarray(base.grid) == UNKNOWN
        walls = base.occupied & ~unknown
        low, top = 0.0, WALL
        if self._terrain is not None:
            low, top = float(self._terrain.height.min()), float(self._terrain.height.max()) + WALL
        if walls.any():
            mesh = meshes.joined(
                [
                    meshes.cell_tops(walls, base.resolution, top),
                    meshes.cell_sides(walls, base.resolution, low, top),
                ]
            )
            if len(mesh.faces) > 2 * _MOST_QUADS:
                mesh = meshes.cell_tops(walls, base.resolution, 0.004)
            self._nodes.append(self._placed("/ground/walls", mesh, self._palette.wall))
        if unknown.any():
            mesh = meshes.cell_tops(unknown, base.resolution, low + 0.002)
            self._nodes.append(self._placed("/ground/unknown", mesh, self._palette.unknown))

    def _placed(self, name: str, mesh: Mesh, color: Any) -> Any:
        """A mesh given in the map grid's own frame."""
        assert self._map is not None
        x, y, yaw = self._map.origin
        turn = (float(np.cos(yaw / 2.0)), 0.0, 0.0, float(np.sin(yaw / 2.0)))
        return self._add(name, mesh, color, cast_shadow=False, wxyz=turn, position=(x, y, 0.0))

    def meet(self, origin: Array, direction: Array) -> tuple[float, float] | None:
        """Where a ray from the eye meets the ground, x and y in m; None where it does not."""
        level = 0.0 if self._terrain is None else float(self._terrain.height.max())
        start, way = np.asarray(origin, dtype=float), np.asarray(direction, dtype=float)
        if way[2] >= -1e-6:
            return None
        reach = (level - start[2]) / way[2]
        if self._terrain is None:
            x, y = start[:2] + reach * way[:2]
            return float(x), float(y)
        lowest = float(self._terrain.height.min())
        steps = np.linspace(max(reach, 0.0), (lowest - start[2]) / way[2], 2000)
        points = start + steps[:, None] * way
        below = points[:, 2] <= self.heights_at(points[:, :2]) + 1e-9
        x, y = points[int(np.argmax(below)) if below.any() else -1][:2]
        return float(x), float(y)
