"""Where trials are carried out: on this machine's cores, or on a cluster."""

from __future__ import annotations

import os

from cavalcade.campaign.engines.protocol import Ended, Engine, cores
from cavalcade.errors import InputError

ENGINES = ("local", "ray")

MOST_PER_CORE = 16
"""Processes; each takes some 200 MB."""

__all__ = ["ENGINES", "Ended", "Engine", "make_engine"]


def make_engine(name: str, workers: int | None) -> Engine:
    """An engine by its name, not started yet; as many trials at a time as cores without `workers`.

    Raises:
        InputError: There is no such engine, or it is not installed.
    """
    if workers is not None and workers < 1:
        raise InputError(f"expected a whole number from 1 on, got {workers}", key="--workers")
    most = MOST_PER_CORE * cores()
    here = name == "local" or not os.environ.get("RAY_ADDRESS")
    if workers is not None and here and workers > most:
        text = f"expected at most {most} on this machine's cores ({cores()}), got {workers}"
        raise InputError(text, key="--workers")
    if name == "local":
        from cavalcade.campaign.engines.local import LocalEngine

        return LocalEngine(workers)
    if name == "ray":
        from cavalcade.campaign.engines.ray import RayEngine

        return RayEngine(workers)
    from cavalcade.values import did_you_mean

    text = f"unknown engine {ascii(name)[:40]}{did_you_mean(name, ENGINES)}"
    raise InputError(text, key="--engine", choices=ENGINES)
