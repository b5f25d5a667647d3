"""`import cavalcade`: quick, and every public name is there."""

from __future__ import annotations

import subprocess
import sys

import pytest

import cavalcade
from cavalcade.errors import CavalcadeError


def test_importing_it_imports_nothing_heavy() -> None:
    code = (
        "import sys, cavalcade; "
        "heavy = {'numpy', 'numba', 'scipy', 'matplotlib', 'pydantic', 'yaml', 'typer'}; "
        "sys.exit(', '.join(sorted(heavy & set(sys.modules))) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", cavalcade.__all__)
def test_every_public_name_is_there(name: str) -> None:
    assert getattr(cavalcade, name) is not None
    assert name in dir(cavalcade)


def test_the_list_can_be_read() -> None:
    assert dir(cavalcade) == sorted(cavalcade.__all__)
    assert {"run", "plan", "check", "register_model"} <= set(dir(cavalcade))
    assert not [name for name in dir(cavalcade) if name.startswith("_")]
    assert cavalcade.__version__


def test_other_names_are_not() -> None:
    with pytest.raises(AttributeError, match="attribute teleport"):
        _ = cavalcade.teleport


def test_errors_are_one_family() -> None:
    assert issubclass(cavalcade.ScenarioError, cavalcade.InputError)
    assert issubclass(cavalcade.OutputError, CavalcadeError)
