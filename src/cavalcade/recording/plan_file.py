"""`plan.npz`: a team plan as arrays that any reader of NumPy files can use.

The same plan gives the same bytes: entries in a fixed order with a fixed date, where
`numpy.savez` would write the time of day.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.npyio import NpzFile
from numpy.typing import NDArray

from cavalcade.errors import RecordingError
from cavalcade.files import replacing
from cavalcade.geometry import Array
from cavalcade.geometry.trajectory import Trajectory

_DATE = (1980, 1, 1, 0, 0, 0)
_UNIX = 3
_KEYS = ("t", "position", "velocity", "yaw", "phase", "footholds")

FILE = "plan.npz"


def write_plan(
    path: str | Path,
    trajectories: Sequence[Trajectory | None],
    footholds: Sequence[Array],
) -> Path:
    """Write trajectories and footholds of robots 0, 1, ..., see `plan_arrays`.

    Args:
        path: The new file; one that is there is replaced.
        trajectories: One per robot, map frame.
        footholds: `(M, 6)` each.

    Returns:
        The file written.

    Raises:
        OutputError: It cannot be written.
    """
    target = Path(path)
    with (
        replacing(target) as temporary,
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive,
    ):
        for name, array in plan_arrays(trajectories, footholds).items():
            entry = zipfile.ZipInfo(f"{name}.npy", _DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = _UNIX
            entry.external_attr = 0o644 << 16
            content = io.BytesIO()
            np.lib.format.write_array(content, array, allow_pickle=False)
            archive.writestr(entry, content.getvalue())
    return target


def plan_arrays(
    trajectories: Sequence[Trajectory | None], footholds: Sequence[Array]
) -> dict[str, NDArray[Any]]:
    """The arrays of a plan file by name; arguments as of `write_plan`.

    Per robot k: `t_k (T,)` s, `position_k (T, 3)` m, `velocity_k (T, 3)` m/s, `yaw_k (T,)` rad,
    `phase_k (T,)` and `footholds_k (M, 6)`; a robot without a trajectory has none of them.
    """
    arrays = {}
    for robot, (trajectory, feet) in enumerate(zip(trajectories, footholds, strict=True)):
        if trajectory is not None:
            motion = [getattr(trajectory, field.name) for field in fields(Trajectory)]
            for key, values in zip(_KEYS, (*motion, np.reshape(feet, (-1, 6))), strict=True):
                kind = np.int8 if key == "phase" else np.float64
                arrays[f"{key}_{robot}"] = np.ascontiguousarray(values, kind)
    return arrays


def read_plan(path: str | Path) -> tuple[dict[int, Trajectory], dict[int, Array]]:
    """Trajectories and footholds `(M, 6)` by robot, from a folder that `plan` left or the file.

    Raises:
        RecordingError: It is missing, damaged or no plan.
    """
    file = Path(path)
    if file.is_dir():
        file = file / FILE
    if not file.is_file():
        raise RecordingError("there is no such plan", file=file)
    trajectories: dict[int, Trajectory] = {}
    footholds: dict[int, Array] = {}
    try:
        with _opened(file) as arrays:
            robots = sorted(int(name[2:]) for name in arrays.files if name.startswith("t_"))
            for robot in robots:
                parts = [arrays[f"{key}_{robot}"] for key in _KEYS]
                trajectories[robot] = Trajectory(*parts[:5])
                footholds[robot] = parts[5]
    except Exception as error:
        # Damaged archives are answered with errors of zipfile, zlib, struct, numpy and more.
        raise RecordingError(f"not a plan: {error}", file=file) from None
    return trajectories, footholds


def _opened(file: Path) -> NpzFile:
    # From memory: NumPy leaves a file open that begins like an archive and is none.
    arrays = np.load(io.BytesIO(file.read_bytes()), allow_pickle=False)
    if not isinstance(arrays, NpzFile):
        raise ValueError("expected an archive of arrays")
    return arrays
