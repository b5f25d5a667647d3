"""Who of those who look at the page may change something: one drives, the others watch and ask."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from cavalcade.errors import InputError

ASKING = 30.0
"""Who asks to drive and is not answered is refused after so long, s."""


class Roles:
    """One drives; the others may ask, and whoever is there longest takes over from one who leaves.

    Each of those who look has a line of their own on top of the page that says which they are.

    Args:
        server: The page's `viser.ViserServer`.
        lock: Held while something changes.
        say: Tells one who looks something in passing.

    Attributes:
        driver: Identity of the client who drives; None while nobody is there.
        on_leave: Called, without the lock, when the one who drives has left or is cut off.
    """

    def __init__(self, server: Any, lock: Any, say: Callable[[str, Any], None]) -> None:
        self._server, self._lock, self._say = server, lock, say
        self.driver: int | None = None
        self.on_leave: list[Callable[[], None]] = []
        self._there: dict[int, Any] = {}
        self._lines: dict[int, tuple[Any, Any]] = {}
        self._asking: int | None = None
        self._question: Any = None
        self._patience: threading.Timer | None = None
        server.on_client_connect(self._come)
        server.on_client_disconnect(self._go)

    @property
    def count(self) -> int:
        """How many look."""
        with self._lock:
            return len(self._there)

    @property
    def asking(self) -> int | None:
        """Who asks to drive; None while nobody does."""
        with self._lock:
            return self._asking

    def ask(self, client: int) -> None:
        """Ask the one who drives to let this one drive.

        Raises:
            InputError: There is nothing to ask for.
        """
        with self._lock:
            if client == self.driver:
                raise InputError("you drive already")
            if client not in self._there:
                raise InputError("this tab is gone")
            if self.driver is None:
                self._let(client)
                return
            if self._asking is not None:
                mine = self._asking == client
                who = "you have asked" if mine else "somebody else has asked"
                raise InputError(f"{who} already, and is not answered yet")
            self._asking = client
            self._put_question(self._there[self.driver])
            self._patience = threading.Timer(ASKING, self.answer, (False, client))
            self._patience.daemon = True
            self._patience.start()
            self._show()

    def answer(self, granted: bool, asked_by: int | None = None) -> None:
        """The one who drives lets the other one drive, or not."""
        with self._lock:
            client = self._asking
            if client is None or asked_by not in (None, client):
                return
            self._forget_question()
            if granted:
                self._let(client)
            else:
                self._say("The one who drives keeps on driving", self._there[client])
                self._show()

    def close(self) -> None:
        """The studio ends."""
        with self._lock:
            self._forget_question()

    def _come(self, client: Any) -> None:
        with self._lock:
            if client.client_id not in self._server.get_clients():
                return  # gone before we heard of it
            self._there[client.client_id] = client
            text = client.gui.add_markdown("", order=-100.0)
            button = client.gui.add_button("Ask to drive", order=-99.0, icon="hand-stop")
            button.on_click(lambda _: self._clicked(client))
            self._lines[client.client_id] = text, button
            if self.driver is None:
                self.driver = client.client_id
            self._show()

    def _go(self, client: Any) -> None:
        left = client.client_id
        # Real robots do not wait for the lock.
        for act in self.on_leave if self.driver == left else ():
            act()
        with self._lock:
            self._there.pop(left, None)
            self._lines.pop(left, None)
            if self._asking in (left, None) or self.driver == left:
                self._forget_question()
            if self.driver == left:
                self.driver = next(iter(self._there), None)
                if self.driver is not None:
                    text = "The one who drove has left: you drive now"
                    self._say(text, self._there[self.driver])
            self._show()

    def _clicked(self, client: Any) -> None:
        try:
            self.ask(client.client_id)
        except InputError as error:
            self._say(str(error), client)

    def _let(self, client: int) -> None:
        before, self.driver = self.driver, client
        self._say("You drive now", self._there[client])
        if before in self._there:
            self._say("Another tab drives now; you watch", self._there[before])
        self._show()

    def _put_question(self, driver: Any) -> None:
        self._question = driver.gui.add_modal("Somebody else wants to drive")
        with self._question:
            driver.gui.add_markdown(
                "Another tab that looks at this page asks to drive. You would watch then."
            )
            yes = driver.gui.add_button("Let them drive", color="green")
            no = driver.gui.add_button("Keep driving")
        yes.on_click(lambda _: self.answer(True))
        no.on_click(lambda _: self.answer(False))

    def _forget_question(self) -> None:
        self._asking = None
        if self._patience is not None:
            self._patience.cancel()
            self._patience = None
        question, self._question = self._question, None
        if question is not None:
            question.close()

    def _show(self) -> None:
        """Say to each which they are; alone there is nothing to say."""
        others = len(self._there) - 1
        for client, (text, button) in self._lines.items():
            drives, asks = client == self.driver, client == self._asking
            watching = f"{others} other{'s' if others > 1 else ''} watch{'es' * (others == 1)}"
            if drives:
                text.content = f"**You drive**; {watching}" if others else ""
            else:
                text.content = "**You watch**" + (
                    "; asked to drive, waiting for an answer …" if asks else "; another tab drives"
                )
            text.visible = bool(others) or not drives
            button.visible, button.disabled = not drives, asks
