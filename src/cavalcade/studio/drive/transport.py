"""What starts, pauses and ends a drive, and says how it stands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from cavalcade.execution.steering import SPEEDS
from cavalcade.studio.drive.drive import Drive
from cavalcade.studio.session import Session

START, PAUSE, RESUME, STEP, STOP, RESTART, END = (
    "Start",
    "Pause",
    "Resume",
    "Step",
    "Stop",
    "Restart",
    "End",
)
EMERGENCY = "STOP ALL ROBOTS"


class Transport:
    """Status, buttons and pace.

    Args:
        session: The page.
        act: Called with the name of what was asked for.
        pace: Called with a new pace.
    """

    def __init__(
        self, session: Session, act: Callable[[str], None], pace: Callable[[float], None]
    ) -> None:
        gui = session.server.gui
        self._status = gui.add_markdown("")
        self._buttons = gui.add_button_group("", (START,))
        self._buttons.on_click(self._clicked)
        self._speed = gui.add_slider(
            "Speed (×)", SPEEDS[0], SPEEDS[1], 0.1, 1.0, hint="Simulated seconds per second"
        )
        self._speed.on_update(self._speed_changed)
        self._session, self._act, self._pace = session, act, pace
        self._asked = 1.0
        self._shown: tuple[str, ...] = (START,)

    @property
    def speed(self) -> float:
        """What the slider stands at."""
        return float(self._speed.value)

    def _clicked(self, event: Any) -> None:
        what = event.target.value  # before somebody else clicks, too
        self._session.handle(lambda _: self._act(what))(event)

    def _speed_changed(self, event: Any) -> None:
        def take(_: Any) -> None:
            self._asked = self.speed
            self._pace(self._asked)

        self._session.handle(take)(event)
        if self.speed != self._asked:  # one who watches has moved it
            self._speed.value = self._asked

    def show(self, drive: Drive | None, missing: str = "") -> None:
        """Say how it stands; `missing` is why nothing can be started."""
        self._offer(_offers(drive))
        self._speed.visible = drive is None or not drive.live
        text = _words(drive, missing)
        if text != self._status.content:
            self._status.content = text

    def _offer(self, names: tuple[str, ...]) -> None:
        if names != self._shown:
            self._shown = names
            self._buttons.options = names

    def play_or_pause(self) -> None:
        """Go on, stand still or begin, whichever is offered."""
        for name in (PAUSE, RESUME, START):
            if name in self._shown:
                self._act(name)
                return


def _offers(drive: Drive | None) -> tuple[str, ...]:
    """What can be done now; buttons stay where they are while something is driven."""
    phase = "ended" if drive is None else drive.phase
    if drive is None or phase == "ended":
        return (START,)
    go = RESUME if phase in ("paused", "stopped") else PAUSE
    if drive.live:
        return (END,) if phase == "preparing" else (go, END)
    return go, STEP, STOP, RESTART


def _words(drive: Drive | None, missing: str) -> str:
    if drive is None:
        return missing or "Ready. **Start** drives what is built, in simulation or for real"
    moment = drive.snapshot()
    text = f"**{drive.words}**"
    if moment is None:
        return text
    text += f"\n\n{moment.time:.1f} s"
    pace = getattr(drive, "pace", None)
    if pace is not None:
        asked = drive.speed  # type: ignore[attr-defined]
        slow = pace < 0.9 * asked and math.isfinite(asked)
        text += f" · {pace:.1f} × real time" + (f" (asked for {asked:.1f})" if slow else "")
    text += f" · cycle {1e3 * drive.planning:.1f} ms"
    return text + _robots(drive.lost)


def _robots(lost: Sequence[int]) -> str:
    if not lost:
        return ""
    names = ", ".join(map(str, lost))
    return f" · without robot{'s' if len(lost) > 1 else ''} {names}"
