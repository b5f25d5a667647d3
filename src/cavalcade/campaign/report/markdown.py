"""Blocks as GitHub's Markdown."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable

from cavalcade.campaign.report.blocks import (
    Block,
    Bullets,
    Command,
    Figure,
    Folded,
    Heading,
    Table,
    Text,
)

_SPECIAL = re.compile(r"([\\*_<>\[\]#~])")
_SPANS = re.compile(r"(`[^`]*`|\*\*[^*]+\*\*)")


def render(blocks: Iterable[Block]) -> str:
    """The document; pictures are named as they lie beside it, under `figures/`."""
    return "\n\n".join(_block(block) for block in blocks) + "\n"


def _block(block: Block) -> str:
    match block:
        case Heading(text, level):
            return f"{'#' * level} {_inline(text)}"
        case Text(text, _):
            return _inline(text)
        case Bullets(items):
            return "\n".join(f"- {_inline(item)}" for item in items)
        case Command(text):
            return f"```sh\n{text}\n```"
        case Table():
            return _table(block)
        case Folded(title, table):
            head = f"<details><summary>{html.escape(title)}</summary>"
            return f"{head}\n\n{_table(table)}\n\n</details>"
        case Figure(drawn, caption):
            alt = re.sub(r"[`*\[\]]", "", caption)
            return f"![{alt}](figures/{drawn.name})\n\n*{_inline(caption)}*"


def _table(table: Table) -> str:
    lines = [
        _row(table.head),
        "|" + "|".join("---" if table.is_word(k) else "--:" for k in range(len(table.head))) + "|",
    ]
    return "\n".join(lines + [_row(row) for row in table.rows])


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(_inline(cell).replace("|", "\\|") for cell in cells) + " |"


def _inline(text: str) -> str:
    """Markup of `code` and **strong** as it is; everything else so that it stays what it says."""
    parts = _SPANS.split(" ".join(text.split()))
    return "".join(
        part if k % 2 else _SPECIAL.sub(r"\\\1", part).replace("&", "&amp;")
        for k, part in enumerate(parts)
    )
