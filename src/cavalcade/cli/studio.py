"""`cavalcade studio`: the page in the browser."""

from __future__ import annotations

import signal
import tempfile
import threading
import webbrowser
from pathlib import Path
from typing import Annotated

import typer


def studio(
    shown: Annotated[
        str | None,
        typer.Argument(metavar="[SCENARIO|DIR]", help="A scenario, or the folder of a run."),
    ] = None,
    port: Annotated[
        int, typer.Option(metavar="N", min=0, max=65535, help="0 takes any that is free.")
    ] = 8080,
    host: Annotated[
        str, typer.Option(metavar="H", help="Where it listens; 0.0.0.0 is everywhere.")
    ] = "127.0.0.1",
    open_browser: Annotated[bool, typer.Option("--open", help="Open the browser.")] = False,
) -> None:
    """Build, drive and study teams in the browser, until Ctrl-C."""
    from cavalcade.studio.app import Studio

    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    with (
        tempfile.TemporaryDirectory(prefix="cavalcade-studio-") as folder,
        Studio(host, port, folder=Path(folder)) as page,
    ):
        if shown is not None:
            page.open(shown)
        print(f"The studio is at {page.session.address}; Ctrl-C ends it", flush=True)
        if open_browser:
            webbrowser.open(page.session.address)
        while not ended.wait(0.5):
            pass
