"""The page's server, and what all of its parts share."""

from __future__ import annotations

import logging
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rich

from cavalcade.errors import CavalcadeError, InputError
from cavalcade.studio.roles import Roles
from cavalcade.studio.scene.lights import light
from cavalcade.studio.scene.stage import Stage

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
        roles: Who drives.
        themed: Called when the page turns dark or light.
        lock: Held by every callback; whoever changes the session from a thread takes it, too.

    Raises:
        InputError: viser is not installed, or nobody may listen there.
    """

    def __init__(self, host: str = HOST, port: int = PORT, *, folder: Path) -> None:
        viser = load_viser()
        _check_address(host, port)
        self.folder = folder
        self.lock = threading.RLock()
        with _silent():
            self.server = viser.ViserServer(host=host, port=port, label="Cavalcade", verbose=False)
        self.server.gui.main_panel.dock_right()
        self.themed: list[Callable[[], None]] = []
        self._dark = True
        self._theme()
        light(self.server)
        self.stage = Stage(self.server)
        self.roles = Roles(self.server, self.lock, lambda text, who: self.say(text, client=who))

    @property
    def driver(self) -> int | None:
        """Identity of the client who drives; None while nobody is there."""
        return self.roles.driver

    @property
    def address(self) -> str:
        """Where the page is, as a browser on this machine finds it."""
        host = self.server.get_host()
        shown = "localhost" if host in ("0.0.0.0", "::", "") else host
        return f"http://{shown}:{self.server.get_port()}"

    @property
    def dark(self) -> bool:
        """Whether the page is dark; settable."""
        return self._dark

    @dark.setter
    def dark(self, value: bool) -> None:
        if value == self._dark:
            return
        self._dark = value
        self._theme()
        self.stage.set_dark(value)
        for act in tuple(self.themed):
            act()

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
            client = getattr(event, "client", None)  # None: it was us, or has just gone
            who = getattr(event, "client_id", None)
            if who is None and client is not None:
                who = client.client_id
            if who is not None and who != self.driver:
                if client is not None:
                    self.say("Another tab drives; ask it with the button above", client=client)
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

    def download(self, event: Any, name: str, content: bytes) -> None:
        """Send a file to who has clicked."""
        if event.client is not None:
            event.client.send_file_download(name, content, save_immediately=True)

    def close(self) -> None:
        """Close the page."""
        self.roles.close()
        with _silent():
            self.server.stop()

    def _theme(self) -> None:
        self.server.gui.configure_theme(
            control_width="large", show_logo=False, show_share_button=False, dark_mode=self._dark
        )


@contextmanager
def _silent() -> Iterator[None]:
    """While viser would say in the terminal what is for us to say."""
    console = rich.get_console()
    quiet, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = quiet


def _check_address(host: str, port: int) -> None:
    """Viser would go on to the next port that is free."""
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        family, kind, protocol, _, address = found[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except OSError as error:
        why = error.strerror or str(error)
        text = (
            f"cannot listen on {host}, port {port}: {why}; expected a free port, such as --port 0"
        )
        raise InputError(text, key="port") from None
