"""Robots that take velocity commands and report where they are."""

from cavalcade.fleet.ideal import CommandDelay, IdealFleet, LocalisationNoise
from cavalcade.fleet.protocol import Fleet, LeapingFleet, LeapRequest, Observation
from cavalcade.fleet.watchdog import Fault, Watchdog, WatchdogReport

__all__ = [
    "CommandDelay",
    "Fault",
    "Fleet",
    "IdealFleet",
    "LeapRequest",
    "LeapingFleet",
    "LocalisationNoise",
    "Observation",
    "Watchdog",
    "WatchdogReport",
]
