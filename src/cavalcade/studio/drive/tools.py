"""What changes a drive on its way: goals, shape, obstacles and robots."""

from __future__ import annotations

import math
import time as wall
from collections.abc import Callable
from typing import Any, get_args

from cavalcade.errors import InputError
from cavalcade.scenario import FormationSection
from cavalcade.studio.drive.drive import Drive, Pose
from cavalcade.studio.session import Session

SELECT, WAYPOINT, BOX, CYLINDER = (
    "selects",
    "adds a waypoint",
    "puts a box down",
    "puts a cylinder down",
)
AWAY, BACK, PUSH = "Take away", "Bring back", "Push"
DELETE, SHAPE = "Delete", "Change the shape"

_SAME = 1e-4
"""Poses that differ by less, m and rad, are the same."""

DRAG_PERIOD = 0.4
"""While a goal is dragged, the team is told this often, s."""

SHAPES: tuple[str, ...] = tuple(
    name for name in get_args(FormationSection.model_fields["shape"].annotation) if name != "custom"
)


class DriveTools:
    """Fields and handles in the scene.

    Args:
        session: The page.
        drive: Gives what is driven.
    """

    def __init__(self, session: Session, drive: Callable[[], Drive]) -> None:
        self._session, self._drive = session, drive
        self._gizmos: list[Any] = []
        self._mover: Any = None
        self._selected: int | None = None
        self._tool, self._entered = SELECT, False
        self._sent = -math.inf
        self._dragged = -math.inf
        self.fixed: list[int] = []
        self.movers: list[int] = []
        gui, handle = session.server.gui, session.handle
        self._click = gui.add_dropdown("A click", (SELECT, WAYPOINT, BOX, CYLINDER))
        self._click.on_update(self._use)
        self._size = gui.add_number("of size (m)", 0.6, min=0.05, max=20.0, step=0.05)
        with gui.add_folder("Shape", expand_by_default=False):
            self._shape = gui.add_dropdown("Shape", SHAPES)
            self._extent = gui.add_number(
                "Size (m)",
                1.0,
                min=0.1,
                max=20.0,
                step=0.1,
                hint="Side of a square or triangle, radius of a circle, spacing of the others",
            )
            change = gui.add_button(SHAPE)
            change.on_click(handle(lambda _: self._change_shape()))
        with gui.add_folder("Obstacles", expand_by_default=False):
            self._obstacle = gui.add_markdown("Click on an obstacle to move or delete it")
            self._obstacle_speed = gui.add_number(
                "Moves at (m/s)", 0.5, min=0.0, max=10.0, step=0.1, hint="0: it is there at once"
            )
            self._delete = gui.add_button(DELETE, disabled=True)
            self._delete.on_click(handle(lambda _: self._remove()))
        with gui.add_folder("Robots", expand_by_default=False):
            self._robot = gui.add_dropdown("Robot", ("0",))
            act = gui.add_button_group("", (AWAY, BACK))
            act.on_click(handle(lambda event: self._robot_act(event.target.value)))
            self._impulse = gui.add_number("Impulse (N s)", 10.0, min=0.1, max=1000.0, step=1.0)
            self._heading = gui.add_number("Towards (°)", 90.0, min=-360.0, max=360.0, step=15.0)
            push = gui.add_button(PUSH, hint="Robots in physics only")
            push.on_click(handle(lambda _: self._push()))

    def begin(self, drive: Drive) -> None:
        """Another drive has begun."""
        self._select(None)
        names = tuple(map(str, range(len(drive.models))))
        self._robot.options = names
        section = drive.scenario.task.formation
        if section is not None:
            if section.shape in SHAPES:
                self._shape.value = section.shape
            extent = section.side or section.spacing or section.radius
            self._extent.value = 1.0 if extent is None else extent

    def enter(self) -> None:
        """The scene is ours."""
        self._entered = True
        self._listen()

    def leave(self) -> None:
        """The scene is somebody else's."""
        self._entered = False
        self._session.stage.on_ground_click(None)
        self._session.stage.on_pick(None)
        self._clear()

    def show(self, drive: Drive | None) -> None:
        """Handles stand where goals are, except for one that is being dragged."""
        going = drive is not None and drive.phase not in ("ended", "preparing")
        goals = drive.goals if drive is not None and going else ()
        if self._dragging:
            return
        if len(goals) != len(self._gizmos):
            self._clear_goals()
            self._gizmos = [self._goal_gizmo(index, goal) for index, goal in enumerate(goals)]
        for gizmo, goal in zip(self._gizmos, goals, strict=True):
            if math.dist(gizmo.pose, goal) > _SAME:
                gizmo.pose = goal

    def _goal_gizmo(self, index: int, goal: Pose) -> Any:
        handle = self._session.handle

        def changed(event: Any, pose: Pose) -> None:
            self._dragged = wall.monotonic()
            if self._dragged - self._sent >= DRAG_PERIOD:
                handle(lambda _: self._set_goal(index, pose))(event)

        def ended(event: Any, pose: Pose) -> None:
            self._dragged = -math.inf
            handle(lambda _: self._set_goal(index, pose))(event)

        return self._session.stage.goal_gizmo(f"drive/goal_{index}", goal, changed, ended)

    @property
    def _dragging(self) -> bool:
        return wall.monotonic() - self._dragged < 2.0

    def _set_goal(self, index: int, pose: Pose) -> None:
        self._sent = wall.monotonic()
        goals = list(self._drive().goals)
        # Waypoints that were reached meanwhile have gone from the front.
        place = index - max(len(self._gizmos) - len(goals), 0)
        if place < 0:
            raise InputError("this waypoint has just been reached")
        if math.dist(goals[place], pose) < _SAME:
            return
        goals[place] = pose
        self._drive().set_goals(goals)

    def _use(self, event: Any) -> None:
        """Let clicks do something else."""

        def take(_: Any) -> None:
            self._tool = self._click.value
            if self._entered:
                self._listen()

        self._session.handle(take)(event)
        if self._click.value != self._tool:  # one who watches has chosen it
            self._click.value = self._tool

    def _listen(self) -> None:
        """Clicks are on things or on the ground, not on both."""
        stage, handle, selects = self._session.stage, self._session.handle, self._tool == SELECT
        stage.on_pick(
            (lambda event, kind, index: handle(lambda _: self._picked(kind, index))(event))
            if selects
            else None
        )
        stage.on_ground_click(
            None if selects else lambda event, x, y: handle(lambda _: self._clicked(x, y))(event)
        )

    def _clicked(self, x: float, y: float) -> None:
        what, size = self._tool, float(self._size.value)
        drive, place = self._drive(), [round(x, 3), round(y, 3)]
        if what == WAYPOINT:
            goals = drive.goals
            yaw = goals[-1][2] if goals else 0.0
            arrived = drive.phase == "waiting"
            drive.set_goals([*(() if arrived else goals), (place[0], place[1], yaw)])
        elif what == BOX:
            drive.add({"box": {"center": place, "size": [size, size]}})
        else:
            drive.add({"circle": {"center": place, "radius": round(size / 2.0, 4)}})

    def _picked(self, kind: str, index: int) -> None:
        if kind == "robot":
            self._robot.value = str(index)
            return
        found = self.fixed if kind == "obstacle" else self.movers
        picked = found[index] if index < len(found) else None
        self._select(None if picked == self._selected else picked)

    def _select(self, index: int | None) -> None:
        if self._mover is not None:
            self._mover.remove()
            self._mover = None
        self._selected = index
        self._delete.disabled = index is None
        if index is None:
            self._obstacle.content = "Click on an obstacle to move or delete it"
            return
        drive = self._drive()
        here = drive.spans[index].obstacle_at(_time(drive))
        if here is None:
            self._select(None)
            return
        x, y = here.center
        self._obstacle.content = f"**{here.kind}** at ({x:.2f}, {y:.2f}) m"
        handle = self._session.handle
        self._mover = self._session.stage.goal_gizmo(
            "drive/obstacle",
            (x, y, 0.0),
            lambda event, pose: None,
            lambda event, pose: handle(lambda _: self._move(pose))(event),
        )

    def _move(self, pose: Pose) -> None:
        if self._selected is None:
            raise InputError("no obstacle is selected")
        to = (round(pose[0], 3), round(pose[1], 3))
        here = self._drive().spans[self._selected].obstacle_at(_time(self._drive()))
        if here is not None and math.dist(here.center, to) < 1e-3:
            return
        speed = float(self._obstacle_speed.value)
        try:
            self._drive().move(self._selected, to, speed)
        finally:
            self._select(None)

    def _remove(self) -> None:
        if self._selected is None:
            raise InputError("no obstacle is selected; click on one")
        self._drive().remove(self._selected)
        self._select(None)

    def _change_shape(self) -> None:
        shape, extent = self._shape.value, float(self._extent.value)
        key = "radius" if shape == "circle" else "spacing"
        self._drive().set_formation({"shape": shape, key: extent})

    def _robot_act(self, what: str) -> None:
        robot = int(self._robot.value)
        if what == AWAY:
            self._drive().lose(robot)
        else:
            self._drive().rejoin(robot)

    def _push(self) -> None:
        strength, heading = float(self._impulse.value), math.radians(self._heading.value)
        impulse = round(strength * math.cos(heading), 6), round(strength * math.sin(heading), 6)
        self._drive().push(int(self._robot.value), impulse)

    def _clear(self) -> None:
        self._clear_goals()
        self._select(None)

    def _clear_goals(self) -> None:
        for gizmo in self._gizmos:
            gizmo.remove()
        self._gizmos = []


def _time(drive: Drive) -> float:
    moment = drive.snapshot()
    return 0.0 if moment is None else moment.time
