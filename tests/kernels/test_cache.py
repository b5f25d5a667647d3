"""Kernels on disk are found by what they were made of, and by nothing else."""

from __future__ import annotations

import importlib
import linecache
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.target_extension import cpu_target, jit_registry

from cavalcade.kernels import kernel
from cavalcade.kernels.cache import _Files

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


@subroutine
def tripled(x):
    return 3.0 * x


chosen = {chosen}
"""

KERNEL = """
{empty}from helper import Pair, chosen

from cavalcade.kernels import kernel


@kernel
def total(pair):
    return chosen(pair.a) - pair.b
"""

CALL = """
from helper import Pair
from caller import total

print(total(Pair(a=2.0, b=1.0)), sum(total.stats.cache_hits.values()))
"""

PLAIN = {
    "chosen": "scaled",
    "factor": 3.0,
    "first": "a",
    "second": "b",
    "comment": "",
    "body": "FACTOR * x",
}


def _write(folder: Path, empty: str, changed: dict[str, object]) -> None:
    (folder / "helper.py").write_text(HELPER.format(**PLAIN | changed))
    (folder / "caller.py").write_text(KERNEL.format(empty=empty))


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Call the kernel, imported anew; what it gave and how often it was on disk."""
    # numba looks at the environment again when it compiles, and takes what it says if it changed.
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    numba.config.reload_config()
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.syspath_prepend(tmp_path)

    def called(empty: str = "", **changed: object) -> tuple[float, int]:
        _write(tmp_path, empty, changed)
        importlib.invalidate_caches()
        linecache.clearcache()
        try:
            helper, caller = (importlib.import_module(name) for name in ("helper", "caller"))
            value = caller.total(helper.Pair(a=2.0, b=1.0))
            return value, sum(caller.total.stats.cache_hits.values())
        finally:
            for name in ("helper", "caller"):
                sys.modules.pop(name, None)

    yield called
    monkeypatch.undo()
    numba.config.reload_config()


@pytest.fixture
def call_apart(tmp_path: Path):
    """The same in a process of its own."""

    def called() -> tuple[float, int]:
        _write(tmp_path, "", {})
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
    assert call(empty="\n\n\n") == (5.0, 1)  # numba names its files by the line


@pytest.mark.parametrize(
    ("changed", "value"),
    [
        ({"body": "FACTOR + x"}, 4.0),
        ({"factor": 4.0}, 7.0),
        ({"first": "b", "second": "a"}, 5.0),  # fields of the same types in another order
        ({"chosen": "tripled"}, 5.0),  # another name for one of two functions
    ],
)
def test_code_elsewhere_was_taken_for_unchanged(call, changed, value) -> None:
    """numba looks at the date of the kernel's own file alone."""
    assert call() == (5.0, 0)
    assert call(**changed) == (value, 0)
    assert call(**changed) == (value, 1)


def test_what_an_older_version_left_ended_the_process(call_apart, tmp_path: Path) -> None:
    """The records of cached signatures are looked up by module and name."""
    assert call_apart() == (5.0, 0)
    for index in (tmp_path / "cache").rglob("*.nbi"):
        index.write_bytes(index.read_bytes().replace(b"helper", b"gone__"))
    assert call_apart() == (5.0, 0)
    assert call_apart() == (5.0, 1)
    for index in (tmp_path / "cache").rglob("*.nbi"):
        index.write_bytes(index.read_bytes()[:-20])
    assert call_apart() == (5.0, 0)


def test_two_processes_kept_their_code_in_one_file(tmp_path: Path) -> None:
    """numba writes the index first and numbers the data."""
    one, other = (_Files(str(tmp_path), "kernel", "stamp") for _ in range(2))
    save = one._save_data
    one._save_data = lambda name, data: (other.save("int64", "of int64"), save(name, data))
    one.save("float64", "of float64")
    for files in (one, other, _Files(str(tmp_path), "kernel", "stamp")):
        assert files.load("float64") == "of float64"
        assert files.load("int64") == "of int64"
    assert _Files(str(tmp_path), "kernel", "another stamp").load("int64") is None


def test_folders_that_cannot_be_written(monkeypatch: pytest.MonkeyPatch) -> None:
    @kernel
    def double(x):
        return 2.0 * x

    def refuse(*_: object) -> None:
        raise PermissionError

    for name in ("_save_index", "_save_data", "_load_index"):
        monkeypatch.setattr(_Files, name, refuse)
    assert double(2.0) == 4.0


def test_threads_that_compile_at_once() -> None:
    """While a kernel is compiled, numba's own decorator is another one."""

    def fresh():
        @kernel
        def sums(n):
            return np.zeros(n).sum() + np.ones((n, n)).max()

        return sums

    kernels = [fresh() for _ in range(8)]
    before = jit_registry[cpu_target]
    with ThreadPoolExecutor(8) as threads:
        assert list(threads.map(lambda each: each(3), kernels)) == [1.0] * 8
    assert jit_registry[cpu_target] is before
