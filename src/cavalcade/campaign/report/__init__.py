"""The report of a campaign: Markdown with figures, one self-contained page, and the table."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

if TYPE_CHECKING:
    from cavalcade.campaign.report.worst import Replay
    from cavalcade.campaign.suite import Suite

MARKDOWN, PAGE, FIGURES = "report.md", "report.html", "figures"

_SPANS = re.compile(r"(`[^`]*`|\*\*[^*]+\*\*)")
_SPECIAL = re.compile(r"([\\*_<>\[\]#~])")


def write_report(
    folder: str | Path,
    suite: Suite,
    lines: Sequence[Mapping[str, Any]],
    pictures: bool = True,
    *,
    command: str = "",
    replay: Replay | None = None,
) -> tuple[Path, ...]:
    """Write `trials.parquet`, `report.md`, `figures/*.png` and `report.html`.

    The content depends on the lines alone, not on their order; of several lines of one trial the
    last counts. Pictures that an earlier report left in `figures/` are removed.

    Args:
        folder: Of the campaign; it exists.
        suite: That was run; its `variants`, `disturbances` and `worlds` give the order of rows and
            say what is compared against what.
        lines: The trials that have finished, as in `trials.jsonl`; may be empty.
        pictures: Draw the charts and, with `replay`, the worst trials.
        command: That made the campaign, shown in the header; paths in it are shortened.
        replay: Repeats a trial in memory, so that its picture can be drawn. It is not called for
            trials without a summary (crashed, refused, overtime). Whatever it raises is noted
            beside the trial and does not end the report.

    Returns:
        The files, in a reader's order.

    Raises:
        OutputError: Something cannot be written. Each file is written whole or not at all.
    """
    from cavalcade.campaign.report.canvas import Artist
    from cavalcade.campaign.report.document import document, trial_list
    from cavalcade.campaign.report.trials import TrialTable
    from cavalcade.campaign.table import scrubbed, write_table
    from cavalcade.drawing.style import make_directory
    from cavalcade.files import write_file

    place = Path(folder)
    file = write_table(place, lines)
    latest = {scrubbed(str(line.get("trial"))): line for line in lines}
    with TrialTable(file, suite) as table:
        artist = Artist(make_directory(place / FIGURES) if pictures else None, table.order)
        content = document(suite, table, latest, command, artist, replay)
        trials = trial_list(table.trials())
    markdown = _template("report.md.j2", markdown_text, autoescape=False).render(content)
    write_file(place / MARKDOWN, re.sub(r"\n{3,}", "\n\n", markdown).strip() + "\n")
    page = _template("report.html.j2", html_text, autoescape=True)
    text = page.render(content, trial_list=trials, sections=[]).strip() + "\n"
    write_file(place / PAGE, text)
    artist.tidy()
    figures = (place / FIGURES / name for name in artist.names)
    return (place / MARKDOWN, place / PAGE, file, *figures)


def _template(name: str, inline: Callable[[str], str], autoescape: bool) -> Any:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    from cavalcade.campaign.report.wording import code, count

    environment = Environment(
        loader=PackageLoader("cavalcade.campaign.report"),
        autoescape=autoescape,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.policies["json.dumps_kwargs"] = {
        "ensure_ascii": False,
        "allow_nan": False,
        "separators": (",", ":"),
    }
    environment.filters |= {
        "inline": inline,
        "code": code,
        "count": count,
        "bare": lambda text: re.sub(r"[`*\[\]]", "", text),
        "anchor": _anchor,
        "zip": zip,
    }
    return environment.get_template(name)


def markdown_text(text: str) -> str:
    """Markup of `code` and **strong** as it is; everything else so that it stays what it says."""
    parts = _SPANS.split(" ".join(text.split()))
    return "".join(
        part if k % 2 else _SPECIAL.sub(r"\\\1", part).replace("&", "&amp;")
        for k, part in enumerate(parts)
    )


def html_text(text: str) -> Markup:
    """Markup of `code` and **strong** as elements, everything else as text."""
    return Markup(_SPANS.sub(_element, html.escape(text)))


def _element(span: re.Match[str]) -> str:
    if span[0].startswith("`"):
        return f"<code>{span[0][1:-1]}</code>"
    return f"<strong>{span[0][2:-2]}</strong>"


def _anchor(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", re.sub(r"[`*]", "", text).lower()).strip("-") or "section"
