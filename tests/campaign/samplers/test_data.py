from __future__ import annotations

import pytest

from cavalcade.campaign.samplers import DataFolder
from cavalcade.errors import InputError


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.delenv("CAVALCADE_DATA", raising=False)
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    return work


def test_the_first_there_is(here, monkeypatch):
    assert DataFolder.find().path is None
    shared = here.parent / "shared" / "data"
    shared.mkdir(parents=True)
    assert DataFolder.find().path == shared.resolve()
    (here / "data").mkdir()
    assert DataFolder.find().path == (here / "data").resolve()
    other = here / "other"
    other.mkdir()
    monkeypatch.setenv("CAVALCADE_DATA", str(other))
    assert DataFolder.find().path == other.resolve()
    named = here / "named"
    named.mkdir()
    assert DataFolder.find("named").path == named.resolve()


def test_what_is_named_must_be_there(here, monkeypatch):
    with pytest.raises(InputError, match="no such folder: nowhere"):
        DataFolder.find("nowhere")
    monkeypatch.setenv("CAVALCADE_DATA", "gone")
    with pytest.raises(InputError, match="CAVALCADE_DATA: no such folder: gone"):
        DataFolder.find()


def test_files(tmp_path):
    (tmp_path / "map.yaml").write_text("")
    assert DataFolder(tmp_path).file("map.yaml") == tmp_path / "map.yaml"
    with pytest.raises(InputError, match=r"b\.yaml: not in .*--data"):
        DataFolder(tmp_path).file("b.yaml")
    with pytest.raises(InputError, match="there is no folder of data"):
        DataFolder(None).file("b.yaml")
