"""Files are read as far as they may be, and written whole or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from cavalcade.errors import OutputError, ScenarioError
from cavalcade.files import read_bytes, read_head, replacing, write_file


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    write_file(tmp_path / "a", "grün\r\n")
    assert read_bytes(tmp_path / "a", 100) == "grün\r\n".encode()
    write_file(tmp_path / "a", b"\0\n", durable=True)
    assert read_bytes(tmp_path / "a", 2) == b"\0\n"
    assert read_head(tmp_path / "a", 1) == b"\0"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_a_writer_that_fails_leaves_what_was_there(tmp_path: Path) -> None:
    write_file(tmp_path / "a", "old")
    with pytest.raises(LookupError), replacing(tmp_path / "a") as temporary:
        _half(temporary)
    assert (tmp_path / "a").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("name", ["missing/a", "a\0b", "x" * 5000])
def test_a_place_that_cannot_be_written_is_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(OutputError, match="cannot be written") as caught:
        write_file(tmp_path / name, "")
    assert caught.value.file == str(tmp_path / name)


def test_what_is_too_large_is_not_read(tmp_path: Path) -> None:
    write_file(tmp_path / "a", "abc")
    with pytest.raises(ScenarioError, match="larger than the 2 bytes"):
        read_bytes(tmp_path / "a", 2, ScenarioError)
    with pytest.raises(ScenarioError, match="not a regular file"):
        read_bytes(tmp_path, 2, ScenarioError)


def _half(path: Path) -> None:
    path.write_text("half")
    raise LookupError
