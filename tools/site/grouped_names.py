"""Docstrings describe arguments of one kind together (`x, y: Metres.`); the site lists each."""

from __future__ import annotations

import re
from typing import Any

import griffe

_SECTIONS = re.compile(r"^(?:Args|Attributes):\n(?:(?: .*)?\n)*", re.MULTILINE)
_TOGETHER = re.compile(r"^    (\w+(?:, \w+)+): (.*(?:\n {5,}.*)*)", re.MULTILINE)


class GroupedNames(griffe.Extension):
    """Says of each name what is said of all of them."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Called by griffe for each module, class, function and attribute."""
        if obj.docstring is not None:
            obj.docstring.value = apart(obj.docstring.value)


def apart(text: str) -> str:
    """The docstring with an entry for each name."""
    return _SECTIONS.sub(lambda section: _TOGETHER.sub(_each, section[0]), text + "\n")


def _each(entry: re.Match[str]) -> str:
    return "\n".join(f"    {name}: {entry[2]}" for name in entry[1].split(", "))
