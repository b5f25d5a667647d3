"""Kernels on disk are found by what they were made of, and by nothing else."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

HELPER = """
from typing import NamedTuple

from cavalcade.kernels import subroutine

FACTOR = {factor}


class Pair(NamedTuple):
    {first}: float
    {second}: float


@subroutine
def scaled(x):  # {comment}
    return {body}
"""

KERNEL = """
{empty}from helper import Pair, scaled

from cavalcade.kernels import kernel


@kernel
def total(pair):
    return scaled(pair.a) - pair.b
"""

CALL = """
from helper import Pair
from caller import total

print(total(Pair(a=2.0, b=1.0)), sum(total.stats.cache_hits.values()))
"""

PLAIN = {"factor": 3.0, "first": "a", "second": "b", "comment": "", "body": "FACTOR * x"}


@pytest.fixture
def call(tmp_path: Path):
    """Call the kernel in a process of its own; what it gave and how often it was on disk."""

    def called(empty: str = "", **changed: object) -> tuple[float, int]:
        (tmp_path / "helper.py").write_text(HELPER.format(**PLAIN | changed))
        (tmp_path / "caller.py").write_text(KERNEL.format(empty=empty))
        environment = os.environ | {
            "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        done = subprocess.run(
            [sys.executable, "-c", CALL],
            cwd=tmp_path, env=environment, capture_output=True, text=True, check=True,
        )  # fmt: skip
        value, hits = done.stdout.split()
        return float(value), int(hits)

    return called


def test_what_did_not_change_is_not_compiled_again(call) -> None:
    assert call() == (5.0, 0)
    assert call() == (5.0, 1)
    assert call(comment="another comment") == (5.0, 1)


@pytest.mark.parametrize(
    ("changed", "value"),
    [
        ({"body": "FACTOR + x"}, 4.0),
        ({"factor": 4.0}, 7.0),
        ({"first": "b", "second": "a"}, 5.0),  # fields of the same types in another order
    ],
)
def test_code_elsewhere_was_taken_for_unchanged(call, changed, value) -> None:
    """numba looks at the date of the kernel's own file alone."""
    assert call() == (5.0, 0)
    assert call(**changed) == (value, 0)
    assert call(**changed) == (value, 1)


def test_what_an_older_version_left_ended_the_process(call, tmp_path: Path) -> None:
    """The records of cached signatures are looked up by module and name."""
    assert call() == (5.0, 0)
    for index in (tmp_path / "cache").rglob("*.nbi"):
        index.write_bytes(index.read_bytes().replace(b"helper", b"gone__"))
    assert call() == (5.0, 0)
    assert call() == (5.0, 1)
    for index in (tmp_path / "cache").rglob("*.nbi"):
        index.write_bytes(index.read_bytes()[:-20])
    assert call() == (5.0, 0)
