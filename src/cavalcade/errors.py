"""Every error that Cavalcade raises on purpose; all derive from `CavalcadeError`.

"No plan" is a result with a reason, never an exception. An exception of this module means that
an input or an output place cannot be used; its text is one line that names where and what was
expected, so that the command line can print it as it stands.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Self


class CavalcadeError(Exception):
    """Base class of all errors raised on purpose; they can be copied and pickled.

    Attributes:
        message: What is wrong and what was expected, without the place.
        file: The file it stands in, or that cannot be written, if any.
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
        super().__init__(message)
        self.message = message
        self.file = None if file is None else str(file)
        self.key = key
        self.choices = None if choices is None else tuple(choices)

    def __str__(self) -> str:
        parts = [part for part in (self.file, self.key) if part]
        text = ": ".join([*parts, self.message])
        if self.choices:
            text += f" (one of: {', '.join(self.choices)})"
        return " ".join(text.split())

    def at(self, *, file: str | Path | None = None, key: str | None = None) -> Self:
        """The same error at another place."""
        return type(self)(self.message, file=file, key=key, choices=self.choices)


class InputError(CavalcadeError):
    """Something the user gave is malformed."""


class MapError(InputError):
    """A map, its picture or its description cannot be used."""


class ScenarioError(InputError):
    """A scenario file cannot be used."""


class OutputError(CavalcadeError):
    """A result cannot be written where the user asked for it."""


class RecordingError(InputError):
    """A recording or a result folder cannot be read."""


class FleetError(CavalcadeError):
    """Robots cannot be reached, or do not do what has to be done before they can be driven."""
