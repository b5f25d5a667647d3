"""One HTML file out of a page's parts."""

from __future__ import annotations

import html
import json
from collections.abc import Iterable, Mapping
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from cavalcade.files import write_file

_BEFORE = ("unpack.js", "matrix.js", "shaders.js", "shapes.js", "ground.js", "strokes.js")
_AFTER = ("camera.js", "clock.js")


def join_page(
    folder: Traversable,
    scripts: Iterable[str],
    last: Iterable[str],
    title: str,
    data: Mapping[str, Any],
) -> str:
    """The whole HTML text.

    Args:
        folder: Has the page's `page.html` and `style.css` (which adds to the common one).
        scripts: Its own, between the common ones that unpack and draw and those of camera and
            clock.
        last: Its own after these.
        title: Of the window.
        data: What the scripts find as `scene`.
    """
    common = files("cavalcade.drawing.replay.page3d") / "assets"
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    sources = [
        *(common / name for name in _BEFORE),
        *(folder / name for name in scripts),
        *(common / name for name in _AFTER),
        *(folder / name for name in last),
    ]
    parts = {
        "TITLE": html.escape(title),
        "STYLE": "\n".join((place / "style.css").read_text("utf-8") for place in (common, folder)),
        "SCRIPT": "\n".join(source.read_text(encoding="utf-8") for source in sources),
        # Inside a script element only "<" can end or change the element.
        "DATA": text.replace("<", "\\u003c"),
    }
    pieces = (folder / "page.html").read_text(encoding="utf-8").split("%")
    # The page has its places as %NAME%, and no other percent signs.
    return "".join(parts[piece] if index % 2 else piece for index, piece in enumerate(pieces))


def write_page(page: str, path: str | Path) -> Path:
    """Write the page, whole or not at all.

    Raises:
        OutputError: It cannot be written.
    """
    target = Path(path)
    write_file(target, page)
    return target
