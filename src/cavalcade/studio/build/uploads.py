"""Files that come from the page: told by their content, kept in a folder of their own.

A file says nothing by its type or name that its reader does not confirm. Names are cleaned, and
files that an uploaded one names are looked for among the uploads alone.
"""

from __future__ import annotations

import re
import shutil
import tempfile
import unicodedata
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath
from typing import Any, Literal

import yaml

from cavalcade.errors import InputError, MapError
from cavalcade.files import make_folders, write_file
from cavalcade.scenario import dump_scenario, import_problem, parse_scenario
from cavalcade.scenario.shipped import MAX_BYTES
from cavalcade.studio.build.draft import names_of, text_of, with_names
from cavalcade.world import load_barn, load_map, load_movingai, load_terrain
from cavalcade.yaml_text import parse_yaml

LIMIT = 64_000_000
"""Largest upload, bytes."""

Kind = Literal["scenario", "map", "movingai", "barn", "terrain", "waiting"]

ACCEPTED = ".yaml,.yml,.pgm,.png,.map,.npy,.npz,.csv,.stl,.ply"
"""What the page's dialog offers."""

_NAME_LENGTH = 100
_UNREADABLE = (
    "is none of the files that can be used: scenarios and descriptions of maps and terrain "
    "(.yaml), pictures (.pgm, .png), MovingAI maps (.map), BARN worlds (.npy) and terrain "
    "(.npz, .csv, .stl, .ply)"
)
_PICTURE = {"image": "", "resolution": 0.05, "origin": [0, 0, 0], "negate": 0}
_PICTURE |= {"occupied_thresh": 0.65, "free_thresh": 0.196}


@dataclass(frozen=True)
class Upload:
    """A file that was taken.

    Attributes:
        path: Where it is kept; of a map's picture, its description if that was waiting for it.
        kind: What it is; `waiting` for files that are used through another one.
        wanted: The file that it waits for, in words; None if nothing is missing.
        world: The scenario's `world` that uses it, for sources of worlds.
    """

    path: Path
    kind: Kind
    wanted: str | None = None
    world: Mapping[str, Any] | None = None


class Uploads:
    """The folder of what was uploaded in one session; a file replaces one of the same name.

    Args:
        folder: Where they are kept; made with the first one.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()  # scenarios name files in it, wherever they are

    def take(self, name: str, content: bytes) -> Upload:
        """Keep a file, if it is one that can be used.

        Raises:
            InputError: It is too large or none of the known formats; nothing is kept of it.
        """
        clean = clean_name(name)
        check_size(clean, len(content))
        if not content:
            raise InputError("is empty", file=clean)
        make_folders(self.folder)
        with tempfile.TemporaryDirectory(dir=self.folder, prefix=".new-") as new:
            trial = Path(new) / clean
            try:
                found = self._told(trial, content)
            except InputError as error:
                raise _renamed(error, Path(new), self.folder) from None
            kept = self.folder / clean
            write_file(kept, trial.read_bytes())
        path = found.path if found.path.parent == self.folder else kept
        world = None if found.world is None else with_folder(found.world, self.folder)
        return Upload(path, found.kind, found.wanted, world)

    def _told(self, trial: Path, content: bytes) -> Upload:
        suffix = trial.suffix.lower()
        if suffix in (".yaml", ".yml"):
            return self._text(trial, content)
        trial.write_bytes(content)
        if suffix == ".map":
            return _read(trial, "movingai", {"movingai": {"file": str(trial)}})
        if suffix in (".pgm", ".png"):
            return self._picture(trial)
        if suffix in (".npz", ".stl", ".ply"):
            return _read(trial, "terrain", {"terrain": str(trial)})
        if suffix == ".npy":
            return _read(trial, "barn", {"barn": {"file": str(trial)}})
        if suffix == ".csv":
            return self._table(trial)
        raise InputError(_UNREADABLE, file=trial.name)

    def _text(self, trial: Path, content: bytes) -> Upload:
        if len(content) > MAX_BYTES:
            raise InputError(f"is larger than {MAX_BYTES // 1_000_000} MB", file=trial.name)
        data = parse_yaml(content, file=trial.name)
        if not isinstance(data, dict):
            raise InputError(_UNREADABLE, file=trial.name)
        if "world" in data:
            return self._scenario(trial, data)
        if {"environment", "robots"} <= set(data):
            trial.write_bytes(content)
            dump_scenario(import_problem(trial), trial)
            return Upload(trial, "scenario")
        if "image" in data:
            return self._description(trial, data, "map", ("image",))
        if "file" in data:
            return self._description(trial, data, "terrain", ("file", "x", "y"))
        raise InputError(_UNREADABLE, file=trial.name)

    def _scenario(self, trial: Path, data: dict[str, Any]) -> Upload:
        with suppress(AttributeError, KeyError, TypeError):  # these are told of below
            data = with_names(data, clean_name)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            parse_scenario(data, self.folder / trial.name)
        trial.write_text(text_of(data), "utf-8")
        missing = self._missing(name for name in names_of(data))
        return Upload(trial, "scenario", missing and f"it needs {missing}; upload that first")

    def _description(
        self, trial: Path, data: dict[str, Any], kind: Kind, keys: tuple[str, ...]
    ) -> Upload:
        names = {key: clean_name(str(data[key])) for key in keys if data.get(key) is not None}
        trial.write_text(yaml.safe_dump({**data, **names}, sort_keys=False), "utf-8")
        missing = self._missing(iter(names.values()))
        if missing is not None:
            return Upload(trial, "waiting", f"now upload {missing}, which it describes")
        for name in names.values():
            shutil.copyfile(self.folder / name, trial.with_name(name))
        return _read(trial, kind, {kind: str(trial)})

    def _picture(self, trial: Path) -> Upload:
        """A picture, and the map that it completes."""
        described = trial.with_name(".picture.yaml")
        described.write_text(yaml.safe_dump({**_PICTURE, "image": trial.name}), "utf-8")
        try:
            load_map(described)
        except MapError as error:
            raise error.at(file=trial.name) from None
        return self._completes(trial, "map") or self._completes(trial, "terrain") or _waiting(trial)

    def _table(self, trial: Path) -> Upload:
        try:
            trial.read_bytes().decode("ascii")
        except UnicodeDecodeError:
            raise InputError("is no table of numbers in text", file=trial.name) from None
        return self._completes(trial, "terrain") or _waiting(trial)

    def _completes(self, trial: Path, kind: Kind) -> Upload | None:
        """The description that has been waiting for this file, now that it is there."""
        key = "image" if kind == "map" else "file"
        for described in sorted(self.folder.glob("*.y*ml")):
            data = parse_yaml(described.read_bytes(), file=described.name)
            if not isinstance(data, dict) or data.get(key) != trial.name:
                continue
            copied = trial.with_name(described.name)
            shutil.copyfile(described, copied)
            found = _read(copied, kind, {kind: str(copied)})
            return Upload(described, kind, None, found.world)
        return None

    def _missing(self, names: Any) -> str | None:
        return next((name for name in names if not (self.folder / name).is_file()), None)


def check_size(name: str, size: int) -> None:
    """Refuse what is too large, best before it is there.

    Raises:
        InputError: It is.
    """
    if size > LIMIT:
        text = f"has {size / 1e6:.0f} MB; expected at most {LIMIT // 1_000_000} MB"
        raise InputError(text, file=clean_name(name))


def clean_name(name: str) -> str:
    """The name of a file without folders and of plain letters: safe on every system."""
    last = PureWindowsPath(name.replace("\0", "")).name  # of both kinds of slash
    letters = unicodedata.normalize("NFKD", last).encode("ascii", "ignore").decode()
    stem, dot, suffix = re.sub(r"[^A-Za-z0-9._-]+", "_", letters).rpartition(".")
    if not dot:
        stem, suffix = suffix, ""
    suffix = suffix[:10]
    stem = stem.lstrip("._-")[: _NAME_LENGTH - len(suffix)].rstrip("._-") or "upload"
    return f"{stem}.{suffix}" if suffix else stem


def with_folder(world: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """A source of a world whose file lies in another folder."""

    def change(name: str) -> str:
        return str(folder / Path(name).name)

    changed: dict[str, Any] = with_names({"world": world}, change)["world"]
    return changed


def _waiting(trial: Path) -> Upload:
    return Upload(trial, "waiting", "now upload the .yaml file that describes it")


def _read(path: Path, kind: Kind, world: Mapping[str, Any]) -> Upload:
    """Try to read it as what it seems to be."""
    readers: dict[str, Callable[[Path], object]] = {
        "map": load_map,
        "movingai": lambda file: load_movingai(file, 0.25),
        "barn": load_barn,
        "terrain": load_terrain,
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        readers[kind](path)
    return Upload(path, kind, None, world)


def _renamed(error: InputError, *folders: Path) -> InputError:
    """The error by the file's own name: where it is kept is nobody's business."""
    text, file = error.message, error.file
    for folder in folders:
        text = text.replace(f"{folder}/", "")
        file = file and file.replace(f"{folder}/", "")
    return type(error)(text, file=file, key=error.key, choices=error.choices)
