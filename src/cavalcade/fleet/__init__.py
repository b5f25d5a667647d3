"""Robots that take velocity commands and report where they are."""

from cavalcade.fleet.ideal import IdealFleet
from cavalcade.fleet.protocol import (
    Fall,
    FallingFleet,
    Fleet,
    LeapingFleet,
    LeapRequest,
    Observation,
    SampledFleet,
)
from cavalcade.fleet.radio import CommandDelay, LocalisationNoise
from cavalcade.fleet.watchdog import Fault, Watchdog, WatchdogReport

__all__ = [
    "CommandDelay",
    "Fall",
    "FallingFleet",
    "Fault",
    "Fleet",
    "IdealFleet",
    "LeapRequest",
    "LeapingFleet",
    "LocalisationNoise",
    "Observation",
    "SampledFleet",
    "Watchdog",
    "WatchdogReport",
]
