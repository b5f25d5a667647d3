"""Whether those who look are still there: a cable that is pulled closes no connection.

viser lets a silent connection live for 40 s. What is used of it here is not part of what it
promises to keep.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

PERIOD, LIMIT = 0.5, 2.0
"""A page is asked so often whether it is there, and cut off when it has not answered for so long,
s. The browser answers, not the page: it may be busy."""

_LATE = 0.5
"""If an answer was waited for by so much longer than `LIMIT`, who asks was held up itself, s."""


class Heartbeat:
    """Closes connections of pages that do not answer.

    Args:
        server: A page's `viser.ViserServer`.
        wanted: Whether that matters at present, as while real robots are driven.
    """

    def __init__(self, server: Any, wanted: Callable[[], bool]) -> None:
        self._server, self._wanted = server, wanted
        self._watches: dict[int, Future[None]] = {}
        server.on_client_connect(self._come)
        server.on_client_disconnect(lambda client: self._go(client.client_id))

    def close(self) -> None:
        """Watch nobody any more."""
        for client in tuple(self._watches):
            self._go(client)

    def _come(self, client: Any) -> None:
        who, loop = client.client_id, self._server.get_event_loop()
        connection = self._server._websock_server._live_connections.get(who)
        if connection is not None:
            watch = _watch(connection, self._wanted)
            self._watches[who] = asyncio.run_coroutine_threadsafe(watch, loop)
        if who not in self._server.get_clients():
            self._go(who)  # gone before we heard of it

    def _go(self, client: int) -> None:
        watch = self._watches.pop(client, None)
        if watch is not None:
            watch.cancel()


async def _watch(connection: Any, wanted: Callable[[], bool]) -> None:
    from websockets.exceptions import ConnectionClosed

    clock = asyncio.get_running_loop()
    try:
        while True:
            await asyncio.sleep(PERIOD)
            if not wanted():
                continue
            asked = clock.time()
            answer = await connection.ping()
            try:
                await asyncio.wait_for(answer, LIMIT)
            except TimeoutError:
                if clock.time() - asked < LIMIT + _LATE:
                    connection.transport.abort()
                    return
    except ConnectionClosed:
        return
