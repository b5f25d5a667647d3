"""The page's server, and who of those who look at it may change something."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cavalcade.errors import CavalcadeError, InputError
from cavalcade.studio.lights import light
from cavalcade.studio.stage import Stage

_LOG = logging.getLogger(__name__)

HOST, PORT = "127.0.0.1", 8080


def load_viser() -> Any:
    """The module `viser`.

    Raises:
        InputError: It is not installed.
    """
    try:
        import viser
    except ImportError as error:
        raise InputError(
            "the studio needs viser: pip install 'cavalcade[studio]'", key="studio"
        ) from error
    return viser


class Session:
    """One session that everybody sees who opens the page; one of them drives.

    Callbacks run one after another, in threads of the server. What goes wrong in one is said on
    the page, in the words of our own errors.

    Args:
        host, port: Where it listens; port 0 takes any that is free.
        folder: For uploads and results; made where it is missing.

    Attributes:
        server: `viser.ViserServer`.
        stage: The scene.
        lock: Held by every callback; whoever changes the session from a thread takes it, too.
        driver: Identity of the client who drives; None while nobody is there.
    """

    def __init__(self, host: str = HOST, port: int = PORT, *, folder: Path) -> None:
        viser = load_viser()
        self.folder = folder
        self.lock = threading.RLock()
        self.driver: int | None = None
        self.server = viser.ViserServer(host=host, port=port, label="Cavalcade", verbose=False)
        self.server.gui.configure_theme(
            control_width="large",
            show_logo=False,
            show_share_button=False,
            dark_mode=True,
        )
        self.server.gui.main_panel.dock_right()
        light(self.server)
        self.stage = Stage(self.server)
        self.server.on_client_connect(self._on_connect)
        self.server.on_client_disconnect(self._on_disconnect)

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{self.server.get_host()}:{self.server.get_port()}"

    def say(self, text: str, title: str = "", client: Any = None, bad: bool = False) -> None:
        """Tell one who looks, or all, something in passing."""
        clients = [client] if client is not None else list(self.server.get_clients().values())
        for one in clients:
            one.add_notification(
                title=title or ("That does not work" if bad else "Cavalcade"),
                body=text,
                color="red" if bad else None,
                auto_close_seconds=12.0 if bad else 5.0,
            )

    def handle(self, act: Callable[[Any], None]) -> Callable[[Any], None]:
        """A callback of the page's: for who drives, one at a time, errors in words."""

        def callback(event: Any) -> None:
            client = getattr(event, "client", None)
            if client is not None and client.client_id != self.driver:
                self.say("another tab drives; ask it with the button above", client=client)
                return
            self.attempt(lambda: act(event), client)

        return callback

    def attempt(self, act: Callable[[], None], client: Any = None) -> bool:
        """Do something, and say on the page why it could not be done."""
        with self.lock:
            try:
                act()
            except CavalcadeError as error:
                self.say(str(error), client=client, bad=True)
                return False
            except Exception as error:
                _LOG.exception("a callback of the page has failed")
                text = f"{type(error).__name__}: {error}. This is a fault of the studio's own"
                self.say(text, client=client, bad=True)
                return False
        return True

    def close(self) -> None:
        """Close the page."""
        self.server.stop()

    def _on_connect(self, client: Any) -> None:
        with self.lock:
            if self.driver is None:
                self.driver = client.client_id

    def _on_disconnect(self, client: Any) -> None:
        with self.lock:
            if self.driver == client.client_id:
                left = [one for one in self.server.get_clients() if one != client.client_id]
                self.driver = left[0] if left else None
