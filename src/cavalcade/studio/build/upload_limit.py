"""Uploads that are too large, refused before they fill the memory.

viser keeps an upload in memory until it is complete and has no limit of its own; what is used of
it here is not part of what it promises to keep.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from cavalcade.studio.build.uploads import LIMIT


def refuse_early(server: Any, tell: Callable[[Any, str, int], None], limit: int = LIMIT) -> None:
    """Drop uploads of more than `limit` bytes as they begin.

    Args:
        server: `viser.ViserServer`.
        tell: Called with the client, the file's name and its size in bytes, in a thread.
    """
    from viser._messages import FileTransferPartAck, FileTransferStartUpload

    def begun(client_id: int, message: Any) -> None:
        if message.size_bytes <= limit:
            return
        server.gui._current_file_upload_states.pop(message.transfer_uuid, None)
        client = server.get_clients().get(client_id)
        if client is not None:
            # Otherwise the page would wait for its parts to arrive.
            client._websock_connection.queue_message(
                FileTransferPartAck(
                    source_component_uuid=message.source_component_uuid,
                    transfer_uuid=message.transfer_uuid,
                    transferred_bytes=message.size_bytes,
                    total_bytes=message.size_bytes,
                )
            )
        said = (client, message.filename, message.size_bytes)
        threading.Thread(target=tell, args=said, daemon=True).start()

    server._websock_server.register_handler(FileTransferStartUpload, begun)
