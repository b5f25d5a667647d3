"""What scenario files say was renamed: the old spelling is taken, with a warning."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cavalcade.errors import ScenarioError

KEYS = {"planner.expect.stray": "planner.expect.tracking_error"}
"""Dotted keys, old to new; only the last part changes."""

VALUES = {"planner.variant": {"cavalcade-no-standoffs": "cavalcade-no-recovery"}}
"""Values of dotted keys, old to new."""


class RenamedWarning(UserWarning):
    """A scenario says something in its old spelling."""


def current_value(key: str, value: Any, file: str | Path | None = None) -> Any:
    """A key's value in its present spelling; others come back as they are."""
    new = VALUES.get(key, {}).get(value) if isinstance(value, str) else None
    if new is None:
        return value
    _warn(f"{key}: {value}", new, file)
    return new


def with_current_spelling(
    data: Mapping[str, Any], file: str | Path | None = None
) -> dict[str, Any]:
    """A scenario's plain data in the present spelling; `data` itself stays as it is.

    Raises:
        ScenarioError: A key stands there in both spellings.
    """
    return _renamed(data, "", file)


def _renamed(data: Mapping[str, Any], place: str, file: str | Path | None) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in data.items():
        key = f"{place}{name}"
        new = KEYS.get(key)
        if new is not None:
            _warn(key, new, file)
            name = new.rpartition(".")[2]
            if name in data:
                raise ScenarioError(f"stands there as {new}, too", file=file, key=key)
        if isinstance(value, Mapping):
            value = _renamed(value, f"{key}.", file)
        found[name] = current_value(key, value, file)
    return found


def _warn(old: str, new: str, file: str | Path | None) -> None:
    place = "" if file is None else f"{file}: "
    warnings.warn(f"{place}{old} is called {new} now", RenamedWarning, stacklevel=4)
