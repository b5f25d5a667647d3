"""The draft in the scene: shown, clicked at, drawn into and moved by hand."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

from cavalcade.errors import CavalcadeError, InputError
from cavalcade.studio.build import poses
from cavalcade.studio.build.bench import Bench, Selection
from cavalcade.studio.build.draft import Pose
from cavalcade.studio.build.edits import is_individual, with_robot
from cavalcade.studio.build.guide import SECOND
from cavalcade.studio.build.obstacles import DRAWN, with_one_more

WALL = 0.1
"""Width of walls, m."""

_PREVIEW = 0.2
"""How often it is said whether a robot could stand where it is dragged, s."""

_MOST_GOALS = 12
"""How many goals have handles all the time; of others the selected one has."""


class ScenePart:
    """What the tab Build does in the scene while it is chosen."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._entered = False
        self._shown: Any = None
        self._gizmos: dict[Selection, Any] = {}
        self._first: tuple[float, float] | None = None
        self._mark: Any = None
        self._previewed = 0.0
        self._held: Selection | None = None  # what somebody drags stays in their hand
        self.wall = WALL
        bench.updated.append(self.show)

    @property
    def wanted(self) -> str | None:
        """What the next click is for, in words; None where it is the first one."""
        return None if self._first is None else SECOND[self._bench.tool]

    def enter(self) -> None:
        """Show the draft, and take clicks."""
        self._entered, self._shown = True, None
        self.show()
        self._bench.session.stage.frame_team()

    def leave(self) -> None:
        """Leave the scene to others."""
        self._entered = False
        self._forget_first()
        self._held = None
        for key in list(self._gizmos):
            self._gizmos.pop(key).remove()
        stage = self._bench.session.stage
        stage.on_ground_click(None)
        stage.on_pick(None)

    def show(self) -> None:
        """Show what has changed."""
        if not self._entered:
            return
        bench, state, stage = self._bench, self._bench.draft.state, self._bench.session.stage
        shown = self._shown
        if shown is not state:
            stage.set_world(state.without_stand_ins, state.world)
            stage.set_team([model for model, _ in state.robots], [pose for _, pose in state.robots])
        self._shown = state
        if shown is not None and shown.world.base != state.world.base:
            stage.frame_team()
        selecting = bench.tool == "Select"
        stage.on_pick(self._picked if selecting else None)
        stage.on_ground_click(None if selecting else self._clicked)
        if self._first is not None and bench.tool not in DRAWN:
            self._forget_first()
        self._show_gizmos()

    def _show_gizmos(self) -> None:
        bench, state = self._bench, self._bench.draft.state
        wanted = {bench.selected} if bench.selected is not None else set()
        if len(state.goals) <= _MOST_GOALS:
            wanted |= {("goal", index) for index in range(len(state.goals))}
        for key in set(self._gizmos) - wanted:
            self._gizmos.pop(key).remove()
        for key in sorted(wanted):
            pose = poses.pose_at(bench.draft.state, *key)
            if key in self._gizmos and (key == self._held or _same(self._gizmos[key].pose, pose)):
                continue
            if key in self._gizmos:
                self._gizmos[key].pose = pose
                continue
            self._gizmos[key] = self._gizmo(key, pose)

    def _gizmo(self, key: Selection, pose: Pose) -> Any:
        kind, index = key

        def changed(event: Any, there: Pose) -> None:
            self._preview(key, there)

        def ended(event: Any, there: Pose) -> None:
            self._dropped(key, there, event)

        stage = self._bench.session.stage
        return stage.goal_gizmo(f"build-{kind}-{index}", pose, changed, ended)

    def _preview(self, key: Selection, there: Pose) -> None:
        """Say on the way whether a robot could stand there."""
        bench, self._held = self._bench, key
        now = time.monotonic()
        if (
            key[0] != "robot"
            or now < self._previewed + _PREVIEW
            or not bench.session.lock.acquire(blocking=False)
        ):
            return
        try:
            self._previewed = now
            bench.draft.check(poses.moved(bench.draft.state, *key, _tidy(there)))
        except CavalcadeError as error:
            bench.warn(str(error))
        else:
            bench.warn(None)
        finally:
            bench.session.lock.release()

    def _dropped(self, key: Selection, there: Pose, event: Any) -> None:
        """Something has been moved by hand; where that is refused it goes back."""
        bench, self._held = self._bench, None
        done = False

        def put() -> None:
            bench.draft.replace(poses.moved(bench.draft.state, *key, _tidy(there)))

        def drop(event: Any) -> None:
            nonlocal done
            done = bench.fields.attempt(put, event.client)

        bench.session.handle(drop)(event)
        if not done and key in self._gizmos:
            self._gizmos[key].pose = poses.pose_at(bench.draft.state, *key)

    def _picked(self, event: Any, kind: str, index: int) -> None:
        def pick(_: Any) -> None:
            if kind in ("robot", "obstacle"):
                self._bench.fields.flush()
                self._bench.select((kind, index))
                self._bench.fields.show()

        self._bench.session.handle(pick)(event)

    def _clicked(self, event: Any, x: float, y: float) -> None:
        place = (round(x, 2), round(y, 2))

        def click(event: Any) -> None:
            self._bench.fields.flush()
            self._bench.fields.attempt(lambda: self._use_tool(place), event.client)

        self._bench.session.handle(click)(event)

    def _use_tool(self, place: tuple[float, float]) -> None:
        bench, tool = self._bench, self._bench.tool
        draft = bench.draft
        if tool in DRAWN:
            self._draw(place)
        elif tool == "Robot":
            yaw = draft.state.robots[-1][1][2] if draft.state.robots else 0.0
            draft.replace(with_robot(draft.state, bench.model, (*place, yaw)))
            bench.select(("robot", len(draft.state.robots) - 1))
        elif is_individual(draft.data):
            self._put_own_goal(place)
        else:
            self._put_goal(place)

    def _draw(self, place: tuple[float, float]) -> None:
        bench, first = self._bench, self._first
        if first is None:
            self._first = place
            scene = bench.session.server.scene
            self._mark = scene.add_icosphere(
                "/build/first", 0.08, color=(255, 160, 0), position=(*place, 0.08)
            )
            bench.update()
            return
        self._forget_first()
        obstacle = DRAWN[bench.tool](first, place, self.wall)
        bench.draft.replace(with_one_more(bench.draft.state, obstacle))

    def _forget_first(self) -> None:
        self._first = None
        if self._mark is not None:
            self._mark.remove()
            self._mark = None

    def _put_goal(self, place: tuple[float, float]) -> None:
        """One waypoint more, to be reached the way it is come from."""
        draft = self._bench.draft
        state = draft.state
        if not state.robots:
            raise InputError("expected robots first; then they can be told where to go", key="Goal")
        before = state.goals[-1][:2] if state.goals else _middle([p for _, p in state.robots])
        yaw = math.atan2(place[1] - before[1], place[0] - before[0])
        goals = [list(goal) for goal in state.goals]
        draft.set("task.goals", [*goals, [*place, round(yaw, 3)]])

    def _put_own_goal(self, place: tuple[float, float]) -> None:
        """The goal of the selected robot, or of the first; then the next one is selected."""
        bench = self._bench
        state = bench.draft.state
        index = bench.selected[1] if bench.selected and bench.selected[0] != "obstacle" else 0
        x, y, _ = state.robots[index][1]
        yaw = round(math.atan2(place[1] - y, place[0] - x), 3)
        bench.draft.replace(poses.moved(state, "goal", index, (*place, yaw)))
        bench.select(("robot", (index + 1) % len(state.robots)))


def _tidy(pose: Pose) -> Pose:
    """To the centimetre and to 0.001 rad."""
    return round(pose[0], 2), round(pose[1], 2), round(pose[2], 3)


def _same(one: Sequence[float], other: Sequence[float]) -> bool:
    return all(abs(a - b) < 1e-6 for a, b in zip(one, other, strict=True))


def _middle(points: Sequence[Pose]) -> tuple[float, float]:
    return (
        sum(x for x, _, _ in points) / len(points),
        sum(y for _, y, _ in points) / len(points),
    )
