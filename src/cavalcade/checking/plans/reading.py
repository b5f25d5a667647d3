"""`plan.npz` from disk: arrays and nothing that could run code."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import RecordingError

_MOST_BYTES = 2_000_000_000

Arrays = dict[str, NDArray[Any]]


def read_plan(path: str | Path) -> Arrays:
    """All arrays of a `plan.npz`, by name, as they are.

    Raises:
        RecordingError: The file is missing, damaged, too large or holds other things than plain
            arrays.
    """
    path = Path(path)
    if not path.is_file():
        raise RecordingError("there is no such file", file=path)
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > _MOST_BYTES:
            raise RecordingError(f"{size} bytes of arrays are too many", file=path)
        with np.load(path, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except RecordingError:
        raise
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise RecordingError(f"cannot be read: {reason}", file=path) from error
    except Exception as error:
        # A damaged archive surfaces as whatever the unpacking tripped over.
        raise RecordingError(f"not a readable NPZ file ({error})", file=path) from error
