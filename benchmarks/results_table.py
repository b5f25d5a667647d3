"""The tables of the results from finished campaigns: of formations, of plans, of physics.

Run as `python benchmarks/results_table.py runs/evidence/*/`; `make evidence` ends with it.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import duckdb

from cavalcade.campaign.methods import METHOD_VARIANTS
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
    where not list_contains(?, variant) and coalesce(method, '') <> 'commands'
    group by suite, variant, disturbance
    order by disturbance <> 'none', min(file_row_number)
"""
HEAD = (
    "suite", "variant", "disturbance", "worlds", "feasible", "success of feasible", "95 %",
    "collisions (avoidable)", "bound on avoidable", "no verdict", "time / bound",
    "formation error, m", "least gap, m", "cycle p50 / p99, ms",
)  # fmt: skip

PLAN_QUERY = """
    select suite, scenario, variant, count(*),
           count(*) filter (feasible or expected <> 'solved'),
           count(*) filter (success and (feasible or expected <> 'solved')),
           count(*) filter (outcome in ('collision', 'invalid')),
           count(*) filter (outcome in ('crashed', 'overtime')),
           avg(list_sum(path_length_m)) filter (success),
           median("measured.length_ratio") filter (success),
           median("measured.makespan_ratio") filter (success),
           avg(planning_time_s), median(planning_time_s),
           quantile_cont(planning_time_s, 0.99), max(planning_time_s),
           median("measured.single_time_ratio") filter (success)
    from read_parquet(?, file_row_number = true)
    where list_contains(?, variant)
    group by suite, scenario, variant
    order by min(file_row_number)
"""
PLAN_HEAD = (
    "suite", "scenario", "variant", "worlds", "counted", "success", "95 %",
    "judged faulty", "no verdict", "mean length, m", "length / bound", "makespan / alone",
    "planning mean, s", "p50", "p99", "max", "planning / single plans",
)  # fmt: skip


PHYSICS_QUERY = """
    select suite, scenario, variant, disturbance, count(*),
           count(*) filter (feasible), count(*) filter (feasible and success),
           count(*) filter (falls > 0), count(*) filter (contacts > 0),
           sum("measured.strict_crossings"), sum("measured.crossings"),
           max("commanded.speed_error"), max("commanded.yaw_rate_error"),
           max("commanded.rms_m_s"),
           min(min_obstacle_distance_m), min(min_robot_distance_m), min(min_footprint_gap_m),
           max("physics.max_tilt_rad"), max("physics.max_torque_share"), median(real_time_factor)
    from read_parquet(?, file_row_number = true)
    where backend = 'mujoco' and ? is not null
    group by suite, scenario, variant, disturbance
    having max("physics.max_tilt_rad") is not null
    order by min(file_row_number)
"""
PHYSICS_HEAD = (
    "suite", "scenario", "variant", "disturbance", "trials", "success", "95 %", "with a fall",
    "with contact", "leapt strictly", "speed error", "yaw rate error", "spread, m/s",
    "least to obstacles, m",
    "between centres, m", "gap of footprints, m", "largest tilt, rad", "torque", "real-time factor",
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("campaign", type=Path, nargs="+", help="folder of a finished campaign")
    folders = parser.parse_args().campaign
    print_table(HEAD, [cells(*row) for row in rows(QUERY, folders)])
    print_table(PLAN_HEAD, [plan_cells(*row) for row in rows(PLAN_QUERY, folders)])
    walked = [folder for folder in folders if has_column(folder, "measured.crossings")]
    print_table(PHYSICS_HEAD, [physics_cells(*row) for row in rows(PHYSICS_QUERY, walked)])


def rows(query: str, folders: list[Path]) -> list[Any]:
    """Of all folders, from a query that takes the file and the variants that make plans."""
    plans = list(METHOD_VARIANTS)
    files = [str(folder / "trials.parquet") for folder in folders]
    return [row for file in files for row in duckdb.execute(query, [file, plans]).fetchall()]


def has_column(folder: Path, name: str) -> bool:
    """Whether a campaign's table has it; those of older versions may not."""
    file = str(folder / "trials.parquet")
    columns = duckdb.execute("describe select * from read_parquet(?)", [file]).fetchall()
    return any(column[0] == name for column in columns)


def print_table(head: tuple[str, ...], lines: list[list[str]]) -> None:
    if lines:
        print("| " + " | ".join(head) + " |")
        print("|" + "---|" * 3 + "--:|" * (len(head) - 3))
        for line in lines:
            print("| " + " | ".join(line) + " |")
        print()


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


def plan_cells(*row: Any) -> list[str]:
    (suite, scenario, variant, trials, counted, good, faulty, lost) = row[:8]
    (length, ratio, makespan, mean, p50, p99, most, single) = row[8:]
    low, high = wilson(good, counted) if counted else (0.0, 1.0)
    return [
        f"`{suite}`", f"`{scenario}`", f"`{variant}`", str(trials), str(counted),
        f"{100.0 * good / counted:.1f} %" if counted else "–",
        f"{100.0 * low:.1f}–{100.0 * high:.1f}", str(faulty), str(lost),
        text(length, 2), text(ratio, 3), text(makespan, 2),
        text(mean, 4), text(p50, 4), text(p99, 4), text(most, 4), text(single, 2),
    ]  # fmt: skip


def physics_cells(*row: Any) -> list[str]:
    (suite, scenario, variant, level, trials, feasible, good, fell, hit) = row[:9]
    (strict, crossed, speed, turn, spread, obstacle, between, gap, tilt, torque, factor) = row[9:]
    low, high = wilson(good, feasible) if feasible else (0.0, 1.0)
    return [
        f"`{suite}`", f"`{scenario}`", f"`{variant}`", level, str(trials),
        f"{100.0 * good / feasible:.1f} %" if feasible else "–",
        f"{100.0 * low:.1f}–{100.0 * high:.1f}", str(fell), str(hit),
        f"{strict}/{crossed}" if crossed else "–", percent(speed), percent(turn),
        text(spread, 3), text(obstacle, 3), text(between, 3), text(gap, 3), text(tilt, 2),
        text(torque, 2), text(factor, 1),
    ]  # fmt: skip


def percent(value: float | None) -> str:
    return "–" if value is None else f"{100.0 * value:.1f} %"


def text(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


if __name__ == "__main__":
    main()
