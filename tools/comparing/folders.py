"""What two folders of results differ in: file by file, key by key, bit by bit.

Pictures and pages count by their being there. Of plain data everything counts: values, types, the
order of keys; but for times of the machine and versions, of which only null and not null count.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from comparing.intended import INTENDED, Change, apply_changes
from comparing.recordings import recording_differences

TIMES = frozenset(
    (
        "wall_time_s",
        "planning_time_s",
        "cycle_ms",
        "real_time_factor",
        "versions",
        "single_time_ratio",
        "fingerprint",
    )
)
"""Keys of what differs between two runs of the same source; and a campaign's fingerprint, a hash of
its definition that stands beside it and is compared itself."""

MASK = "<differs from run to run>"
SAID = ".said.json"
"""The ending of files with a command's exit code and what it said."""


@dataclass(frozen=True)
class Difference:
    """Where two sides differ.

    Attributes:
        file: Relative to the folders.
        key: Within the file; empty for the whole of it.
        old: The old side's value, as text.
        new: The new side's.
    """

    file: str
    key: str
    old: str
    new: str

    def __str__(self) -> str:
        place = f"{self.file}: {self.key}" if self.key else self.file
        return f"{place}: {_short(self.old)} -> {_short(self.new)}"


@dataclass(frozen=True)
class Side:
    """What one checkout left.

    Attributes:
        folder: Where.
        places: Folders that texts may name, with what stands for them in a comparison.
    """

    folder: Path
    places: tuple[tuple[Path, str], ...] = ()


def compare_folders(old: Side, new: Side, changes: Sequence[Change] = INTENDED) -> list[Difference]:
    """All differences: files that one side lacks, then file by file, results before messages."""
    names = [_names(side.folder) for side in (old, new)]
    found = [
        Difference(name, "", *("there" if name in side else "missing" for side in names))
        for name in sorted(names[0] ^ names[1])
    ]
    for name in sorted(names[0] & names[1], key=_rank):
        found += compare_files(name, old, new, changes)
    return found


def compare_files(
    name: str, old: Side, new: Side, changes: Sequence[Change] = INTENDED
) -> list[Difference]:
    """The differences of the files of that name; their being there is no question any more."""
    files = (old.folder / name, new.folder / name)
    suffix = files[0].suffix
    if suffix == ".mcap":
        found = recording_differences(name, *files, changes)
    elif suffix in (".yaml", ".json", ".jsonl", ".npz", ".parquet"):
        trees = [_read(file, side) for file, side in zip(files, (old, new), strict=True)]
        flat = suffix in (".npz", ".parquet")
        found = tree_differences(*apply_changes(name, trees[0], trees[1], changes, flat))
    else:
        return []
    return [Difference(name, key, before, after) for key, before, after in found]


def tree_differences(old: Any, new: Any, path: str = "") -> Iterator[tuple[str, str, str]]:
    """Key, old and new value of every place where two trees of plain data differ."""
    if isinstance(old, np.ndarray) and isinstance(new, np.ndarray):
        yield from _array_differences(old, new, path)
    elif isinstance(old, dict) and isinstance(new, dict):
        for key in [*old, *(key for key in new if key not in old)]:
            place = f"{path}.{key}" if path else str(key)
            if key not in new:
                yield place, _text(old[key]), "missing"
            elif key not in old:
                yield place, "missing", _text(new[key])
            else:
                yield from tree_differences(old[key], new[key], place)
        if old.keys() == new.keys() and list(old) != list(new):
            yield f"{path} (order of keys)".strip(), ", ".join(old), ", ".join(new)
    elif isinstance(old, list) and isinstance(new, list):
        for index, (before, after) in enumerate(zip(old, new, strict=False)):
            yield from tree_differences(before, after, f"{path}[{index}]")
        if len(old) != len(new):
            shorter = min(len(old), len(new))
            rest = [_text(one[shorter]) if len(one) > shorter else "missing" for one in (old, new)]
            yield f"{path}[{shorter}]", rest[0], rest[1]
    elif type(old) is not type(new) or repr(old) != repr(new):  # repr tells -0.0 from 0.0
        yield path, _text(old), _text(new)


def _array_differences(old: Any, new: Any, path: str) -> Iterator[tuple[str, str, str]]:
    kinds = [f"{array.dtype}{list(array.shape)}" for array in (old, new)]
    if kinds[0] != kinds[1]:
        yield path, kinds[0], kinds[1]
        return
    if old.tobytes() == new.tobytes():
        return
    size = old.dtype.itemsize
    before, after = (
        np.frombuffer(array.tobytes(), dtype=np.uint8).reshape(-1, size) for array in (old, new)
    )
    changed = np.flatnonzero((before != after).any(axis=1))
    place = np.unravel_index(changed[0], old.shape)
    index = ", ".join(str(int(k)) for k in place)
    more = f" ({len(changed)} of {old.size} elements)"
    yield f"{path}[{index}]", repr(old[place].item()), repr(new[place].item()) + more


def _names(folder: Path) -> set[str]:
    """Names of the files in it, hidden ones left out."""
    files = (file.relative_to(folder) for file in folder.rglob("*") if file.is_file())
    return {str(name) for name in files if not any(part.startswith(".") for part in name.parts)}


def _rank(name: str) -> tuple[int, str]:
    order = (".yaml", "summary.json", ".npz", ".mcap", ".jsonl", ".parquet", SAID, ".json")
    return next((k for k, end in enumerate(order) if name.endswith(end)), len(order)), name


def _read(file: Path, side: Side) -> Any:
    """A file's content as plain data without times, versions and names of this side's folders."""
    if file.suffix == ".npz":
        with np.load(file, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    if file.suffix == ".parquet":
        return _table(file)
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".yaml":
        tree = yaml.safe_load(text)
    elif file.suffix == ".jsonl":
        # In the order of their ending; one trial may be done before another.
        lines = [json.loads(line) for line in text.splitlines()]
        tree = {str(line.get("trial")): line for line in lines}
        tree = {trial: tree[trial] for trial in sorted(tree)}
    else:
        tree = json.loads(text)
    return _without_places(_without_times(tree), side, file.parent)


def _table(file: Path) -> dict[str, Any]:
    """Each column's type and values; times and versions as null or not null."""
    import duckdb

    relation = duckdb.sql(
        f"SELECT * FROM read_parquet('{str(file).replace(chr(39), chr(39) * 2)}')"
    )
    names, kinds = relation.columns, [str(kind) for kind in relation.types]
    columns = zip(*relation.fetchall(), strict=True)
    values = [list(column) for column in columns] or [[] for _ in names]
    return {
        name: {
            "type": kind,
            "values": _masked(rows) if TIMES & set(name.split(".")) else rows,
        }
        for name, kind, rows in zip(names, kinds, values, strict=True)
    }


def _without_times(tree: Any) -> Any:
    if isinstance(tree, dict):
        return {k: _masked(v) if k in TIMES else _without_times(v) for k, v in tree.items()}
    if isinstance(tree, list):
        return [_without_times(value) for value in tree]
    return tree


def _masked(tree: Any) -> Any:
    if isinstance(tree, dict):
        return {key: _masked(value) for key, value in tree.items()}
    if isinstance(tree, list):
        return [_masked(value) for value in tree]
    return None if tree is None else MASK


def _without_places(tree: Any, side: Side, folder: Path) -> Any:
    if isinstance(tree, dict):
        return {key: _without_places(value, side, folder) for key, value in tree.items()}
    if isinstance(tree, list):
        return [_without_places(value, side, folder) for value in tree]
    return _without_place(tree, side, folder) if isinstance(tree, str) else tree


def _without_place(text: str, side: Side, folder: Path) -> str:
    if "/" in text and "\n" not in text and len(text) < 1000 and (folder / text).exists():
        file = (folder / text).resolve()
        for place, name in side.places:
            if file.is_relative_to(place):
                return f"{name}/{file.relative_to(place)}"
    for place, name in side.places:
        text = re.sub(rf"{re.escape(str(place))}(?![\w.-])", name, text)
    return text


def _text(value: Any) -> str:
    return f"{value.dtype}{list(value.shape)}" if isinstance(value, np.ndarray) else repr(value)


def _short(text: str, limit: int = 160) -> str:
    line = " ".join(text.split())
    return line if len(line) <= limit else f"{line[: limit - 3]}..."
