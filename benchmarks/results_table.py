"""The table of docs/results.md from finished campaigns.

Run as `python benchmarks/results_table.py runs/evidence/*/`; `make evidence` ends with it.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import duckdb

from cavalcade.campaign.statistics import upper_bound, wilson

QUERY = """
    select suite, variant, disturbance, count(*),
           count(*) filter (feasible),
           count(*) filter (feasible and success),
           count(*) filter (contacts > 0),
           count(*) filter (avoidable > 0),
           count(*) filter (outcome in ('crashed', 'overtime', 'refused')),
           median("measured.time_ratio") filter (success),
           median("formation_error_m.mean") filter (success),
           min(min_footprint_gap_m),
           median("cycle_ms.p50"), median("cycle_ms.p99")
    from read_parquet(?, file_row_number = true)
    group by suite, variant, disturbance
    order by disturbance <> 'none', min(file_row_number)
"""
HEAD = (
    "suite", "variant", "disturbance", "worlds", "feasible", "success of feasible", "95 %",
    "collisions (avoidable)", "bound on avoidable", "no verdict", "time / bound",
    "formation error, m", "least gap, m", "cycle p50 / p99, ms",
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("campaign", type=Path, nargs="+", help="folder of a finished campaign")
    print("| " + " | ".join(HEAD) + " |")
    print("|" + "---|" * 3 + "--:|" * (len(HEAD) - 3))
    for folder in parser.parse_args().campaign:
        for row in duckdb.execute(QUERY, [str(folder / "trials.parquet")]).fetchall():
            print("| " + " | ".join(cells(*row)) + " |")


def cells(*row: Any) -> list[str]:
    (suite, variant, level, trials, feasible, good, hit, avoidable, lost) = row[:9]
    ratio, error, gap, p50, p99 = row[9:]
    low, high = wilson(good, feasible) if feasible else (0.0, 1.0)
    ran = trials - lost
    return [
        f"`{suite}`", f"`{variant}`", level, str(trials), str(feasible),
        f"{100.0 * good / feasible:.1f} %" if feasible else "–",
        f"{100.0 * low:.1f}–{100.0 * high:.1f}",
        f"{hit} ({avoidable})",
        f"{100.0 * upper_bound(avoidable, ran):.2f} %" if ran else "–",
        str(lost), text(ratio, 2), text(error, 3), text(gap, 3),
        f"{text(p50, 2)} / {text(p99, 2)}",
    ]  # fmt: skip


def text(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


if __name__ == "__main__":
    main()
