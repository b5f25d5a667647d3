"""A document as plain values, which Markdown and the page render each in its own way.

Texts may hold `code` between backticks and **strong** words; anything that comes from trials
goes through `code` or `plain` first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Heading:
    """A heading; level 1 is the document's own."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    text: str
    small: bool = False


@dataclass(frozen=True)
class Bullets:
    """A list."""

    items: tuple[str, ...]


@dataclass(frozen=True)
class Command:
    """A line for a shell."""

    text: str


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        head: Column names.
        rows: Cells as texts.
        left: So many columns from the left are words; the others are figures.
        words: Columns after these that are words as well, by index.
    """

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    left: int = 1
    words: tuple[int, ...] = ()

    def is_word(self, column: int) -> bool:
        """Whether the column holds words rather than figures."""
        return column < self.left or column in self.words


@dataclass(frozen=True)
class Folded:
    """A table that is shown on demand."""

    title: str
    table: Table


@dataclass(frozen=True)
class Drawn:
    """A picture that has been written.

    Attributes:
        name: File name under `figures/`.
        png: Its content.
        svg: The same as vectors; empty where there is only the raster.
    """

    name: str
    png: bytes
    svg: bytes = b""


@dataclass(frozen=True)
class Figure:
    """A picture with its caption."""

    drawn: Drawn
    caption: str


Block = Heading | Text | Bullets | Command | Table | Folded | Figure


def plain(text: str) -> str:
    """The text with nothing in it that a document would take for markup."""
    return text.replace("`", "'").replace("**", "* *")


def code(text: str) -> str:
    """The text as code."""
    return f"`{plain(text) or ' '}`"


def without_empty_columns(table: Table, keep: Sequence[int] = ()) -> Table:
    """The table without the columns that hold nothing but dashes."""
    shown = [
        k
        for k in range(len(table.head))
        if k in keep or not table.rows or any(row[k] not in ("", "–") for row in table.rows)
    ]
    left = sum(k < table.left for k in shown)
    words = tuple(new for new, old in enumerate(shown) if old in table.words)
    return Table(
        tuple(table.head[k] for k in shown),
        tuple(tuple(row[k] for k in shown) for row in table.rows),
        left,
        words,
    )
