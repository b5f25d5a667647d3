"""The trials of `trials.parquet`, as the report counts, compares and lists them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Self

from cavalcade.campaign.methods import METHOD_VARIANTS
from cavalcade.campaign.samplers import EXPECTED, SOLVED
from cavalcade.campaign.suite import UNDISTURBED


@dataclass(frozen=True)
class Trial:
    """One row of the table; what it lacks is None.

    Attributes:
        name: Unique ID.
        outcome: How it ended.
        reason: One line about it: the detail, else the checker's first violation.
        success: Arrived, and the checker found nothing that could have been avoided.
        feasible: The world can be crossed, by a test that does not use the planner.
        unsolvable: Infeasible by construction, so that refusing is the success.
        planned: Whether the robots have individual goals.
        ran: Whether there is a summary; without one the checker had nothing to judge.
        level: Where the world lies on the suite's curve; `level_name` says what it measures.
        contacts: Collisions that the checker found, of which `avoidable` could have been avoided.
        gap: Smallest gap between footprints, or to an obstacle, m.
        duration: Simulated time, s.
        makespan: When the last robot was at its goal for good, s.
        time_ratio: Makespan over the longest lower bound at top speed; with individual goals over
            the makespan of the slowest robot alone.
        length_ratio: With individual goals: summed lengths over summed lower bounds.
        planning_time: s.
        formation_error: Mean, m.
    """

    name: str
    outcome: str
    reason: str
    success: bool
    feasible: bool
    unsolvable: bool
    planned: bool
    ran: bool
    level: float | None
    level_name: str | None
    contacts: int
    avoidable: int
    gap: float | None
    duration: float | None
    makespan: float | None
    time_ratio: float | None
    length_ratio: float | None
    planning_time: float | None
    formation_error: float | None


@dataclass(frozen=True)
class Order:
    """The order in which the suite names its scenarios, variants and disturbances.

    Attributes:
        scenarios, variants, disturbances: Those that there are.
        references: What a variant is compared with, where that is not the first one.
    """

    scenarios: tuple[str, ...]
    variants: tuple[str, ...]
    disturbances: tuple[str, ...]
    references: Mapping[str, str]

    @property
    def parts(self) -> tuple[str, ...]:
        """What tells cells apart: their scenario, and what else there are several of."""
        several = (("disturbance", self.disturbances), ("variant", self.variants))
        return ("scenario", *(name for name, values in several if len(values) > 1))


class TrialTable:
    """A campaign's table, open for queries. Use it as a context.

    The queries read DuckDB's table `trials`: a row per trial with the attributes of `Trial`, the
    further quantities that `_DERIVED` names, and `place`, its rank in the suite's order.

    Attributes:
        order: Of scenarios, variants and disturbances.

    Args:
        file: `trials.parquet`.
        suite: That was run; its order of `worlds` (each with a `name`), `variants` and
            `disturbances`, and its `references`, are used where it has them; names that it does
            not know follow by the alphabet. Without its order `cavalcade` and `none` come first.
    """

    def __init__(self, file: Path, suite: object) -> None:
        import duckdb

        # One thread, so that what has no order of its own comes out the same every time.
        self._connection = duckdb.connect(config={"threads": 1})
        quoted = str(file).replace("'", "''")
        # A folder named like `seed=3` is no column.
        self._source = f"read_parquet('{quoted}', hive_partitioning = false)"
        self._connection.execute(
            f"CREATE TEMP TABLE unordered AS SELECT {_DERIVED} FROM {self._source}",
            {"methods": list(METHOD_VARIANTS), "unsolvable": list(EXPECTED), "solved": SOLVED},
        )
        named = {
            "scenario": [getattr(group, "name", "") for group in getattr(suite, "worlds", ())],
            "variant": getattr(suite, "variants", None) or ("cavalcade",),
            "disturbance": getattr(suite, "disturbances", None) or (UNDISTURBED,),
        }
        order = {}
        for name, values in named.items():
            present = {one for (one,) in self.rows(f"SELECT DISTINCT {name} FROM unordered")}
            first = [one for one in dict.fromkeys(values) if one in present]
            order[name] = (*first, *sorted(present - set(first)))
        references = getattr(suite, "references", {})
        self.order = Order(order["scenario"], order["variant"], order["disturbance"], references)
        self._connection.execute(
            """
            CREATE TEMP TABLE trials AS
            SELECT *, row_number() OVER (
                ORDER BY scenario_at, seed, disturbance_at, variant_at, name
            ) AS place
            FROM (
                SELECT *,
                    list_position($scenario, scenario) AS scenario_at,
                    list_position($disturbance, disturbance) AS disturbance_at,
                    list_position($variant, variant) AS variant_at
                FROM unordered
            )
            ORDER BY place
            """,
            {name: list(values) for name, values in order.items()},
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        """Close the table."""
        self._connection.close()

    def rows(self, query: str, parameters: Sequence[Any] = ()) -> list[tuple[Any, ...]]:
        """What an SQL query gives; `?` in it stands for the parameters in turn."""
        return self._connection.execute(query, list(parameters)).fetchall()

    def trials(
        self, where: str = "true", order_by: str = "place", limit: int | None = None
    ) -> list[Trial]:
        """Single trials, chosen and ordered by SQL expressions."""
        columns = ", ".join(one.name for one in fields(Trial))
        most = "" if limit is None else f"LIMIT {limit}"
        query = f"SELECT {columns} FROM trials WHERE {where} ORDER BY {order_by} {most}"
        return [Trial(*row) for row in self.rows(query)]

    def failures(self, order_by: str = "place") -> list[Trial]:
        """Those that failed where they need not have, or touched what they need not have."""
        return self.trials("NOT success AND (feasible OR unsolvable OR avoidable > 0)", order_by)

    def versions(self) -> list[tuple[str, list[str]]]:
        """By package, every version that a trial ran with; this package and Python first."""
        query = f"""
            SELECT package[10:], list(DISTINCT version ORDER BY version)
            FROM (
                UNPIVOT (SELECT COLUMNS('^versions\\.')::VARCHAR FROM {self._source})
                ON COLUMNS(*) INTO NAME package VALUE version
            )
            WHERE version != '' GROUP BY package
            ORDER BY package != 'versions.cavalcade', package != 'versions.python', package
        """
        return self.rows(query)


_DERIVED = """
    coalesce(trial, '?') AS name,
    coalesce(scenario, '?') AS scenario,
    coalesce(variant, '?') AS variant,
    coalesce(disturbance, 'none') AS disturbance,
    coalesce(seed, 0) AS seed,
    coalesce(outcome, 'unknown') AS outcome,
    coalesce(nullif(detail, ''), violations[1], '') AS reason,
    coalesce(success, false) AS success,
    coalesce(feasible, true) AS feasible,
    coalesce(expected, $solved) AS expected,
    expected IS NOT NULL AND list_contains($unsolvable, expected) AS unsolvable,
    variant IS NOT NULL AND list_contains($methods, variant) AS planned,
    coalesce(method = 'commands', false) AS commanded,
    "physics.max_tilt_rad" IS NOT NULL AS in_physics,
    reason IS NOT NULL AS ran,
    level,
    nullif(level_name, '') AS level_name,
    coalesce(contacts, 0) AS contacts,
    coalesce(avoidable, 0) AS avoidable,
    min_footprint_gap_m AS gap,
    min_obstacle_distance_m AS obstacle_distance,
    min_robot_distance_m AS robot_distance,
    sim_time_s AS duration,
    makespan_s AS makespan,
    CASE WHEN success THEN coalesce(makespan_s, sim_time_s) END AS time,
    CASE WHEN planned THEN "measured.makespan_ratio" ELSE "measured.time_ratio" END AS time_ratio,
    -- The summed length is known only where that of every robot is.
    CASE WHEN success AND len(list_filter(path_length_m, lambda x: x IS NULL)) = 0
        THEN list_sum(path_length_m) END AS length,
    "measured.length_ratio" AS length_ratio,
    "measured.single_time_ratio" AS single_time_ratio,
    planning_time_s AS planning_time,
    CASE WHEN success THEN planning_time_s END AS solving_time,
    "formation_error_m.mean" AS formation_error,
    "cycle_ms.p50" AS cycle_p50,
    "cycle_ms.p99" AS cycle_p99,
    "cycle_ms.max" AS cycle_max,
    "commanded.speed_error" AS speed_error,
    "commanded.yaw_rate_error" AS yaw_rate_error,
    "commanded.rms_m_s" AS speed_rms,
    "commanded.drift_m_s" AS drift,
    falls,
    robots,
    "measured.crossings" AS crossings,
    "measured.strict_crossings" AS strict_crossings,
    "physics.max_tilt_rad" AS tilt,
    "physics.max_torque_share" AS torque,
    real_time_factor
"""
"""Columns of the table `trials`, from those of `trials.parquet`."""
