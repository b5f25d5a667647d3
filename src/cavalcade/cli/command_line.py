"""From the words of a command to its exit code.

Exit codes: 0 done as asked; 1 not achieved; 2 bad input, one line on stderr; 130 interrupted.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence

import typer

from cavalcade.cli.commands import app
from cavalcade.errors import CavalcadeError

BAD_INPUT, INTERRUPTED = 2, 130

# The base of everything typer says about a wrong option; some versions bring their own click.
_UsageError: type[Exception] = typer.BadParameter.__mro__[2]


def run_command(arguments: Sequence[str] | None) -> int:
    """Run one command and give its exit code.

    Raises:
        KeyboardInterrupt: Ctrl-C.
    """
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        try:
            code = app(
                args=None if arguments is None else list(arguments),
                prog_name="cavalcade",
                standalone_mode=False,
            )
            sys.stdout.flush()
        except typer.Abort:
            raise KeyboardInterrupt from None
        except CavalcadeError as error:
            return _refuse(str(error))
        except _UsageError as error:
            return _refuse(getattr(error, "format_message", error.__str__)())
        except BrokenPipeError:
            # Whoever read our output has seen enough. Nothing may be flushed into it at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 1
        except OSError as error:
            return _refuse(f"{error.filename or 'output'}: {error.strerror or error}")
    if code == INTERRUPTED:  # what typer makes of Ctrl-C
        raise KeyboardInterrupt
    return int(code or 0)


def _refuse(message: str) -> int:
    print(f"cavalcade: {' '.join(message.split())}", file=sys.stderr)
    return BAD_INPUT


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    print(f"cavalcade: warning: {' '.join(str(message).split())}", file=sys.stderr)
