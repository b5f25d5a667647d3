"""Whether those who look are still there: a cable that is pulled closes no connection.

viser lets a silent connection live for 40 s. What is used of it here is not part of what it
promises to keep.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

PERIOD, LIMIT = 0.5, 2.0
"""A page is asked so often whether it is there, and cut off when it has not answered for so long,
s. The browser answers, not the page: it may be busy."""

_LATE = 0.5
"""If an answer was waited for by so much longer than `LIMIT`, who asks was held up itself, s."""


def cut_off_silent(server: Any, wanted: Callable[[], bool]) -> None:
    """Close connections of pages that do not answer.

    Args:
        server: A page's `viser.ViserServer`.
        wanted: Whether that matters at present, as while real robots are driven.
    """
    loop = server.get_event_loop()

    def come(client: Any) -> None:
        connection = server._websock_server._live_connections.get(client.client_id)
        if connection is not None:
            asyncio.run_coroutine_threadsafe(_watch(connection, wanted), loop)

    server.on_client_connect(come)


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
