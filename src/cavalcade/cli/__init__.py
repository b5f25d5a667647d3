"""The command line: `cavalcade run`, `check`, `campaign`, `trial` and so on."""

from __future__ import annotations

import gc
import sys
from collections.abc import Sequence

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, by default that of the process, and give its exit code."""
    # Imports and compilation make many objects that stay: looking for garbage among them as often
    # as Python does by default takes a tenth of a warm start.
    gc.set_threshold(100_000)
    try:
        # Here and not above, so that Ctrl-C may come from the first moment on.
        from cavalcade.cli.commands import run_command

        return run_command(arguments)
    except KeyboardInterrupt:
        # One that came within an `exec`, as dataclasses use on import, makes Python end by the
        # signal instead of with our exit code; a further `exec` makes it forget.
        exec("")
        print("cavalcade: interrupted", file=sys.stderr)
        return 130
