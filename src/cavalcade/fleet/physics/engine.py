"""Loading MuJoCo when it is needed."""

from __future__ import annotations

from typing import Any

from cavalcade.errors import InputError


def load_mujoco() -> Any:
    """The module `mujoco`.

    Raises:
        InputError: It is not installed; the line says how to install it.
    """
    try:
        import mujoco
    except ImportError:
        raise InputError(
            "MuJoCo is not installed: pip install 'cavalcade[physics]'", key="physics"
        ) from None
    return mujoco
