"""Every error that Cavalcade raises on purpose; all derive from `CavalcadeError`.

"No plan" is a result with a reason, never an exception. An exception of this module means that
an input or an output place cannot be used; its message is one line that names where and what was
expected, so that the command line can print it as it stands.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


class CavalcadeError(Exception):
    """Base class of all errors raised on purpose."""


class InputError(CavalcadeError):
    """Something the user gave is malformed.

    Args:
        message: What is wrong and what was expected, without the place.
        file: The file it stands in, if any.
        key: The dotted key inside the file, or the argument's name, if any.
        choices: The valid values, if there is a short list of them.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        key: str | None = None,
        choices: Iterable[str] | None = None,
    ) -> None:
        self.file = None if file is None else str(file)
        self.key = key
        self.choices = None if choices is None else tuple(choices)
        place = ": ".join(part for part in (self.file, key) if part)
        text = f"{place}: {message}" if place else message
        if self.choices:
            text += f" (one of: {', '.join(self.choices)})"
        super().__init__(" ".join(text.split()))


class MapError(InputError):
    """A map, its picture or its description cannot be used."""


class ScenarioError(InputError):
    """A scenario file cannot be used."""


class OutputError(CavalcadeError):
    """A result cannot be written where the user asked for it."""


class RecordingError(InputError):
    """A recording or a result folder cannot be read."""
