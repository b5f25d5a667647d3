"""Where on the timeline one is, and how that goes on."""

from __future__ import annotations

SPEEDS = {
    "0.1 ×": 0.1,
    "0.25 ×": 0.25,
    "0.5 ×": 0.5,
    "1 ×": 1.0,
    "2 ×": 2.0,
    "5 ×": 5.0,
    "10 ×": 10.0,
}
"""By what the page calls them, s of the run per second."""


class Playback:
    """A clock between two times that can be stopped and set.

    Args:
        begin, end: s.

    Attributes:
        time: Where it is, s.
        speed: Seconds per second.
        playing: Whether it goes on.
    """

    def __init__(self, begin: float = 0.0, end: float = 0.0) -> None:
        self.begin, self.end = begin, end
        self.time, self.speed, self.playing = begin, 1.0, False

    def play(self) -> None:
        """Go on; from the start if it is at the end."""
        if self.time >= self.end:
            self.time = self.begin
        self.playing = self.end > self.begin

    def jump(self, time: float) -> None:
        """Set it, within its bounds."""
        self.time = min(max(time, self.begin), self.end)

    def advance(self, elapsed: float) -> bool:
        """Let `elapsed` s of the wall's clock pass; whether the time has changed."""
        if not self.playing:
            return False
        self.jump(self.time + self.speed * elapsed)
        if self.time >= self.end:
            self.playing = False
        return True
