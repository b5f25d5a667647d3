"""A Go2 without a robot: `python -m cavalcade.fleet.unitree.mock --domain 1`.

It hears and says what a Go2 does, in the vendor's message types: requests are answered with
codes, `StandUp` locks the joints and `BalanceStand` frees them, `Move` is obeyed only then and
wears off a second after the last one. Real robots walk on for "a second or two"
(https://github.com/legion1581/unitree_webrtc_connect/issues/30), which is why they must be
stopped by somebody. While it runs, lines on its standard input make it misbehave; see `COMMANDS`.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import select
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cavalcade.errors import InputError
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
from cavalcade.fleet.unitree.sport import Api, name_of

COMMANDS = """lines on standard input:
  refuse API CODE   answer requests of that number with a code; 0 obeys again
  mute | speak      answer no requests, or all
  battery PERCENT   the charge
  freeze | thaw     stand still whatever is asked, or obey
  fall              fall over
  quit              switch off"""

_TICK = 0.01
_WEARS_OFF = 1.0
_FASTEST = (2.5, 1.0, 4.0)
"""m/s, m/s and rad/s that `Move` takes at most."""

_LAG = 0.15
"""Time constant with which legs follow a velocity, s."""

_TOLD = 0.05
"""How often the log says where it is, s."""

_LOW = 0.1
"""How often the battery is said, s; a robot says it 500 times a second."""

_STATES = {"damping": 1001, "locked": 1002, "lying": 2006, "ready": 1013}
_POSTURES = {
    Api.DAMP: ("damping", 0.05, ("damping", "locked", "lying", "ready")),
    Api.STAND_UP: ("locked", 0.8, ("damping", "locked", "lying", "ready")),
    Api.STAND_DOWN: ("lying", 0.8, ("locked", "ready")),
    Api.BALANCE_STAND: ("ready", 0.2, ("locked", "ready")),
    Api.RECOVERY_STAND: ("ready", 1.5, ("damping", "locked", "lying", "ready")),
}
"""What a request leads to, how long that takes, s, and from where it does."""


@dataclass(frozen=True)
class MockSettings:
    """What a mock is like.

    Attributes:
        start: Its true pose, x, y in m, yaw in rad; its odometry begins at the same numbers.
        latency: Until a request is obeyed, s.
        loss: Share of the requests and states that are lost.
        drift: Error of the odometry, m and rad per metre.
        seed: Of what is random.
    """

    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    latency: float = 0.0
    loss: float = 0.0
    drift: float = 0.0
    seed: int = 0


class MockGo2:
    """One robot that is none.

    Attributes:
        posture: What it does.
        pose: Its true one.
        log: What it was asked and where it was, newest last; emptied by whoever reads it.
    """

    def __init__(self, network: Network, settings: MockSettings) -> None:
        self._network = network  # it ends with the last one who holds it
        self._sdk = load_sdk()
        self._settings = settings
        self._random = random.Random(settings.seed)
        self._requests = network.reader(REQUESTS, self._sdk.request_type, 200, reliable=True)
        self._responses = network.writer(RESPONSES, self._sdk.response_type)
        self._states = network.writer(SPORT_STATE, self._sdk.sport_state_type)
        self._low_states = network.writer(LOW_STATE, self._sdk.low_state_type)
        self._state = self._sdk.sport_state()
        self._low_state = self._sdk.low_state()
        self.posture = "damping"
        self.pose = list(settings.start)
        self.log: list[dict[str, Any]] = []
        self._odometry = list(settings.start)
        sign = self._random.choice((-1.0, 1.0))
        self._scale, self._bend = 1.0 + settings.drift * sign, settings.drift * -sign
        self._velocity = [0.0, 0.0, 0.0]
        self._wanted = [0.0, 0.0, 0.0]
        self._until = -math.inf
        self._change: tuple[float, str] | None = None
        self._waiting: list[tuple[float, Any]] = []
        self._refused: dict[int, int] = {}
        self._mute = self._frozen = self._fallen = False
        self._charge = 80
        self._low_due = self._told = -math.inf

    def command(self, line: str) -> bool:
        """Misbehave as a line says, see `COMMANDS`; whether it is to go on."""
        word, *rest = line.split() or [""]
        if word == "refuse":
            self._refused[int(rest[0])] = int(rest[1])
        elif word in ("mute", "speak"):
            self._mute = word == "mute"
        elif word == "battery":
            self._charge = int(rest[0])
        elif word in ("freeze", "thaw"):
            self._frozen = word == "freeze"
        elif word == "fall":
            self._fallen, self.posture = True, "damping"
        self.log.append({"t": time.time(), "told": line.strip()})
        return word != "quit"

    def tick(self, now: float, dt: float) -> None:
        """Let `dt` s pass."""
        for request in take(self._requests, 200):
            if self._random.random() >= self._settings.loss:
                self._waiting.append((now + self._settings.latency, request))
        while self._waiting and self._waiting[0][0] <= now:
            self._obey(self._waiting.pop(0)[1], now)
        if self._change is not None and now >= self._change[0]:
            self.posture, self._change = self._change[1], None
        self._walk(now, dt)
        if self._random.random() >= self._settings.loss:
            self._say_state(now)
        if now >= self._low_due:
            self._low_due = now + _LOW
            self._low_state.bms_state.soc = self._charge
            write(self._low_states, self._low_state)
        if now >= self._told:
            self._told = now + _TOLD
            self.log.append(
                {"t": now, "pose": list(self.pose), "v": self._velocity, "is": self.posture}
            )

    def _obey(self, request: Any, now: float) -> None:
        api = request.header.identity.api_id
        try:
            values = json.loads(request.parameter)
            velocity = [float(values[key]) for key in "xyz"] if api == Api.MOVE else []
            code = self._refused.get(api, 0) or (0 if api in list(Api) else 3203)
        except (ValueError, KeyError, TypeError):
            velocity, code = [], 3204
        self.log.append({"t": now, "api": api, "v": velocity, "code": code})
        if not code:
            self._do(Api(api), velocity, now)
        if not (request.header.policy.noreply or self._mute):
            write(self._responses, self._sdk.response(request.header.identity.id, api, code))

    def _do(self, api: Api, velocity: Sequence[float], now: float) -> None:
        if api is Api.MOVE:
            # Agreed to in every state, but done by a robot that is ready only.
            self._wanted = [
                max(-most, min(most, value)) for most, value in zip(_FASTEST, velocity, strict=True)
            ]
            self._until = now + _WEARS_OFF
        elif api is Api.STOP_MOVE:
            self._until = -math.inf
        else:
            to, takes, possible = _POSTURES[api]
            if self.posture in possible and (not self._fallen or api is Api.RECOVERY_STAND):
                self._fallen = False
                self._until = -math.inf
                if self._change is None or self._change[1] != to:
                    self._change = now + takes, to

    def _walk(self, now: float, dt: float) -> None:
        goes = self.posture == "ready" and not self._frozen and now < self._until
        share = 1.0 if self.posture != "ready" else min(dt / _LAG, 1.0)
        wanted = self._wanted if goes else [0.0, 0.0, 0.0]
        self._velocity = [v + share * (w - v) for v, w in zip(self._velocity, wanted, strict=True)]
        x, y, turn = self._velocity
        moved = math.hypot(x, y) * dt
        for pose, scale, bend in ((self.pose, 1.0, 0.0), (self._odometry, self._scale, self._bend)):
            c, s = math.cos(pose[2]), math.sin(pose[2])
            pose[0] += scale * (c * x - s * y) * dt
            pose[1] += scale * (s * x + c * y) * dt
            pose[2] += turn * dt + bend * moved

    def _say_state(self, now: float) -> None:
        state = self._state
        state.stamp.sec, state.stamp.nanosec = int(now), int(now % 1.0 * 1e9)
        state.error_code = _STATES[self.posture]
        state.mode = {"damping": 7, "locked": 6, "lying": 5, "ready": 1}[self.posture]
        x, y, yaw = self._odometry
        up = self.posture in ("locked", "ready")
        state.position = [x, y, 0.32 if up else 0.08]
        state.body_height = 0.32 if up else 0.08
        roll = 1.5 if self._fallen else 0.0
        state.imu_state.rpy = [roll, 0.0, math.remainder(yaw, 2.0 * math.pi)]
        state.velocity = [*self._velocity[:2], 0.0]
        state.yaw_speed = self._velocity[2]
        write(self._states, state)


def run(robot: MockGo2, log: bool) -> None:
    """Live until `quit`, SIGTERM or Ctrl-C; what it is asked goes to standard output."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    listening, posture = True, ""
    last = time.time()
    try:
        while True:
            now = time.time()
            robot.tick(now, min(now - last, 0.1))
            last = now
            entries, robot.log = robot.log, []
            for entry in entries:
                if log:
                    print(json.dumps(entry), flush=True)
                elif entry.get("api", Api.MOVE) != Api.MOVE:
                    print(f"{name_of(entry['api'])}: code {entry['code']}", flush=True)
            if robot.posture != posture and not log:
                print(f"it is {robot.posture}", flush=True)
            posture = robot.posture
            if listening and select.select([sys.stdin], [], [], 0.0)[0]:
                line = sys.stdin.readline()
                listening = bool(line)
                try:
                    if not robot.command(line):
                        return
                except (ValueError, IndexError):
                    print(COMMANDS, flush=True)
            time.sleep(max(0.0, now + _TICK - time.time()))
    except (KeyboardInterrupt, BrokenPipeError):
        return


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="python -m cavalcade.fleet.unitree.mock",
        description="A Go2 that is none, for tests and trials of `--backend unitree`.",
        epilog=COMMANDS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--domain", type=int, default=0, help="of DDS (0)")
    parser.add_argument("--interface", default="lo", help="of the network (lo)")
    parser.add_argument(
        "--start", type=float, nargs=3, default=(0.0, 0.0, 0.0), metavar=("X", "Y", "YAW"),
        help="where it stands, m and rad",
    )  # fmt: skip
    parser.add_argument("--latency", type=float, default=0.0, help="of requests, s")
    parser.add_argument("--loss", type=float, default=0.0, help="share of messages, 0 to 1")
    parser.add_argument("--drift", type=float, default=0.0, help="of odometry, m per m")
    parser.add_argument("--seed", type=int, default=0, help="of what is random")
    parser.add_argument("--log", action="store_true", help="all it hears, as lines of JSON")
    said = parser.parse_args(arguments)
    try:
        network = Network(said.domain, said.interface)
        x, y, yaw = said.start
        settings = MockSettings((x, y, yaw), said.latency, said.loss, said.drift, said.seed)
        robot = MockGo2(network, settings)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"a Go2 in domain {said.domain} on {said.interface}", file=sys.stderr, flush=True)
    run(robot, said.log)
    return 0


if __name__ == "__main__":
    sys.exit(main())
