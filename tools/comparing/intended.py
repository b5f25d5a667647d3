"""What has changed on purpose in the contract of a file: the one list, and how it is applied.

Each entry says in which files (a glob over names within a job's folder: `*/summary.json`,
`*.said.json`), what was there and what is there now, and why. It is applied to the old side, so
that afterwards both sides must be equal.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any


@dataclass(frozen=True)
class RenamedKey:
    """A key, column, array or topic with another name at the same place.

    `old` and `new` are dotted paths of equal length that differ in their last part only
    (`planner.conflict`, `robots.*.model`; `*` is any key or element). Columns of tables, arrays
    of plans and topics of recordings are names as they stand, dots and all. An empty `new` means
    that the key is gone, an empty `old` that it is new: it is left out wherever the old side
    lacks it.
    """

    where: str
    old: str
    new: str
    why: str


@dataclass(frozen=True)
class ChangedValue:
    """Another value at the dotted path `key` (as the new side names it) for the same thing."""

    where: str
    key: str
    old: Any
    new: Any
    why: str


@dataclass(frozen=True)
class ChangedText:
    """Another wording: `old` is a regular expression over one text, `new` what replaces it.

    An empty `old` drops the texts of the new side's lists that match `new` as a whole, such as a
    warning that was not there before.
    """

    where: str
    old: str
    new: str
    why: str


@dataclass(frozen=True)
class ChangedOrder:
    """The keys of the outermost mapping come in another order."""

    where: str
    why: str


Change = RenamedKey | ChangedValue | ChangedText | ChangedOrder

_PLAN_KEYS = (*("found_by", "iterations", "limit_s", "counts", "margin_m", "footholds", "delay_s"),)
_EVERY_KEY = "all summaries have all keys, null where they do not apply, as the contract says"
_EVERY_COLUMN = "the table has a column for each key of a summary, whatever its trials hold"

_STRAY, _ERROR = "planner.expect.stray", "planner.expect.tracking_error"
_WORDS = "the field's terms; the old spelling is still taken"

INTENDED: tuple[Change, ...] = (
    RenamedKey("*scenario.yaml", _STRAY, _ERROR, _WORDS),
    ChangedText("*", "^cavalcade-no-standoffs$", "cavalcade-no-recovery", _WORDS),
    ChangedText("*", "no way to the goal for ", "no path to the goal for ", _WORDS),
    ChangedText("*", "^stand-off of ", "deadlock of ", _WORDS),
    *(RenamedKey("*/summary.json", "", key, _EVERY_KEY) for key in _PLAN_KEYS),
    ChangedText("*.said.json", "", "cavalcade: warning: .* is called .* now", _WORDS),
    RenamedKey("*campaign.json", "suite.worlds.*.draw", "suite.worlds.*.sampler", _WORDS),
    ChangedValue("*campaign.json", "suite.worlds.*.sampler", "hopeless", "infeasible", _WORDS),
    ChangedOrder("run/summary.json", "margin_m and delay_s stand where those of plans do"),
    ChangedOrder("*.parquet", "columns come in the order of a summary's keys"),
    *(RenamedKey("*.said.json", "", key, _EVERY_KEY) for key in _PLAN_KEYS),
    *(RenamedKey("*.jsonl", "", f"*.summary.{key}", _EVERY_KEY) for key in _PLAN_KEYS),
    *(
        RenamedKey("*.parquet", "", column, _EVERY_COLUMN)
        for column in (
            *("found_by", "iterations", "limit_s", "margin_m", "delay_s"),
            *("footholds.count", "footholds.out_of_reach"),
            *(f"physics.contacts.{kind}" for kind in ("robot_robot", "robot_obstacle")),
            *(f"physics.contacts.ground.{part}" for part in ("trunk", "hip", "thigh", "calf")),
            *("physics.max_speed_share", "physics.min_height_m", "physics.max_height_m"),
            "physics.carried_share",
        )
    ),
)
"""Everything that may differ from the old side, and nothing else."""


def apply_changes(
    name: str, old: Any, new: Any, changes: Sequence[Change], flat: bool = False
) -> tuple[Any, Any]:
    """Both sides' values of the file of that name, the old one's as it would be said today.

    Args:
        name: Of the file, relative to the job's folder.
        old: Plain data of the old side.
        new: Plain data of the new side.
        changes: What is intended, applied in this order.
        flat: Keys are names as they stand and not dotted paths.
    """
    for change in changes:
        if not fnmatchcase(name, change.where):
            continue
        if isinstance(change, RenamedKey):
            if change.old:
                old = _renamed(old, _parts(change.old, flat), _parts(change.new, flat))
            else:
                new = _without_new(new, old, _parts(change.new, flat))
        elif isinstance(change, ChangedOrder):
            if isinstance(old, dict) and isinstance(new, dict):
                first = {key: old[key] for key in new if key in old}
                old = {**first, **old}
        elif isinstance(change, ChangedValue):
            old = _replaced(old, _parts(change.key, flat), change.old, change.new)
        elif change.old:
            old = _reworded(old, re.compile(change.old), change.new)
        else:
            new = _without(new, re.compile(change.new))
    return old, new


def _parts(path: str, flat: bool) -> list[str]:
    if not path:
        return []
    return [path] if flat else path.split(".")


def _renamed(tree: Any, path: list[str], new: list[str]) -> Any:
    """The tree with the last part of the path renamed, or left out if there is no new one."""
    head, *rest = path
    if not rest and isinstance(tree, dict):
        pairs = ((new[-1] if new and key == head else key, tree[key]) for key in tree)
        return dict(pairs) if new else {key: tree[key] for key in tree if key != head}
    return _below(tree, head, lambda child: _renamed(child, rest, new)) if rest else tree


def _without_new(new: Any, old: Any, path: list[str]) -> Any:
    """The new tree without the last part of the path, wherever the old tree has no such key."""
    head, *rest = path
    if isinstance(new, dict):
        known = old if isinstance(old, dict) else {}
        if not rest:
            return {k: v for k, v in new.items() if k != head or k in known}
        return {
            k: _without_new(v, known.get(k), rest) if head in ("*", str(k)) else v
            for k, v in new.items()
        }
    if isinstance(new, list) and rest:
        items = old if isinstance(old, list) and len(old) == len(new) else [None] * len(new)
        return [
            _without_new(v, items[k], rest) if head in ("*", str(k)) else v
            for k, v in enumerate(new)
        ]
    return new


def _replaced(tree: Any, path: list[str], old: Any, new: Any) -> Any:
    if not path:
        return new if type(tree) is type(old) and tree == old else tree
    return _below(tree, path[0], lambda child: _replaced(child, path[1:], old, new))


def _below(tree: Any, part: str, change: Any) -> Any:
    """The tree with its children of that name changed; `*` is every one."""
    if isinstance(tree, dict):
        return {k: change(v) if part in ("*", str(k)) else v for k, v in tree.items()}
    if isinstance(tree, list):
        return [change(v) if part in ("*", str(k)) else v for k, v in enumerate(tree)]
    return tree


def _reworded(tree: Any, old: re.Pattern[str], new: str) -> Any:
    if isinstance(tree, str):
        return old.sub(new, tree)
    if isinstance(tree, dict):
        return {key: _reworded(value, old, new) for key, value in tree.items()}
    if isinstance(tree, list):
        return [_reworded(value, old, new) for value in tree]
    return tree


def _without(tree: Any, text: re.Pattern[str]) -> Any:
    if isinstance(tree, dict):
        return {key: _without(value, text) for key, value in tree.items()}
    if isinstance(tree, list):
        kept: Iterable[Any] = (v for v in tree if not (isinstance(v, str) and text.fullmatch(v)))
        return [_without(value, text) for value in kept]
    return tree
