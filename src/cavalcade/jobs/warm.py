"""Whether the compiled kernels are there already."""

from __future__ import annotations

import os
from pathlib import Path

import cavalcade


def kernels_are_cached(part: str = "fleet", kernel: str = "ideal.advance_team") -> bool:
    """Whether an earlier run has left compiled kernels, wherever numba keeps them.

    A guess for the user's information only: after an update some kernels may be compiled anew.

    Args:
        part: The package to look at.
        kernel: Module and name of one of its kernels that every job uses; `*` for any.
    """
    package = Path(cavalcade.__file__).parent
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named:
        folders = [Path(named)]
    else:
        folders = [package / part / "__pycache__"]
        if not os.access(package, os.W_OK):
            folders.append(Path.home() / ".cache" / "numba")
    return any(_holds(folder, kernel) for folder in folders)


def _holds(folder: Path, kernel: str) -> bool:
    return folder.is_dir() and any(folder.rglob(f"{kernel}-*.nbi"))
