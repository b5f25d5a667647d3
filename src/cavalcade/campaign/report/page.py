"""Blocks as one self-contained page: no other file and no network is needed to read it."""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from typing import Any

from cavalcade.campaign.report.blocks import (
    Block,
    Bullets,
    Command,
    Drawn,
    Figure,
    Folded,
    Heading,
    Table,
    Text,
)

_LONG = 40
"""A column with words longer than this many characters has its lines broken."""

_SPANS = re.compile(r"(`[^`]*`|\*\*[^*]+\*\*)")


def render(title: str, blocks: Sequence[Block], trials: Mapping[str, Any]) -> str:
    """The page.

    Args:
        title: Of the window.
        blocks: The report; its first block is its heading.
        trials: `columns`, a list of `[name, decimals or null for words]`, and `rows`: all
            trials, for the table that can be sorted and searched.
    """
    sections = [block for block in blocks if isinstance(block, Heading) and block.level == 2]
    links = "".join(
        f'<a href="#{_anchor(block.text)}">{_inline(block.text)}</a>' for block in sections
    )
    body = "\n".join(_block(block) for block in blocks)
    parts = {
        "TITLE": html.escape(title),
        "STYLE": _resource("page.css"),
        "LINKS": links + '<a href="#trials">All trials</a>',
        "BODY": body,
        "TRIALS": _data(trials),
        "SCRIPT": _resource("page.js"),
    }
    page = _resource("page.html")
    # In one pass, so that what is put in is never searched.
    return re.sub(r"\{\{([A-Z]+)\}\}", lambda match: parts[match[1]], page)


def _resource(name: str) -> str:
    return files("cavalcade.campaign.report").joinpath(name).read_text(encoding="utf-8")


def _data(value: Mapping[str, Any]) -> str:
    """JSON that may stand in a script element."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def _block(block: Block) -> str:
    match block:
        case Heading(text, level):
            return f'<h{level} id="{_anchor(text)}">{_inline(text)}</h{level}>'
        case Text(text, small):
            kind = ' class="small"' if small else ""
            return f"<p{kind}>{_inline(text)}</p>"
        case Bullets(items):
            return "<ul>" + "".join(f"<li>{_inline(item)}</li>" for item in items) + "</ul>"
        case Command(text):
            return f"<pre><code>{html.escape(text)}</code></pre>"
        case Table():
            return _table(block)
        case Folded(title, table):
            return f"<details><summary>{html.escape(title)}</summary>{_table(table)}</details>"
        case Figure(drawn, caption):
            kind = "chart" if drawn.svg else "raster"
            alt = html.escape(_bare(caption))
            return (
                f'<figure class="{kind}"><img alt="{alt}" src="{_source(drawn)}">'
                f"<figcaption>{_inline(caption)}</figcaption></figure>"
            )


def _table(table: Table) -> str:
    kinds = [_kind(table, k) for k in range(len(table.head))]
    head = "".join(
        f'<th scope="col"{kind}>{_inline(name)}</th>'
        for kind, name in zip(kinds, table.head, strict=True)
    )
    rows = "".join(
        "<tr>"
        + "".join(f"<td{kind}>{_inline(cell)}</td>" for kind, cell in zip(kinds, row, strict=True))
        + "</tr>"
        for row in table.rows
    )
    inside = f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody>"
    return f'<div class="wide"><table>{inside}</table></div>'


def _kind(table: Table, column: int) -> str:
    if not table.is_word(column):
        return ' class="n"'
    longest = max((len(row[column]) for row in table.rows), default=0)
    return ' class="long"' if longest > _LONG else ""


def _source(drawn: Drawn) -> str:
    """The picture itself, as vectors where it has them."""
    kind, content = ("svg+xml", drawn.svg) if drawn.svg else ("png", drawn.png)
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"


def _inline(text: str) -> str:
    parts = _SPANS.split(text)
    return "".join(_span(part) if k % 2 else html.escape(part) for k, part in enumerate(parts))


def _span(text: str) -> str:
    if text.startswith("`"):
        return f"<code>{html.escape(text[1:-1])}</code>"
    return f"<strong>{html.escape(text[2:-2])}</strong>"


def _bare(text: str) -> str:
    return re.sub(r"[`*]", "", text)


def _anchor(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", _bare(text).lower()).strip("-") or "section"


def trial_rows(
    columns: Iterable[tuple[str, int | None]], rows: Iterable[Sequence[Any]]
) -> dict[str, Any]:
    """What `render` takes as trials."""
    return {"columns": [list(column) for column in columns], "rows": [list(row) for row in rows]}
