"""A run on the page, or two side by side: timeline, summary, curves, what to take along."""

from __future__ import annotations

import html
import time as wall
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cavalcade.studio.scene import camera
from cavalcade.studio.session import Session
from cavalcade.studio.snapshot import Snapshot
from cavalcade.studio.study.charts import FIRST, SECOND, Charts
from cavalcade.studio.study.curves import curves_of
from cavalcade.studio.study.exporting import picture, replay_page, scenario_text
from cavalcade.studio.study.facts import compared, facts
from cavalcade.studio.study.results import Result
from cavalcade.studio.study.second_scene import SecondScene, may_lie_over
from cavalcade.studio.study.timeline import Timeline

_CHART_PERIOD = 0.3
"""Between two places of the charts' cursor while it plays, s."""

BESIDE, OVER = "beside", "over it"
_DARK, _LIGHT = (26, 27, 30), (255, 255, 255)
"""What lies behind the scene, as the page has it."""


class RunView:
    """The run's part of the page, made inside its container.

    Args:
        session: The page's.
        first: The run.
        second: Another one on the same timeline.
        over: Whether the second one is shown over the first, where it may be.
        time: Where to begin, s.
        work: Does something that takes long, beside the page: words, what, what then, for whom.
        lay: Called to show the second one over the first, or beside it.

    Attributes:
        timeline: Where it is.
        snapshot: What is shown of the first run.
    """

    def __init__(
        self,
        session: Session,
        first: Result,
        second: Result | None,
        *,
        over: bool,
        time: float | None,
        work: Callable[[str, Callable[[], Any], Callable[[Any], None], Any], None],
        lay: Callable[[bool], None],
    ) -> None:
        self._session, self._first, self._second = session, first, second
        self._work = work
        self._scene: SecondScene | None = None
        self._shown = False
        self._followed: tuple[int, np.ndarray] | None = None
        self._charted = 0.0
        results = [first] if second is None else [first, second]
        begin = min(result.player.begin for result in results)
        end = max(result.player.end for result in results)
        may_over = second is not None and may_lie_over(first, second)
        self._over = over and may_over
        gui, handle = session.server.gui, session.handle
        gui.add_html(_title(results))
        start = begin if time is None else time
        self.timeline = Timeline(
            session, begin, end, start, _events(results), _robots(results), self._on_time
        )
        self.snapshot = first.player.at(self.timeline.time)
        if may_over:
            where = gui.add_dropdown(
                "Second run", (BESIDE, OVER), initial_value=OVER if self._over else BESIDE
            )
            where.on_update(handle(lambda event: lay(event.target.value == OVER)))
        with gui.add_folder("Over time"):
            names = _names(results)
            runs = [(name, curves_of(result)) for name, result in zip(names, results, strict=True)]
            self._charts = Charts(session, runs, self.timeline.time)
        with gui.add_folder("Summary"):
            gui.add_markdown(_summary(results))
        with gui.add_folder("Take along"):
            picture_button = gui.add_button("Picture (PNG)", icon="camera")
            picture_button.on_click(handle(self._on_picture))
            replay_button = gui.add_button("Replay (HTML)", icon="movie")
            replay_button.on_click(handle(self._on_replay))
            yaml_button = gui.add_button("Scenario (YAML)", icon="file-text")
            yaml_button.on_click(handle(self._on_yaml))

    def enter(self) -> None:
        """Show it in the scene."""
        stage, first, second = self._session.stage, self._first, self._second
        stage.set_world(first.scenario, first.world)
        stage.set_team(first.scenario.models, first.scenario.starts)
        stage.set_trajectories(*first.planned)
        if second is not None:
            self._scene = SecondScene(
                self._session.server, first, second, over=self._over, dark=self._session.dark
            )
        self._shown = True
        self._show(self.timeline.time)
        if self._scene is None or self._over or second is None:
            stage.frame_team()
        else:
            places = np.concatenate([_places(first), _places(second) + self._scene.offset])
            points = np.column_stack([places, np.zeros(len(places))])
            camera.look(self._session.server, *camera.view_of(points))

    def show(self) -> None:
        """Show the moment anew."""
        self._show(self.timeline.time)

    def leave(self) -> None:
        """The scene is another one's."""
        self.timeline.pause()
        self._shown = False
        if self._scene is not None:
            self._scene.remove()
            self._scene = None

    def close(self) -> None:
        """End its thread and take it from the scene; its part of the page is its container's."""
        self.timeline.close()
        self.leave()

    def _on_time(self, time: float, final: bool) -> None:
        self._show(time)
        now = wall.monotonic()
        if final or now - self._charted >= _CHART_PERIOD:
            self._charts.move(time)
            self._charted = now

    def _show(self, time: float) -> None:
        if not self._shown:
            return
        self.snapshot = self._first.player.at(time)
        self._session.stage.show(self.snapshot)
        if self._scene is not None and self._second is not None:
            other = self._second.player.at(time)
            self._scene.set_dark(self._session.dark)
            self._scene.show(other)
            self._follow(self.snapshot, other)
        else:
            self._follow(self.snapshot, None)

    def _follow(self, first: Snapshot, second: Snapshot | None) -> None:
        """Move the cameras as the followed robot has moved."""
        robot = self.timeline.followed
        if robot is None:
            self._followed = None
            return
        count = len(first.poses)
        if robot < count or second is None:
            place = first.poses[robot, :2]
        else:
            place = second.poses[robot - count, :2]
        if self._followed is None or self._followed[0] != robot:
            self._look_at(place)
        else:
            self._move(place - self._followed[1])
        self._followed = (robot, place.copy())

    def _look_at(self, place: np.ndarray) -> None:
        """Bring a place to the middle of the view, as near as a robot is well seen."""
        offset = np.zeros(2) if self._scene is None else np.array(self._scene.offset)
        count = len(self._first.scenario.models)
        second = self.timeline.followed is not None and self.timeline.followed >= count
        x, y = place + (offset if second else 0.0)
        for client in self._session.server.get_clients().values():
            view = client.camera
            away = np.asarray(view.position) - np.asarray(view.look_at)
            away *= min(1.0, 5.0 / max(float(np.linalg.norm(away)), 1e-6))
            with client.atomic():
                view.position = np.array([x, y, 0.2]) + away
                view.look_at = np.array([x, y, 0.2])

    def _move(self, step: np.ndarray) -> None:
        if not step.any():
            return
        moved = np.array([step[0], step[1], 0.0])
        for client in self._session.server.get_clients().values():
            view = client.camera
            position, look_at = np.asarray(view.position), np.asarray(view.look_at)
            with client.atomic():
                view.position = position + moved
                view.look_at = look_at + moved

    def _on_picture(self, event: Any) -> None:
        client = event.client
        if client is None:
            return
        background = _DARK if self._session.dark else _LIGHT
        name = f"{self._first.folder.name}-{self.timeline.time:.1f}s.png"
        self._work(
            "Taking the picture …",
            lambda: picture(client, background),
            lambda content: self._session.download(event, name, content),
            client,
        )

    def _on_replay(self, event: Any) -> None:
        name = f"{self._first.folder.name}.html"
        self._work(
            "Making the replay …",
            lambda: replay_page(self._first),
            lambda content: self._session.download(event, name, content),
            event.client,
        )

    def _on_yaml(self, event: Any) -> None:
        content = scenario_text(self._first)
        self._session.download(event, f"{self._first.scenario.name}.yaml", content)


def _places(result: Result) -> np.ndarray:
    """`(K, 2)`: where its robots are on their way, m."""
    player = result.player
    times = np.linspace(player.begin, player.end, 20)
    return np.concatenate([player.at(float(time)).poses[:, :2] for time in times])


def _names(results: Sequence[Result]) -> list[str]:
    """What two results are called beside each other."""
    names = [result.folder.name for result in results]
    if len(names) == 2 and names[0] == names[1]:
        names = [f"{result.folder.parent.name}/{result.folder.name}" for result in results]
    return names


def _title(results: Sequence[Result]) -> str:
    """What is looked at, with the colours of two runs' curves, and what is missing of it."""
    lines = []
    for color, result in zip((FIRST, SECOND), results, strict=False):
        span = result.player.end - result.player.begin
        what = "a run" if result.recording is not None else "a plan"
        key = f'<span style="color:{color}">■</span> ' if len(results) > 1 else ""
        lines.append(f"{key}<b>{html.escape(result.name)}</b>: {what} of {span:.1f} s")
        lines += [f"⚠ {html.escape(gap)}" for gap in result.gaps]
    return f'<div style="padding:.3em .75em;font-size:.875em">{"<br>".join(lines)}</div>'


def _summary(results: Sequence[Result]) -> str:
    """The summary as a table in Markdown."""
    if len(results) == 1:
        rows = facts(results[0].summary)
        if not rows:
            return "There is no summary."
        body = [f"| {label} | {_safe(text)} |" for label, text in rows]
        return "\n".join(["| | |", "|:--|--:|", *body])
    one, other = results
    names = [_safe(name) for name in _names(results)]
    body = [
        f"| {label} | {_safe(a)} |\N{NO-BREAK SPACE} {_safe(b)} |\N{NO-BREAK SPACE} {difference} |"
        for label, a, b, difference in compared(one.summary, other.summary)
    ]
    return "\n".join(
        [f"| | {names[0]} |\N{NO-BREAK SPACE} {names[1]} | Δ |", "|:--|--:|--:|--:|", *body]
    )


def _safe(text: str) -> str:
    """Text that Markdown takes for nothing else."""
    return "".join(f"\\{letter}" if letter in r"\`*_[]<>#|{}" else letter for letter in text)


def _events(results: Sequence[Result]) -> list[tuple[float, str]]:
    if len(results) == 1:
        return list(results[0].events)
    named = zip(_names(results), results, strict=True)
    found = [(time, f"{name}: {text}") for name, one in named for time, text in one.events]
    return sorted(found, key=lambda event: event[0])


def _robots(results: Sequence[Result]) -> list[str]:
    if len(results) == 1:
        return [f"robot {k}" for k in range(len(results[0].scenario.models))]
    named = zip(_names(results), results, strict=True)
    return [f"robot {k} of {name}" for name, one in named for k in range(len(one.scenario.models))]
