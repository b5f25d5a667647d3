"""Writes the report of a campaign into its folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cavalcade.campaign.report.document import Named
    from cavalcade.campaign.report.repeating import Replay

MARKDOWN, PAGE, FIGURES = "report.md", "report.html", "figures"


def write_report(
    folder: str | Path,
    suite: Named,
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
        suite: That was run.
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
    from cavalcade.campaign.report import markdown, page
    from cavalcade.campaign.report.artist import Artist
    from cavalcade.campaign.report.document import compose
    from cavalcade.campaign.report.trial_list import all_trials
    from cavalcade.campaign.report.trials import Order, read_trials
    from cavalcade.campaign.table import write_table
    from cavalcade.drawing.style import make_directory
    from cavalcade.files import write_file

    place = Path(folder)
    table = write_table(place, lines)
    trials = read_trials(lines)
    order = Order.of(suite, trials)
    artist = Artist(make_directory(place / FIGURES) if pictures else None, order)
    blocks = compose(suite, trials, order, command, artist, replay)
    written = []
    texts = (
        (MARKDOWN, markdown.render(blocks)),
        (PAGE, page.render(f"Campaign {suite.suite}", blocks, all_trials(trials, order))),
    )
    for name, text in texts:
        write_file(place / name, text)
        written.append(place / name)
    artist.tidy()
    return (*written, table, *(place / FIGURES / name for name in artist.names))
