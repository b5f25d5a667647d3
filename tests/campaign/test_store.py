"""The folder of a campaign: nothing finished is lost, nothing foreign is touched."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from cavalcade.campaign.definition import Definition, define_campaign
from cavalcade.campaign.store import CORRUPT, Store
from cavalcade.campaign.table import LINES
from cavalcade.campaign.trial import failure_line
from cavalcade.errors import OutputError, RecordingError


def line(definition: Definition, index: int) -> dict[str, Any]:
    return failure_line(definition.trials[index], "arrived", "") | {"success": True}


@pytest.fixture
def half(tiny_plan: Definition, tmp_path: Path) -> Path:
    """A folder with trials 3, 1 and 2 in it."""
    with Store(tmp_path / "runs" / "a", tiny_plan) as store:
        for index in (3, 1, 2):
            store.append(line(tiny_plan, index))
    return tmp_path / "runs" / "a"


def ids(definition: Definition, *indices: int) -> list[str]:
    return [definition.trials[index].id for index in indices]


def test_lines_come_back_in_the_order_of_the_trials(tiny_plan: Definition, half: Path) -> None:
    with Store(half, tiny_plan, resume=True) as store:
        assert store.done == set(ids(tiny_plan, 1, 2, 3))
        store.append(line(tiny_plan, 0))
        assert [one["trial"] for one in store.lines()] == ids(tiny_plan, 0, 1, 2, 3)
    assert len((half / LINES).read_text().splitlines()) == 4
    assert sorted(os.listdir(half)) == ["campaign.json", LINES]


def test_a_folder_with_results_needs_resume(tiny_plan: Definition, half: Path) -> None:
    with pytest.raises(OutputError, match="holds a campaign; use --resume"):
        Store(half, tiny_plan)


def test_a_folder_with_other_things_is_refused(tiny_plan: Definition, tmp_path: Path) -> None:
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "thesis.tex").touch()
    with pytest.raises(OutputError, match="the folder is not empty; name another one"):
        Store(tmp_path / "b", tiny_plan)
    with pytest.raises(OutputError, match="holds no campaign to go on with"):
        Store(tmp_path / "b", tiny_plan, resume=True)
    assert os.listdir(tmp_path / "b") == ["thesis.tex"]
    with pytest.raises(OutputError, match="expected a folder, this is a file"):
        Store(tmp_path / "b" / "thesis.tex", tiny_plan)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"overrides": ["execution.timeout=20"]}, "was begun with other overrides (--set): none"),
        ({"seeds": 5}, "was begun with other values in suite tiny: worlds"),
        ({"seed": 5}, "was begun with other values in suite tiny: seed"),
        (
            {"overrides": ["planner.variant=published"]},
            "was begun with other values in suite tiny: variants",
        ),
    ],
)
def test_the_folder_of_another_campaign_is_refused(
    tiny: Path, tiny_plan: Definition, half: Path, changes: dict[str, Any], message: str
) -> None:
    before = (half / LINES).read_bytes()
    with pytest.raises(OutputError) as caught:
        Store(half, define_campaign(tiny, **changes), resume=True)
    assert message in str(caught.value)
    assert str(caught.value).endswith("; name another folder")
    assert (half / LINES).read_bytes() == before


def test_the_folder_of_another_suite_and_version(
    tiny: Path, tiny_plan: Definition, half: Path
) -> None:
    tiny.write_text(tiny.read_text().replace("suite: tiny", "suite: other"))
    with pytest.raises(OutputError, match="holds a campaign of suite tiny, not other"):
        Store(half, define_campaign(tiny), resume=True)
    said = json.loads((half / "campaign.json").read_text())
    said |= {"version": "0.0.1", "fingerprint": "older"}
    (half / "campaign.json").write_text(json.dumps(said))
    with pytest.raises(OutputError, match=r"was begun with version 0\.0\.1"):
        Store(half, tiny_plan, resume=True)
    (half / "campaign.json").write_text("{")
    with pytest.raises(RecordingError, match=r"campaign\.json: expected JSON"):
        Store(half, tiny_plan, resume=True)


def test_a_torn_last_line_is_dropped(tiny_plan: Definition, half: Path) -> None:
    whole = (half / LINES).read_bytes()
    (half / LINES).write_bytes(whole[:-40])
    said: list[str] = []
    with Store(half, tiny_plan, resume=True, warn=said.append) as store:
        assert store.done == set(ids(tiny_plan, 3, 1))
    assert said == [f"{half / LINES}: line 3: torn; its trial is repeated"]
    assert (half / LINES).read_bytes() == b"".join(whole.splitlines(keepends=True)[:2])
    assert not (half / CORRUPT).exists()


@pytest.mark.parametrize(
    "garbage",
    [
        b"\x00\xff\x00garbage\n",
        b"{}\n",
        b"[1, 2]\n",
        b"\n",
        b'{"trial": "tiny.9999.cavalcade", "outcome": "arrived", "success": true}\n',
        b'{"trial": NaN}\n',
    ],
)
def test_a_corrupt_line_is_set_aside(tiny_plan: Definition, half: Path, garbage: bytes) -> None:
    rows = (half / LINES).read_bytes().splitlines(keepends=True)
    (half / LINES).write_bytes(b"".join([rows[0], garbage, rows[2]]))
    said: list[str] = []
    with Store(half, tiny_plan, resume=True, warn=said.append) as store:
        assert store.done == set(ids(tiny_plan, 3, 2))
    assert len(said) == 1
    assert said[0].startswith(f"{half / LINES}: line 2: not a trial of this campaign; moved to ")
    assert (half / CORRUPT).read_bytes() == garbage
    assert (half / LINES).read_bytes() == rows[0] + rows[2]
    with Store(half, tiny_plan, resume=True, warn=said.append) as store:
        store.append(line(tiny_plan, 1))
    assert len(said) == 1


@pytest.mark.parametrize(
    "change",
    [
        {"success": "yes"},
        {"contacts": None},
        {"summary": []},
        {"seed": 7},
        {"variant": "published"},
        {"outcome": 3},
    ],
)
def test_a_line_that_is_not_whole_is_set_aside(
    tiny_plan: Definition, half: Path, change: dict[str, Any]
) -> None:
    rows = (half / LINES).read_bytes().splitlines(keepends=True)
    rows[1] = json.dumps(json.loads(rows[1]) | change).encode() + b"\n"
    (half / LINES).write_bytes(b"".join(rows))
    said: list[str] = []
    with Store(half, tiny_plan, resume=True, warn=said.append) as store:
        assert store.done == set(ids(tiny_plan, 3, 2))
    assert len(said) == 1
    assert (half / CORRUPT).read_bytes() == rows[1]


def test_a_line_may_name_files_that_are_no_text(tiny_plan: Definition, half: Path) -> None:
    odd = line(tiny_plan, 0) | {"detail": "no such file: \udcff.yaml"}
    with Store(half, tiny_plan, resume=True) as store:
        store.append(odd)
    with Store(half, tiny_plan, resume=True) as store:
        assert next(iter(store.lines())) == odd


def test_a_trial_that_stands_twice_counts_once(tiny_plan: Definition, half: Path) -> None:
    rows = (half / LINES).read_bytes().splitlines(keepends=True)
    (half / LINES).write_bytes(b"".join([*rows, rows[0]]))
    said: list[str] = []
    with Store(half, tiny_plan, resume=True, warn=said.append) as store:
        assert len(list(store.lines())) == 3
    assert "line 4" in said[0]
    assert "stands there twice" in said[0]


def test_two_campaigns_do_not_meet_in_one_folder(tiny_plan: Definition, half: Path) -> None:
    code = (
        "import sys; from cavalcade.campaign.store import locked; from pathlib import Path; "
        f"h = locked(Path({str(half)!r})); print('locked', flush=True); sys.stdin.read()"
    )
    other = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert other.stdin is not None
    assert other.stdout is not None
    try:
        assert other.stdout.readline() == "locked\n"
        with pytest.raises(OutputError, match="another campaign is at work in this folder"):
            Store(half, tiny_plan, resume=True)
    finally:
        other.stdin.close()
        other.wait(30)
        other.stdout.close()
    with Store(half, tiny_plan, resume=True) as store:
        assert len(store.done) == 3


def test_a_full_disk_loses_nothing(
    tiny_plan: Definition, half: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (half / LINES).read_bytes()
    with Store(half, tiny_plan, resume=True) as store:
        monkeypatch.setattr(os, "write", _full_after(100))
        with pytest.raises(OutputError) as caught:
            store.append(line(tiny_plan, 0))
        monkeypatch.undo()
    assert str(caught.value) == (
        f"{half / LINES}: cannot be written: No space left on device; "
        "the 3 trials so far are kept, go on with --resume"
    )
    assert (half / LINES).read_bytes() == before
    said: list[str] = []
    with Store(half, tiny_plan, resume=True, warn=said.append) as store:
        store.append(line(tiny_plan, 0))
        assert len(store.done) == 4
    assert not said


def _full_after(size: int) -> Any:
    """`os.write` on a disk with room for so many bytes."""
    real, room = os.write, [size]

    def write(handle: int, data: bytes) -> int:
        if not room[0]:
            raise OSError(28, "No space left on device")
        written = real(handle, data[: room[0]])
        room[0] -= written
        return written

    return write


def test_a_folder_that_cannot_be_made_leaves_nothing(tiny_plan: Definition, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be written"):
        Store(tmp_path / "file" / "a" / "b", tiny_plan)
    before = sorted(os.listdir(tmp_path))
    with pytest.raises(OutputError):
        Store("/proc/nothing/a", tiny_plan)
    assert sorted(os.listdir(tmp_path)) == before
