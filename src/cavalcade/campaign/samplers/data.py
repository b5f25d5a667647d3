"""Where the data of other projects lie, which this one does not bring along."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from cavalcade.errors import InputError

VARIABLE = "CAVALCADE_DATA"
"""The environment variable that names the folder."""

PLACES = (Path("data"), Path("../shared/data"))
"""Where it is looked for otherwise, from the working directory."""


@dataclass(frozen=True)
class DataFolder:
    """The folder of the data, if there is one.

    Attributes:
        path: Absolute; None where there is no such folder.
    """

    path: Path | None

    @classmethod
    def find(cls, named: str | Path | None = None) -> DataFolder:
        """The folder named, else that of `CAVALCADE_DATA`, else the first of `PLACES` there is.

        Raises:
            InputError: A folder is named that does not exist.
        """
        for key, given in (("data", named), (VARIABLE, os.environ.get(VARIABLE) or None)):
            if given is not None:
                if not Path(given).is_dir():
                    raise InputError(f"no such folder: {given}", key=key)
                return cls(Path(given).resolve())
        return cls(next((place.resolve() for place in PLACES if place.is_dir()), None))

    def file(self, name: str | Path) -> Path:
        """The absolute name of a file of the data; InputError if it is not there."""
        found = None if self.path is None else self.path / name
        if found is None or not found.is_file():
            raise InputError(self.lack(name))
        return found

    def lack(self, what: str | Path) -> str:
        """One line that says that something is not there, and how to name a folder that has it."""
        where = "there is no folder of data" if self.path is None else f"not in {self.path}"
        return f"{what}: {where}; name one that has it with --data or {VARIABLE}"
