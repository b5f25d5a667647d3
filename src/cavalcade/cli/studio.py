"""`cavalcade studio`: the page in the browser."""

from __future__ import annotations

import signal
import threading
import webbrowser
from pathlib import Path
from typing import Annotated

import typer


def studio(
    shown: Annotated[
        str | None,
        typer.Argument(
            metavar="[SCENARIO|DIR]",
            help="A shipped scenario's name, a file, or the folder of a run or a campaign.",
        ),
    ] = None,
    port: Annotated[
        int, typer.Option(metavar="N", min=0, max=65535, help="0 takes any that is free.")
    ] = 8080,
    host: Annotated[
        str, typer.Option(metavar="H", help="Where it listens; 0.0.0.0 is everywhere.")
    ] = "127.0.0.1",
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="For uploads and the results of drives.")
    ] = Path("runs/studio"),
    open_browser: Annotated[bool, typer.Option("--open", help="Open the browser.")] = False,
) -> None:
    """Build, drive and study teams in the browser, until Ctrl-C."""
    from cavalcade.studio.app import Studio

    ended = threading.Event()
    ends = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP")]
    with Studio(host, port, folder=out) as page:
        if shown is not None:
            page.open(shown)
        before = {name: signal.signal(name, lambda *_: ended.set()) for name in ends}
        try:
            print(f"The studio is at {page.session.address}; Ctrl-C ends it", flush=True)
            if open_browser:
                webbrowser.open(page.session.address)
            while not ended.wait(0.5):
                pass
        finally:
            for name, handler in before.items():
                signal.signal(name, handler)
    if out.is_dir():
        print(f"What it leaves is in {out}")
