"""The timeline of what is studied: time, play, speed, whom to follow, events to jump to."""

from __future__ import annotations

import math
import threading
import time as wall
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from cavalcade.studio.session import Session
from cavalcade.studio.study.playback import SPEEDS, Playback

_PERIOD = 0.04
"""Between two moments that are shown, s."""

_SLIDER_PERIOD = 0.15
"""Between two that the slider tells, s."""

NOBODY = "nobody"
_MOST_MARKS = 40
_LONGEST = 70


class Timeline:
    """The timeline's part of the page, made inside its container.

    Args:
        session: The page's.
        begin, end, time: First and last moment, and where to begin, s.
        events: (time in s, text) in order of time.
        robots: Names of the robots that can be followed.
        show: Called with each time that is to be shown, s, and whether that is final for now.

    Attributes:
        playback: Where it is.
        followed: Index of the robot that the camera follows; None for nobody.
    """

    def __init__(
        self,
        session: Session,
        begin: float,
        end: float,
        time: float,
        events: Sequence[tuple[float, str]],
        robots: Sequence[str],
        show: Callable[[float, bool], None],
    ) -> None:
        self._session, self._show = session, show
        self.playback = Playback(begin, end)
        self.playback.jump(time)
        self.followed: int | None = None
        gui, handle = session.server.gui, session.handle
        low = math.floor(100.0 * begin) / 100.0
        high = max(math.ceil(100.0 * end) / 100.0, low + 0.01)
        self._slider = gui.add_slider(
            "Time (s)", low, high, 0.01, round(self.time, 2), marks=_marks(low, high, events)
        )
        self._slider.on_update(handle(self._on_slider))
        self._play = gui.add_button("Play", icon="player-play", hint="Or the space bar")
        self._play.on_click(handle(lambda _: self.play_or_pause()))
        ways = gui.add_button_group("Go", ("Start", "Back", "Step", "End"))
        ways.on_click(handle(self._on_way))
        speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value="1 ×")
        speed.on_update(handle(self._on_speed))
        follow = gui.add_dropdown("Follow", (NOBODY, *robots))
        follow.on_update(handle(self._on_follow))
        self._names = (NOBODY, *robots)
        self._times = {_label(time, text): time for time, text in events}
        if self._times:
            jump = gui.add_dropdown("Jump to", ("an event …", *self._times))
            jump.on_update(handle(self._on_jump))
        self._slider_told = 0.0
        self._ended = threading.Event()
        self._woken = threading.Event()
        self._thread = threading.Thread(target=self._run, name="study-timeline", daemon=True)
        self._thread.start()

    @property
    def time(self) -> float:
        """Where it is, s."""
        return self.playback.time

    def play_or_pause(self) -> None:
        """Go on, or stand still."""
        if self.playback.playing:
            self.pause()
        else:
            self.playback.play()
            self._say_playing()
            self._woken.set()

    def pause(self) -> None:
        """Stand still."""
        self.playback.playing = False
        self._say_playing()
        self._show_now(True)

    def step(self, seconds: float = 0.05) -> None:
        """Stand still so many seconds on."""
        self.jump(self.time + seconds)

    def jump(self, time: float) -> None:
        """Stand still at a time, s."""
        self.playback.playing = False
        self.playback.jump(time)
        self._say_playing()
        self._show_now(True)

    def close(self) -> None:
        """End its thread; its part of the page is its container's."""
        self.playback.playing = False
        self._ended.set()
        self._woken.set()

    def _on_slider(self, event: Any) -> None:
        if event.client is not None:  # else it was set here
            self.playback.jump(float(event.target.value))
            self._show(self.time, not self.playback.playing)

    def _on_way(self, event: Any) -> None:
        playback = self.playback
        times = {"Start": playback.begin, "End": playback.end, "Back": self.time - 0.05}
        self.jump(times.get(event.target.value, self.time + 0.05))

    def _on_speed(self, event: Any) -> None:
        self.playback.speed = SPEEDS[event.target.value]

    def _on_follow(self, event: Any) -> None:
        index = self._names.index(event.target.value)
        self.followed = index - 1 if index else None

    def _on_jump(self, event: Any) -> None:
        if event.target.value in self._times:
            self.jump(self._times[event.target.value])

    def _say_playing(self) -> None:
        playing = self.playback.playing
        self._play.label = "Pause" if playing else "Play"
        self._play.icon = "player-pause" if playing else "player-play"

    def _show_now(self, final: bool) -> None:
        now = wall.monotonic()
        if final or now - self._slider_told >= _SLIDER_PERIOD:
            self._slider.value = round(self.time, 2)
            self._slider_told = now
        self._show(self.time, final)

    def _run(self) -> None:
        before = wall.monotonic()
        while not self._ended.is_set():
            if not self.playback.playing:
                self._woken.wait()
                self._woken.clear()
                before = wall.monotonic()
                continue
            now = wall.monotonic()
            elapsed, before = now - before, now
            if not self._session.attempt(partial(self._tick, elapsed)):
                self.playback.playing = False  # once said is enough
            self._ended.wait(max(0.0, _PERIOD - (wall.monotonic() - now)))

    def _tick(self, elapsed: float) -> None:
        if self._ended.is_set() or not self.playback.advance(elapsed):
            return
        if not self.playback.playing:
            self._say_playing()
        self._show_now(not self.playback.playing)


def _label(time: float, text: str) -> str:
    said = f"{time:.1f} s: {' '.join(text.split())}"
    return said if len(said) <= _LONGEST else said[: _LONGEST - 1] + "…"


def _marks(begin: float, end: float, events: Sequence[tuple[float, str]]) -> tuple[Any, ...]:
    """The ends with their times, and ticks where something happened."""
    times = sorted({round(time, 2) for time, _ in events if begin < time < end})
    ticks = times[:: max(1, -(-len(times) // _MOST_MARKS))]
    return ((begin, f"{begin:.1f}"), *ticks, (end, f"{end:.1f}"))
