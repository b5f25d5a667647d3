"""Robots that take velocity commands and report where they are."""

from cavalcade.fleet.ideal import CommandDelay, IdealFleet, LocalisationNoise
from cavalcade.fleet.protocol import Fleet, Observation
from cavalcade.fleet.watchdog import Fault, Watchdog, WatchdogReport

__all__ = [
    "CommandDelay",
    "Fault",
    "Fleet",
    "IdealFleet",
    "LocalisationNoise",
    "Observation",
    "Watchdog",
    "WatchdogReport",
]
