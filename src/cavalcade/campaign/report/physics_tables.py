"""Tables of campaigns whose robots walk: how they follow commands, and what their bodies did."""

from __future__ import annotations

from collections.abc import Sequence

from cavalcade.campaign.report.blocks import Table, without_empty_columns
from cavalcade.campaign.report.tables import cell_names, head_of
from cavalcade.campaign.report.trials import Order
from cavalcade.campaign.report.verdict import Cell
from cavalcade.campaign.report.wording import NONE, bound, count, number, share
from cavalcade.campaign.statistics import upper_bound

_CROSSINGS = ("crossings", "strict_crossings")


def commanded_table(cells: Sequence[Cell], order: Order) -> Table:
    """What came of commanded velocities; the largest over the trials of a cell."""
    head = head_of(order)
    rows = []
    for cell in cells:
        speed, turn = cell.spread("commanded.speed_error"), cell.spread("commanded.yaw_rate_error")
        spread, drift = cell.spread("commanded.rms_m_s"), cell.spread("commanded.drift_m_s")
        rows.append(
            (
                *cell_names(cell, order),
                number(cell.spread("sim_time_s").median, 1),
                number(cell.length.median, 1),
                number(speed.most, 2, 100.0),
                number(turn.most, 2, 100.0),
                number(drift.most, 3),
                number(spread.most, 3),
            )
        )
    columns = (
        *head,
        "time p50 (s)",
        "summed ways p50 (m)",
        "error of mean speed (%)",
        "of mean yaw rate (%)",
        "mean drift aside (m/s)",
        "spread of speed (m/s)",
    )
    table = Table(columns, tuple(rows), len(head))
    return without_empty_columns(table, range(len(head)))


def physics_table(cells: Sequence[Cell], order: Order) -> Table:
    """Falls, and what bodies and joints went through."""
    head = head_of(order)
    rows = []
    for cell in cells:
        fell = sum((trial.number("falls") or 0.0) > 0.0 for trial in cell.run)
        robots = sum(int(trial.number("robots") or 0) for trial in cell.run)
        seconds = sum(trial.number("sim_time_s") or 0.0 for trial in cell.run)
        across = [sum(trial.measured(key) or 0 for trial in cell.run) for key in _CROSSINGS]
        tilt, torque = cell.spread("physics.max_tilt_rad"), cell.spread("physics.max_torque_share")
        rows.append(
            (
                *cell_names(cell, order),
                count(len(cell.run)),
                count(robots),
                count(round(seconds)),
                count(fell),
                bound(upper_bound(fell, len(cell.run)), len(cell.run)),
                count(round(across[0])) if across[0] else NONE,
                share(round(across[1]), round(across[0])) if across[0] else NONE,
                number(tilt.median),
                number(tilt.most),
                number(torque.median),
                number(torque.most),
                number(cell.spread("real_time_factor").median, 1),
            )
        )
    columns = (
        *head,
        "trials",
        "robots",
        "simulated (s)",
        "with a fall",
        "95 % bound",
        "crossed gap or step",
        "strictly",
        "tilt p50 (rad)",
        "most",
        "torque p50",
        "most",
        "simulated over wall time",
    )
    table = Table(columns, tuple(rows), len(head))
    return without_empty_columns(table, range(len(head)))
