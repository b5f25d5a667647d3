"""Puts the report together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from cavalcade.campaign.report import charts, sections, tables
from cavalcade.campaign.report.artist import MOST_ROWS, Artist
from cavalcade.campaign.report.blocks import Block, Bullets, Folded, Heading, Text, code
from cavalcade.campaign.report.comparison_chart import draw_comparisons
from cavalcade.campaign.report.comparison_tables import comparison_tables, references
from cavalcade.campaign.report.comparisons import (
    Comparison,
    compare_disturbances,
    compare_variants,
)
from cavalcade.campaign.report.curve_chart import FEW_CURVES, draw_curves
from cavalcade.campaign.report.curves import curves_of
from cavalcade.campaign.report.methods import PAPER_NOTE, notes_of
from cavalcade.campaign.report.physics_tables import commanded_table, physics_table
from cavalcade.campaign.report.plan_tables import paper_table, plan_measure_table
from cavalcade.campaign.report.repeating import Replay, pictures_of
from cavalcade.campaign.report.trials import Order, Trial
from cavalcade.campaign.report.verdict import Cell, cells_of
from cavalcade.campaign.report.worst import worst_trials


class Named(Protocol):
    """What the report needs of a suite; its `variants`, `disturbances` and `worlds` (each with a
    `name`), where it has them, give the order of rows and say what is compared against what.
    """

    @property
    def suite(self) -> str:
        """Its name."""

    @property
    def about(self) -> str:
        """One line."""


def compose(
    suite: Named,
    trials: Sequence[Trial],
    order: Order,
    command: str,
    artist: Artist,
    replay: Replay | None,
) -> list[Block]:
    """The whole report as blocks; pictures are drawn on the way.

    Args:
        suite: That was run.
        trials: All of them.
        order: Of rows.
        command: That made the campaign; empty where it is not known.
        artist: Draws.
        replay: Repeats a trial in memory, or None.

    Raises:
        OutputError: A picture cannot be written.
    """
    cells = cells_of([trial for trial in trials if not trial.hopeless], order)
    hopeless = cells_of([trial for trial in trials if trial.hopeless], order)
    blocks = sections.header(suite.suite, suite.about, trials, order, command)
    blocks.append(Heading("Verdict"))
    blocks += sections.sentences(cells, order) if cells or not hopeless else []
    if cells:
        outcomes = tables.outcome_table(cells, order)
        remark = "In brackets: failures in worlds that are not feasible."
        caption = "Success in feasible worlds with 95 % interval, and how the failures ended."
        blocks += [
            tables.success_table(cells, order),
            *artist.charts(caption, charts.draw_success, cells, "success"),
            Heading("How the trials ended", 3),
            outcomes,
            *(
                [Text(remark, small=True)]
                if any("(" in c for r in outcomes.rows for c in r)
                else []
            ),
            *_measures(cells, order),
        ]
    if hopeless:
        blocks += [
            Heading("Problems without a plan", 3),
            tables.refusal_table(hopeless, order),
        ]
    if any(cell.run for cell in cells):
        caption = "Median (mark), quartiles (bar) and 5 % to 95 % (line) over single trials."
        for planned in (False, True):
            alike = [c for c in cells if c.planned == planned and not c.commanded]
            name = "spread-plans" if planned and len(alike) < len(cells) else "spread"
            blocks += artist.charts(caption, charts.draw_spreads, alike, name)
        blocks += [
            Heading("Closest approaches of all trials that ran", 3),
            tables.clearance_table(cells, order),
        ]
    solvable = [trial for trial in trials if not trial.hopeless]
    blocks += _comparisons(
        compare_variants(solvable, order), "variant", order.disturbances, "disturbance", artist
    )
    blocks += _comparisons(
        compare_disturbances(solvable, order), "disturbance", order.variants, "variant", artist
    )
    blocks += _curves(cells, order, artist)
    blocks += sections.failures(trials, order)
    blocks += sections.unavoidable(trials, order)
    chosen = worst_trials(trials, order)
    drawn, remarks = pictures_of(chosen, artist, replay)
    blocks += sections.worst(chosen, drawn, remarks)
    return [*blocks, Heading("How to read this"), Bullets(notes_of(trials, order))]


def _measures(cells: Sequence[Cell], order: Order) -> list[Block]:
    """What was measured, of each kind of task that there is."""
    planned = [cell for cell in cells if cell.planned]
    driven = [cell for cell in cells if not cell.planned and not cell.commanded]
    commanded = [cell for cell in cells if cell.commanded]
    walked = [cell for cell in cells if cell.in_physics]
    blocks: list[Block] = []
    paper = paper_table(planned)
    if paper is not None:
        blocks += [Heading("Beside the paper's Table I"), paper, Text(PAPER_NOTE, small=True)]
    if driven:
        heading = Heading("Time, formation, clearance")
        blocks += [heading, tables.measure_table(driven, order)]
    if planned:
        blocks += [Heading("Length, time, planning"), plan_measure_table(planned, order)]
    if commanded:
        blocks += [Heading("As they were told"), commanded_table(commanded, order)]
    if walked:
        blocks += [Heading("Legs and bodies"), physics_table(walked, order)]
    return blocks


def _comparisons(
    found: Sequence[Comparison],
    kind: str,
    settings: Sequence[str],
    setting: str,
    artist: Artist,
) -> list[Block]:

    if not found:
        return []
    firsts = references(found)
    first = code(firsts[0]) if len(firsts) == 1 else "its reference"
    blocks: list[Block] = [
        Heading(f"{kind.capitalize()}s compared on the same worlds"),
        Text(
            f"Each {kind} against {first}: a positive difference is more of it than with {first}. "
            f"“One only” counts the pairs in which it happened only with {first} / only with this "
            f"{kind}."
        ),
    ]
    several = len(settings) > 1
    against = first if len(firsts) == 1 else "the reference"
    other = f" The reference is {code(firsts[0])} unless a row names another." * (len(firsts) > 1)
    for part in settings if len(found) > MOST_ROWS else ("",):
        rows = [comparison for comparison in found if part in ("", comparison.setting)]
        if rows:
            where = f" {setting.capitalize()} {code(part)}." if part else ""
            caption = (
                f"Mean paired differences to {against} with 95 % intervals; hollow where the "
                f"interval includes zero.{other}{where}"
            )
            name = f"{kind}s-{part}" if part else f"{kind}s"
            blocks += artist.figure(
                caption, draw_comparisons, rows, several and not part, name=name
            )
    return blocks + comparison_tables(found, kind, setting if several else "")


def _curves(cells: Sequence[Cell], order: Order, artist: Artist) -> list[Block]:

    blocks: list[Block] = []
    for scenario, curves in curves_of(cells).items():
        axis = curves[0].axis
        blocks.append(Heading(f"{code(scenario)} over {axis}", 3))
        # Lines by variant; a chart per disturbance where both vary.
        crossed = len(order.variants) > 1 and len(order.disturbances) > 1
        for part in order.disturbances if crossed else ("",):
            shown = [curve for curve in curves if part in ("", curve.cell.disturbance)]
            by_variant = len(order.variants) > 1
            labels = [c.cell.variant if by_variant else c.cell.disturbance for c in shown]
            where = f" Disturbance {code(part)}." if part else ""
            third = "planning time" if shown[0].cell.planned else "formation error"
            if len(shown) <= FEW_CURVES:
                what = f"success with 95 % interval; median and quartiles of time and {third}"
            else:
                what = f"success; median time and {third}"
            caption = f"{code(scenario)}: {what} of the trials that succeeded.{where}"
            name = f"curves-{scenario}-{part}" if part else f"curves-{scenario}"
            blocks += artist.figure(caption, draw_curves, shown, labels, name=name)
        blocks.append(Folded("The numbers", tables.curve_table(curves, order)))
    return [Heading("Curves"), *blocks] if blocks else []
