"""What the numbers of the Go2's sport service mean, in the vendor's SDK and documentation.

Requests and codes are those of `unitree_sdk2py`: `go2/sport/sport_api.py`, `rpc/internal.py`. What
a robot does is told by `SportModeState.error_code` in newer firmware (a misnomer: it is the state
of the motion, not an error) and by its `mode` in older ones, which leave the other at 0; see the
vendor's "Sports Services" and https://github.com/unitreerobotics/unitree_sdk2_python/issues/175.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Literal

Posture = Literal["damping", "lying", "locked", "ready"]


class Api(IntEnum):
    """Requests of the sport service."""

    DAMP = 1001
    BALANCE_STAND = 1002
    STOP_MOVE = 1003
    STAND_UP = 1004
    STAND_DOWN = 1005
    RECOVERY_STAND = 1006
    MOVE = 1008


NO_ANSWER = 3104
"""What the SDK calls a request without an answer in time; no robot sends it."""

_CODES = {
    3001: "unknown error",
    3102: "the request could not be sent",
    3103: "the request is not registered",
    NO_ANSWER: "no answer in time: is the service sport_mode on?",
    3105: "the answer was one to another request",
    3106: "the request's data are wrong",
    3201: "the robot could not answer",
    3202: "internal error of the robot",
    3203: "the robot's firmware knows no such request",
    3204: "the robot refused the request's parameters",
    3205: "another program holds the robot's lease",
    3206: "there is no lease",
    3207: "there is a lease already",
    4101: "wrong number of path points",
    4201: "the robot's service took too long",
    4202: "the robot's service is not initialised",
}

_POSTURES: dict[int, Posture] = {
    1001: "damping",
    1002: "locked",
    1004: "lying",
    2006: "lying",
}
_OLD_POSTURES: dict[int, Posture] = {5: "lying", 6: "locked", 7: "damping"}


def name_of(api: int) -> str:
    """A request as the SDK calls it, such as `StandUp`."""
    known = api in Api.__members__.values()
    return Api(api).name.title().replace("_", "") if known else f"request {api}"


def meaning_of(code: int) -> str:
    """What a code of an answer means."""
    return _CODES.get(code, "unknown to the SDK")


def posture_of(error_code: int, mode: int) -> Posture:
    """What a robot does, of its state's two numbers: only a `ready` one walks when told to."""
    if error_code:
        return _POSTURES.get(error_code, "ready")
    return _OLD_POSTURES.get(mode, "ready")
