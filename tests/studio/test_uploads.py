"""Files from the page: what is taken, what is refused and in which words."""

from __future__ import annotations

import io
import zipfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cavalcade.errors import InputError
from cavalcade.scenario import load_scenario
from cavalcade.studio.build import uploads as module
from cavalcade.studio.build.draft import Draft
from cavalcade.studio.build.packing import download_of
from cavalcade.studio.build.uploads import LIMIT, Uploads, check_size, clean_name
from cavalcade.world import OccupancyMap, save_map

MOVINGAI = b"type octile\nheight 3\nwidth 4\nmap\n....\n.@@.\n....\n"
STEP = b"version: 1\nname: s\nworld: {map: MAP}\nrobots: [{start: [1, 1, 0]}]\n" + (
    b"task: {formation: {shape: line}, goals: [[2, 2, 0]]}\n"
)


@pytest.fixture
def uploads(tmp_path: Path) -> Uploads:
    """An empty folder of uploads."""
    return Uploads(tmp_path / "uploads")


@pytest.fixture
def lab(tmp_path: Path) -> tuple[bytes, bytes]:
    """Description and picture of a map."""
    save_map(OccupancyMap(np.zeros((60, 80), dtype=bool), 0.1), tmp_path / "lab.yaml")
    picture = next(tmp_path.glob("lab.p?m"))
    return (tmp_path / "lab.yaml").read_bytes(), picture.read_bytes()


def _names(uploads: Uploads) -> set[str]:
    return {path.name for path in uploads.folder.iterdir()} if uploads.folder.exists() else set()


def test_a_map_is_in_use_once_both_its_files_are_there(
    uploads: Uploads, lab: tuple[bytes, bytes]
) -> None:
    first = uploads.take("lab.yaml", lab[0])
    assert first.kind == "waiting"
    assert first.wanted is not None
    assert "lab.pgm" in first.wanted
    second = uploads.take("lab.pgm", lab[1])
    assert second.kind == "map"
    assert second.wanted is None
    assert second.world == {"map": str(uploads.folder / "lab.yaml")}
    draft = Draft()
    draft.set("world", dict(second.world or {}))
    assert draft.state.world.base.size == (8.0, 6.0)


def test_a_picture_may_come_before_its_description(
    uploads: Uploads, lab: tuple[bytes, bytes]
) -> None:
    assert uploads.take("lab.pgm", lab[1]).wanted is not None
    assert uploads.take("lab.yaml", lab[0]).world == {"map": str(uploads.folder / "lab.yaml")}


def test_other_worlds_are_told_by_their_content(uploads: Uploads) -> None:
    found = uploads.take("arena.map", MOVINGAI)
    assert found.world == {"movingai": {"file": str(uploads.folder / "arena.map")}}
    mesh = b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 4 0 0\nvertex 0 4 1\n"
    found = uploads.take("hill.stl", mesh + b"endloop\nendfacet\nendsolid s\n")
    assert found.world == {"terrain": str(uploads.folder / "hill.stl")}
    with pytest.raises(InputError, match=r"hills\.npz"):
        uploads.take("hills.npz", b"PK\x03\x04 garbage")
    assert _names(uploads) == {"arena.map", "hill.stl"}


def test_a_scenario_says_which_map_it_needs(uploads: Uploads, lab: tuple[bytes, bytes]) -> None:
    text = STEP.replace(b"MAP", b"/home/me/maps/lab.yaml")
    found = uploads.take("run.yaml", text)
    assert found.kind == "scenario"
    assert found.wanted is not None
    assert "lab.yaml" in found.wanted
    uploads.take("lab.yaml", lab[0])
    uploads.take("lab.pgm", lab[1])
    found = uploads.take("run.yaml", text)
    assert found.wanted is None
    draft = Draft()
    draft.load(found.path)
    assert draft.data["world"]["map"] == str(uploads.folder / "lab.yaml")


def test_problems_of_other_projects_become_scenarios(uploads: Uploads, shared_data: Any) -> None:
    problem = shared_data("db_cbs/swap2_unicycle.yaml")
    found = uploads.take(problem.name, problem.read_bytes())
    assert found.kind == "scenario"
    draft = Draft()
    draft.load(found.path)
    assert len(draft.state.robots) == 2


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.yaml", b"\x00\x01\x02", "a.yaml: not valid YAML"),
        ("a.yaml", b"just text", "is none of the files that can be used"),
        ("a.yaml", b"world: 3\nname: x\nversion: 1\n", "expected a mapping"),
        ("a.yaml", b"world: {empty: {size: [-1, 2]}}\nversion: 1\nname: x\n", "greater than 0"),
        ("a.png", b"not a picture", "expected a PGM (P2, P5) or PNG picture"),
        ("a.png", b"\x89PNG\r\n\x1a\n" + b"\0" * 40, "a.png"),
        ("a.pgm", b"P5\n999999 999999\n255\n", "a.pgm"),
        ("a.map", b"type octile\nheight 3\nwidth 4\nmap\n....\n", "truncated"),
        ("a.map", b"\xff" * 200, "expected a MovingAI map"),
        ("a.stl", b"solid nothing", "a.stl"),
        ("a.npy", b"x_m,y_m,radius_m\n1,2,x\n", "expected three numbers"),
        ("a.npy", b"\x93NUMPY", "a.npy"),
        ("a.csv", b"\xff\xfe", "is no table"),
        ("a.exe", b"MZ", "is none of the files that can be used"),
        ("a", b"words", "is none of the files that can be used"),
        ("a.yaml", b"", "is empty"),
    ],
)
def test_garbage_is_refused_in_words(
    uploads: Uploads, name: str, content: bytes, words: str
) -> None:
    with pytest.raises(InputError) as caught:
        uploads.take(name, content)
    assert words in str(caught.value)
    assert str(uploads.folder) not in str(caught.value)
    assert _names(uploads) == set()


@given(st.binary(max_size=300), st.sampled_from(["a.yaml", "a.png", "a.map", "a.npz", "a.ply"]))
def test_no_bytes_end_in_anything_but_words(
    tmp_path_factory: pytest.TempPathFactory, content: bytes, name: str
) -> None:
    uploads = Uploads(tmp_path_factory.getbasetemp() / "fuzzed")
    with suppress(InputError):
        uploads.take(name, content)


def test_what_is_too_large_is_refused(uploads: Uploads, monkeypatch: pytest.MonkeyPatch) -> None:
    check_size("a.map", LIMIT)
    with pytest.raises(InputError, match="has 64 MB; expected at most 64 MB"):
        check_size("a.map", LIMIT + 1)
    monkeypatch.setattr(module, "LIMIT", 10)
    with pytest.raises(InputError, match=r"a\.map: has 0 MB"):
        uploads.take("a.map", MOVINGAI)
    assert _names(uploads) == set()


def test_a_damaged_file_does_not_take_the_place_of_a_good_one(uploads: Uploads) -> None:
    uploads.take("arena.map", MOVINGAI)
    with pytest.raises(InputError):
        uploads.take("arena.map", b"garbage")
    assert (uploads.folder / "arena.map").read_bytes() == MOVINGAI


@pytest.mark.parametrize(
    ("name", "clean"),
    [
        ("lab.yaml", "lab.yaml"),
        ("../../etc/passwd", "passwd"),
        ("C:\\maps\\lab 1.pgm", "lab_1.pgm"),
        (".hidden", "upload.hidden"),
        ("..", "upload"),
        ("", "upload"),
        ("Büro.yaml", "Buro.yaml"),
        ("a\0b.map", "ab.map"),
        ("日本.yaml", "upload.yaml"),
        ("x" * 300 + ".yaml", "x" * 96 + ".yaml"),
    ],
)
def test_names_are_cleaned(name: str, clean: str) -> None:
    assert clean_name(name) == clean


@given(st.text(max_size=200))
def test_no_name_leaves_the_folder(name: str) -> None:
    clean = clean_name(name)
    assert clean == Path(clean).name
    assert clean not in ("", ".", "..")
    assert len(clean) <= 110
    assert clean_name(clean) == clean


def test_uploaded_files_go_with_the_download(
    uploads: Uploads, lab: tuple[bytes, bytes], tmp_path: Path
) -> None:
    uploads.take("lab.yaml", lab[0])
    found = uploads.take("lab.pgm", lab[1])
    draft = Draft()
    draft.replace({**draft.data, "name": "lab", "world": dict(found.world or {})})
    draft.set("robots", [{"start": [1.0, 1.0, 0.0]}])
    draft.set("task", {"formation": {"shape": "line"}, "goals": [[6.0, 4.0, 0.0]]})
    name, content = download_of(draft, uploads.folder)
    assert name == "lab.zip"
    zipfile.ZipFile(io.BytesIO(content)).extractall(tmp_path / "there")
    files = {path.name for path in (tmp_path / "there/lab").iterdir()}
    assert files == {"lab-scenario.yaml", "lab.yaml", "lab.pgm"}
    scenario = load_scenario(tmp_path / "there/lab/lab-scenario.yaml")
    assert scenario.world.map == tmp_path / "there/lab/lab.yaml"


def test_a_download_without_uploads_is_the_file_itself(uploads: Uploads, tmp_path: Path) -> None:
    draft = Draft()
    draft.load("office")
    name, content = download_of(draft, uploads.folder)
    assert name == "office.yaml"
    (tmp_path / name).write_bytes(content)
    assert load_scenario(tmp_path / name) == draft.scenario


def test_a_relative_folder_of_uploads_is_named_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found = Uploads(Path("runs/uploads")).take("arena.map", MOVINGAI)
    assert found.world == {"movingai": {"file": str(tmp_path / "runs/uploads/arena.map")}}
