"""A campaign's trials as one flat table: `trials.parquet`, a row per trial.

Columns keep their names, order and types whatever the trials hold, so that tables of several
campaigns can be read together. DuckDB writes the file; nothing else is needed to read it back:
`duckdb.sql("SELECT * FROM 'trials.parquet'")`.
"""

from __future__ import annotations

import json
import math
import os
import re
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from cavalcade.errors import OutputError, RecordingError
from cavalcade.metrics.summary import summary_columns

TABLE, LINES = "trials.parquet", "trials.jsonl"

_FRONT = {
    "trial": "VARCHAR",
    "suite": "VARCHAR",
    "scenario": "VARCHAR",
    "variant": "VARCHAR",
    "disturbance": "VARCHAR",
    "seed": "BIGINT",
    "outcome": "VARCHAR",
    "success": "BOOLEAN",
    "feasible": "BOOLEAN",
    "level": "DOUBLE",
    "contacts": "BIGINT",
    "avoidable": "BIGINT",
    "detail": "VARCHAR",
}
_BACK = {
    "measured.crossings": "BIGINT",
    "measured.strict_crossings": "BIGINT",
    "measured.time_ratio": "DOUBLE",
    "measured.length_ratio": "DOUBLE",
    "measured.makespan_ratio": "DOUBLE",
    "measured.single_time_ratio": "DOUBLE",
    "level_name": "VARCHAR",
    "expected": "VARCHAR",
    "violations": "VARCHAR[]",
}

COLUMNS: Mapping[str, str] = _FRONT | (summary_columns() | _FRONT) | _BACK
"""DuckDB's type of each column that every table has, in their order.

Where a key of the summary has the name of a column in front (`seed`, `variant`, `success`,
`detail`), the one in front stands: it says what the campaign and the checker say.
"""


def _columns(flats: Iterable[Mapping[str, Any]]) -> dict[str, str]:
    """`COLUMNS`, and after them, by name, whatever else the lines' summaries and measures hold."""
    found: dict[str, str] = {}
    for flat in flats:
        for name, value in flat.items():
            if name not in COLUMNS and value is not None:
                found[name] = _wider(found.get(name), _type_of(value))
    columns = dict(COLUMNS)
    taken = {name.lower() for name in columns}
    for name, kind in sorted(found.items()):
        # To a database, names that differ in case only are the same.
        if name.lower() not in taken:
            columns[name] = kind
            taken.add(name.lower())
    return columns


def columns_and_rows(
    lines: Sequence[Mapping[str, Any]],
) -> tuple[dict[str, str], list[dict[str, Any]]]:
    """Columns with their types; a flat row per trial, by scenario, seed, disturbance and variant.

    Of several lines of one trial the last counts. Numbers that are not finite become null. Paths
    in texts are cut to their last part; process ids, hosts and folders are left out.
    """
    latest = {str(line.get("trial")): line for line in lines}
    flats = [_flat(line) for line in latest.values()]
    columns = _columns(flats)
    rows = [{name: _cast(flat.get(name), kind) for name, kind in columns.items()} for flat in flats]
    return columns, sorted(rows, key=_rank)


def write_table(folder: str | Path, lines: Sequence[Mapping[str, Any]]) -> Path:
    """Write `trials.parquet` into the campaign's folder, whole or not at all.

    Lines with the same content give the same bytes, whatever their order.

    Raises:
        OutputError: It cannot be written.
    """
    import duckdb

    path = Path(folder) / TABLE
    columns, rows = columns_and_rows(lines)
    try:
        with tempfile.TemporaryDirectory(dir=folder, prefix=".table-") as place:
            source, target = Path(place) / "rows.json", Path(place) / TABLE
            with source.open("w", encoding="utf-8", errors="replace") as stream:
                for row in rows:
                    stream.write(json.dumps(row, ensure_ascii=False, allow_nan=False) + "\n")
            # One thread, so that rows and bytes keep their order.
            with duckdb.connect(config={"threads": 1}) as connection:
                connection.execute(_copy(source, target, columns, bool(rows)))
            os.replace(target, path)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    except duckdb.IOException as error:
        said = str(error).splitlines() or [type(error).__name__]
        raise OutputError(f"cannot write {path}: {said[0]}") from error
    return path


def read_table(folder: str | Path) -> tuple[dict[str, str], list[dict[str, Any]]]:
    """Columns with their types and rows of a campaign's folder, also of one that still goes on.

    They are those of `trials.jsonl`, as far as its lines are whole; without it, of
    `trials.parquet`.

    Raises:
        RecordingError: There is neither, or it cannot be read.
    """
    lines, table = Path(folder) / LINES, Path(folder) / TABLE
    try:
        if lines.is_file():
            with lines.open(encoding="utf-8", errors="replace") as stream:
                return columns_and_rows([line for text in stream if (line := _line(text))])
        if table.is_file():
            return _stored(table)
    except OSError as error:
        raise RecordingError(f"cannot be read: {error.strerror}", file=folder) from None
    raise RecordingError(f"has neither {LINES} nor {TABLE}", file=folder)


def _line(text: str) -> dict[str, Any] | None:
    """The line of a trial; None for one that is torn or something else."""
    try:
        line = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return line if isinstance(line, dict) and isinstance(line.get("trial"), str) else None


def _stored(table: Path) -> tuple[dict[str, str], list[dict[str, Any]]]:
    """`read_table` of `trials.parquet`."""
    import duckdb

    try:
        with duckdb.connect(config={"threads": 1}) as connection:
            connection.execute(
                f"SELECT * FROM read_parquet({_quoted(str(table))}, hive_partitioning=false)"
            )
            columns = {one[0]: str(one[1]) for one in connection.description or ()}
            rows = [dict(zip(columns, row, strict=True)) for row in connection.fetchall()]
    except duckdb.Error as error:
        said = str(error).splitlines() or [type(error).__name__]
        raise RecordingError(said[0], file=table) from None
    if "trial" not in columns:
        raise RecordingError("not a table of trials: it has no column `trial`", file=table)
    return columns, rows


def _copy(source: Path, target: Path, columns: Mapping[str, str], filled: bool) -> str:
    if filled:
        kinds = ", ".join(f"{_quoted(name)}: '{kind}'" for name, kind in columns.items())
        # A trial with many robots has long lists; no line comes near this limit. A folder named
        # like `seed=3` is no column.
        rows = (
            f"SELECT * FROM read_json({_quoted(str(source))}, format='newline_delimited', "
            f"columns={{{kinds}}}, maximum_object_size=67108864, hive_partitioning=false)"
        )
    else:
        empty = ", ".join(f'NULL::{kind} AS "{name}"' for name, kind in columns.items())
        rows = f"SELECT {empty} WHERE false"
    return f"COPY ({rows}) TO {_quoted(str(target))} (FORMAT parquet, COMPRESSION zstd)"


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "''") + "'"


def _flat(line: Mapping[str, Any]) -> dict[str, Any]:
    """Column names and raw values of a line."""
    names = (*_FRONT, "level_name", "expected", "violations")
    flat = {name: line.get(name) for name in names}
    for name, value in _leaves(line.get("summary") or {}, ""):
        if name not in flat:
            flat[name] = value
    for name, value in _leaves(line.get("measured") or {}, "measured."):
        flat[name] = value
    return flat


def _leaves(mapping: Mapping[str, Any], prefix: str) -> Iterable[tuple[str, Any]]:
    for key, value in mapping.items():
        name = str(key)
        if not name.isprintable():
            name = "".join(letter for letter in name if letter.isprintable())
        if not name or is_private(name):
            continue
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _type_of(value: Any) -> str:
    if isinstance(value, bool):
        return "BOOLEAN"
    if isinstance(value, int):
        return "BIGINT"
    if isinstance(value, float):
        return "DOUBLE"
    if isinstance(value, list | tuple):
        kind: str | None = None
        for item in value:
            if item is not None:
                kind = _wider(kind, _type_of(item))
        return f"{kind or 'DOUBLE'}[]"
    return "VARCHAR"


def _wider(first: str | None, second: str) -> str:
    """The type that holds values of both."""
    if first is None or first == second:
        return second
    if first.endswith("[]") and second.endswith("[]"):
        return _wider(first[:-2], second[:-2]) + "[]"
    return "DOUBLE" if {first, second} == {"BIGINT", "DOUBLE"} else "VARCHAR"


def _cast(value: Any, kind: str) -> Any:
    """The value as a column of that type holds it; None where it does not fit."""
    if value is None:
        return None
    if kind.endswith("[]"):
        items = value if isinstance(value, list | tuple) else [value]
        return [_cast(item, kind[:-2]) for item in items]
    if kind == "VARCHAR":
        text = value if isinstance(value, str) else json.dumps(value, sort_keys=True)
        return scrubbed(text)
    if kind == "BOOLEAN":
        return value if isinstance(value, bool) else None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    if kind == "BIGINT":
        return int(value) if abs(value) < 2**63 else None
    return float(value)


def _rank(row: Mapping[str, Any]) -> tuple[Any, ...]:
    texts = [row[name] or "" for name in ("suite", "scenario", "disturbance", "variant", "trial")]
    seed = row["seed"]
    return (*texts[:2], -1 if seed is None else seed, *texts[2:])


_PATH = re.compile(
    r"(?:\bfile://|(?<![\w./~-]))(?:~|\.{1,2})?(?:/[\w.+@%=,-]+)+/?"  # /a/x, ~/x, ../x, file URLs
    r"|\b[A-Za-z]:[\\/](?:[^\s\\/:;,'\"]+[\\/])*[^\s\\/:;,'\"]*"  # C:\Users\x
)
_PROCESS = re.compile(r"\b(pid|process|worker)(?:\s*[=:#]\s*|\s+)\d+\b", re.IGNORECASE)
_HOST = re.compile(
    r"\b(?:\d{1,3}\.){3}\d{1,3}(?::\d+)?\b|\b(?:host|hostname|node)\s*[=:]\s*[\w.-]+", re.IGNORECASE
)
_PRIVATE = frozenset(
    ("cwd", "directory", "dir", "file", "folder", "host", "hostname", "ip", "node", "out", "path",
     "paths", "pid", "process", "tmp", "user", "worker")
)  # fmt: skip


def scrubbed(text: str) -> str:
    """The text on one line, paths cut to their last part, process ids and hosts taken out."""
    text = _PATH.sub(lambda match: re.split(r"[\\/]", match[0].rstrip("\\/"))[-1], text)
    text = _PROCESS.sub(r"\1", text)
    return " ".join(_HOST.sub("host", text).split())


def is_private(key: str) -> bool:
    """Whether a key of that name holds a path, a process id or a host."""
    return key.lower() in _PRIVATE
