"""Networks behind cards of this computer whose cables can be pulled, for tests."""

from __future__ import annotations

import os
import subprocess
from typing import Self

import pytest


class Cards:
    """Networks of their own, with a card of this computer in each; a test without them skips."""

    def __init__(self, count: int) -> None:
        tag = os.getpid() % 100_000
        self.namespaces = [f"cv{tag}n{k}" for k in range(count)]
        self.ours = [f"cv{tag}c{k}" for k in range(count)]
        self.theirs = "eth0"

    def __enter__(self) -> Self:
        try:
            self._make()
        except (OSError, subprocess.CalledProcessError) as error:
            self._remove()
            pytest.skip(f"networks cannot be made here: {error}")
        return self

    def __exit__(self, *_: object) -> None:
        self._remove()

    def _make(self) -> None:
        for k, (namespace, card) in enumerate(zip(self.namespaces, self.ours, strict=True)):
            net = f"10.{100 + os.getpid() % 100}.{k}"
            _ip("netns", "add", namespace)
            _ip(
                "link", "add", card, "type", "veth", "peer", "name", self.theirs, "netns", namespace
            )
            _ip("addr", "add", f"{net}.1/24", "dev", card)
            _ip("link", "set", card, "up")
            _ip("-n", namespace, "addr", "add", f"{net}.2/24", "dev", self.theirs)
            _ip("-n", namespace, "link", "set", self.theirs, "up")
            _ip("-n", namespace, "link", "set", "lo", "up")
            self._route(k)

    def pull(self, robot: int) -> None:
        _ip("-n", self.namespaces[robot], "link", "set", self.theirs, "down")

    def plug(self, robot: int) -> None:
        _ip("-n", self.namespaces[robot], "link", "set", self.theirs, "up")
        self._route(robot)

    def _route(self, robot: int) -> None:
        """For multicast, which goes with the link."""
        _ip("-n", self.namespaces[robot], "route", "add", "224.0.0.0/4", "dev", self.theirs)

    def _remove(self) -> None:
        for namespace, card in zip(self.namespaces, self.ours, strict=True):
            # A pair goes with either end, but with a namespace some time later.
            for what in (["link", "del", card], ["netns", "del", namespace]):
                subprocess.run(["ip", *what], capture_output=True, check=False)


def _ip(*arguments: str) -> None:
    subprocess.run(["ip", *arguments], check=True, capture_output=True)
