"""The sport service of one robot: requests, their answers, and what the robot says of itself."""

from __future__ import annotations

import json
import math
from collections import deque
from typing import Any

from cavalcade.fleet.unitree.sdk import (
    LOW_STATE,
    REQUESTS,
    RESPONSES,
    SPORT_STATE,
    Network,
    load_sdk,
    take,
    write,
)
from cavalcade.fleet.unitree.sport import NO_ANSWER, Api, Posture, posture_of

_PATIENCE = 1.5
"""An answer that is not there after so long, s, is not coming; the SDK waits 1 s."""


class SportClient:
    """Talks to one robot and never waits for it.

    Attributes:
        heard: When the last sport state came, s of the caller's clock; 0 if none did.
        failures: The last code of each request whose last answer was not 0.
        charge: Of the battery, %; -1 if it was not heard.
        rival: When another program last told it to move, s of the caller's clock; 0 if none did.
    """

    def __init__(self, network: Network) -> None:
        self._network = network  # it ends with the last one who holds it
        self._sdk = load_sdk()
        self._requests = network.writer(REQUESTS, self._sdk.request_type)
        self._responses = network.reader(RESPONSES, self._sdk.response_type, 50)
        self._states = network.reader(SPORT_STATE, self._sdk.sport_state_type)
        self._low_states = network.reader(LOW_STATE, self._sdk.low_state_type)
        self._foreign = network.reader(REQUESTS, self._sdk.request_type, 10, others=True)
        self._state: Any = None
        self._pending: dict[int, tuple[Api, float]] = {}
        self._last = 0
        self.heard = 0.0
        self.failures: dict[Api, int] = {}
        self._answered: deque[int] = deque(maxlen=50)
        self._last_answer: dict[Api, float] = {}
        self.charge = -1.0
        self.rival = 0.0

    def ask(self, api: Api, now: float, values: dict[str, float] | None = None) -> int:
        """Send a request that is answered; its number."""
        number = self._send(api, now, values or {}, no_reply=False)
        self._pending[number] = (api, now + _PATIENCE)
        return number

    def move(self, x: float, y: float, turn: float, now: float, *, answered: bool) -> None:
        """Walk with a body-frame velocity, m/s and rad/s; most of these are not answered."""
        velocity = {"x": x, "y": y, "z": turn}
        if answered:
            self.ask(Api.MOVE, now, velocity)
        else:
            self._send(Api.MOVE, now, velocity, no_reply=True)

    def answered(self, number: int) -> bool:
        """Whether the robot did as this request said."""
        return number in self._answered

    def poll(self, now: float) -> None:
        """Take over what has come since."""
        for state in take(self._states):
            self._state, self.heard = state, now
        for response in take(self._responses, 50):
            number = response.header.identity.id
            asked = self._pending.pop(number, None)
            if asked is None:
                continue  # of another program's request
            self._last_answer[asked[0]] = now
            code = response.header.status.code
            if code == 0:
                self._answered.append(number)
                self.failures.pop(asked[0], None)
            else:
                self.failures[asked[0]] = code
        if any(r.header.identity.api_id == Api.MOVE for r in take(self._foreign, 10)):
            self.rival = now
        for number, (api, until) in list(self._pending.items()):
            if now > until:
                del self._pending[number]
                # One answer may be lost on its way; no answer at all is another matter.
                if self._last_answer.get(api, 0.0) < until - _PATIENCE:
                    self.failures.setdefault(api, NO_ANSWER)

    def look_at_battery(self) -> None:
        """Take the charge over; the message is long, and comes 500 times a second."""
        for state in take(self._low_states):
            self.charge = float(state.bms_state.soc)

    @property
    def pose(self) -> tuple[float, float, float]:
        """Its odometry: x, y in m, yaw in rad; nan before the first state."""
        if self._state is None:
            return math.nan, math.nan, math.nan
        x, y, _ = self._state.position
        return float(x), float(y), float(self._state.imu_state.rpy[2])

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch, rad."""
        if self._state is None:
            return 0.0, 0.0
        roll, pitch, _ = self._state.imu_state.rpy
        return float(roll), float(pitch)

    @property
    def state_codes(self) -> tuple[int, int]:
        """The state's `mode` and `error_code`."""
        return (0, 0) if self._state is None else (self._state.mode, self._state.error_code)

    @property
    def posture(self) -> Posture | None:
        """What it does; None before the first state."""
        mode, error_code = self.state_codes
        return None if self._state is None else posture_of(error_code, mode)

    def _send(self, api: Api, now: float, values: dict[str, float], no_reply: bool) -> int:
        # As the SDK does it: numbers are times, and are never used twice.
        self._last = max(int(now * 1e9), self._last + 1)
        message = self._sdk.request(self._last, int(api), json.dumps(values), no_reply)
        write(self._requests, message)
        return self._last
