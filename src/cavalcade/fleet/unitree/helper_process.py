"""The process that drives one Go2: it streams commands, and stops the robot when nobody asks.

Started by `Robot` of this package, with the records that both share. It has the robot stop when
no order came for 0.5 s, and at once when the process that started it is gone; it is in a session
of its own, so that a Ctrl-C at the terminal does not reach it.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
from collections.abc import Generator, Iterator

from cavalcade.errors import InputError
from cavalcade.fleet.unitree.client import SportClient
from cavalcade.fleet.unitree.records import Order, Report, SharedRecords, Stage, Wish
from cavalcade.fleet.unitree.sdk import Network
from cavalcade.fleet.unitree.sport import NO_ANSWER, Api, Posture

SILENCE = 0.5
"""A fleet that says nothing for so long, s, is gone, or is not well."""

_TICK = 0.01
"""How often it looks at orders and states, s."""

_STREAM = 0.02
"""How often velocities are sent, s."""

_CHECKED = 25
"""One of so many velocities is sent as one that is answered, so that refusals are noticed."""

_AGAIN = 0.1
"""How long a stop waits for its answer before it is sent again, s."""

_ASKED_AGAIN = 1.0
"""How long another request waits for its answer before it is sent again, s."""

_STOPS = 5
"""How often a stop that nobody answers is sent again at the end."""

_RISING = 10.0
"""How long a robot may take to lie, to stand or to be ready to walk, s."""

_BATTERY = 0.5
"""How often the battery is looked at, s."""

_Steps = Iterator[None]
"""A routine: it is continued every tick, and ends or goes on for ever."""


class Helper:
    """Drives one robot as the shared order says.

    Args:
        records: Shared with the fleet.
        client: Of the robot.
        lifeline: Descriptor of a pipe that ends when the fleet's process does.
        damp: Whether a robot whose fleet is gone has its motors damped once it stands.
    """

    def __init__(
        self, records: SharedRecords, client: SportClient, lifeline: int, damp: bool
    ) -> None:
        self._records = records
        self._client = client
        self._lifeline = lifeline
        self._parent = os.getppid()
        self._damp_at_silence = damp
        self._order: Order | None = None
        self._stage = Stage.LISTENING
        self._now = 0.0
        self._doing: tuple[Wish, int, bool] = (Wish.WAIT, 0, False)
        self._routine: _Steps = iter(())
        self._battery_due = 0.0
        self._ordered = False
        self.terminated = False

    def run(self) -> None:
        """Until the fleet is done with the robot, or gone."""
        due = time.monotonic()
        while not self._tick():
            due = max(due + _TICK, time.monotonic() - _TICK)
            time.sleep(max(due - time.monotonic(), 0.0))

    def _tick(self) -> bool:
        """One look; whether all is done."""
        self._now = time.monotonic()
        self._client.poll(self._now)
        if self._now >= self._battery_due:
            self._client.look_at_battery()
            self._battery_due = self._now + _BATTERY
        self._order = self._records.order.read() or self._order
        alone = self.terminated or os.getppid() != self._parent or self._cut()
        wish, silent = self._wanted(alone)
        number = 0 if self._order is None else self._order.number
        if (wish, number, silent) != self._doing:
            self._doing = (wish, number, silent)
            self._routine = self._begin(wish, silent)
        ended = next(self._routine, self) is self
        self._tell()
        return ended and wish in (Wish.LEAVE, Wish.LIE)

    def _cut(self) -> bool:
        # Nothing is ever written into it: it can be read when its other end is gone.
        return bool(select.select([self._lifeline], [], [], 0.0)[0])

    def _wanted(self, alone: bool) -> tuple[Wish, bool]:
        """What to do now, and whether that is because nobody says anything any more."""
        order = self._order
        if alone:
            return Wish.LEAVE, True
        if order is None:
            return Wish.WAIT, False
        wish = Wish(order.wish)
        if self._now - order.beat > SILENCE and wish in (Wish.STAND, Wish.MOVE):
            return Wish.WAIT, True
        return wish, False

    def _begin(self, wish: Wish, silent: bool) -> _Steps:
        self._ordered |= wish in (Wish.STAND, Wish.MOVE, Wish.DAMP)
        if not self._ordered:
            return iter(())  # whatever it does is somebody else's business
        if wish is Wish.STAND:
            return self._rise()
        if wish is Wish.MOVE:
            return self._move()
        if wish is Wish.DAMP:
            return self._damp()
        if silent:
            return self._fall_silent()
        if wish in (Wish.LEAVE, Wish.LIE):
            return self._leave(lie=wish is Wish.LIE)
        return iter(())

    def _rise(self) -> _Steps:
        """Stand up, and balance: a robot that only stood up has locked its joints."""
        self._stage = Stage.RISING
        self._client.failures.clear()
        down = self._client.posture in ("damping", "lying")
        if down and not (yield from self._achieve(Api.STAND_UP, ("locked", "ready"))):
            return
        if (yield from self._achieve(Api.BALANCE_STAND, ("ready",))):
            self._stage = Stage.READY

    def _move(self) -> _Steps:
        """Stream the ordered velocity, to a robot that is ready to walk."""
        count = 0
        while True:
            order = self._order
            if order is not None and self._client.posture == "ready":
                answered = count % _CHECKED == 0
                self._client.move(order.x, order.y, order.turn, self._now, answered=answered)
                count += 1
            yield from self._pause(_STREAM)

    def _damp(self) -> _Steps:
        """Damp the motors, again and again until the robot does."""
        self._stage = Stage.LISTENING
        while True:
            self._client.ask(Api.DAMP, self._now)
            yield from self._pause(_AGAIN)
            while self._client.posture == "damping":
                yield

    def _fall_silent(self) -> _Steps:
        """Stop, and damp if that was asked for; nobody is there to see whether it worked."""
        yield from self._stop()
        ordered = self._order is not None and self._order.wish == Wish.DAMP
        if self._damp_at_silence or ordered:
            for _ in range(_STOPS):
                number = self._client.ask(Api.DAMP, self._now)
                yield from self._pause(_AGAIN)
                if self._client.answered(number):
                    return

    def _leave(self, lie: bool) -> _Steps:
        yield from self._stop()
        if lie and self._client.posture in ("ready", "locked"):
            yield from self._achieve(Api.STAND_DOWN, ("lying", "damping"))

    def _stop(self) -> _Steps:
        if self._client.posture == "damping":
            return
        for _ in range(_STOPS):
            number = self._client.ask(Api.STOP_MOVE, self._now)
            end = self._now + _AGAIN
            while self._now < end:
                yield
                if self._client.answered(number):
                    return

    def _achieve(self, api: Api, postures: tuple[Posture, ...]) -> Generator[None, None, bool]:
        """Ask until the robot has agreed and does so; whether it does."""
        client, end = self._client, self._now + _RISING
        asked: list[int] = []
        again = self._now
        while not (any(map(client.answered, asked)) and client.posture in postures):
            refused = client.failures.get(api, NO_ANSWER) != NO_ANSWER
            if refused or self._now > end:
                client.failures.setdefault(api, 0)
                self._stage = Stage.FAILED
                return False
            if self._now >= again and not any(map(client.answered, asked)):
                asked.append(client.ask(api, self._now))
                again = self._now + _ASKED_AGAIN
            yield
        return True

    def _pause(self, length: float) -> _Steps:
        end = self._now + length - 0.5 * _TICK
        while self._now < end:
            yield

    def _tell(self) -> None:
        client = self._client
        roll, pitch = client.tilt
        mode, error_code = client.state_codes
        api, code = next(iter(client.failures.items()), (0, 0))
        number = 0 if self._order is None else self._order.number
        self._records.report.write(
            Report(
                self._now,
                number,
                self._stage,
                client.heard,
                *client.pose,
                roll,
                pitch,
                mode,
                error_code,
                client.charge,
                api,
                code,
                client.rival,
            )
        )


def main(arguments: list[str]) -> int:
    """Drive a robot: MEMORY LIFELINE DOMAIN INTERFACE DAMP."""
    memory, lifeline, domain, interface, damp = arguments
    records = SharedRecords(int(memory))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(OSError):  # where that is allowed: a stop must not wait for others
        os.setpriority(os.PRIO_PROCESS, 0, -10)
    try:
        client = SportClient(Network(int(domain), interface))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    helper = Helper(records, client, int(lifeline), damp == "damp")

    def terminate(*_: object) -> None:
        helper.terminated = True

    signal.signal(signal.SIGTERM, terminate)
    helper.run()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
