"""Loading MuJoCo when it is needed."""

from __future__ import annotations

from typing import Any

from cavalcade.errors import InputError


def load_mujoco() -> Any:
    """The module `mujoco`.

    Its warnings are counted in `MjData.warning`; it does not write them to a file `MUJOCO_LOG.TXT`
    in the working directory besides, unless somebody else has said what is to become of them.

    Raises:
        InputError: It is not installed; the line says how to install it.
    """
    try:
        import mujoco
    except ImportError:
        raise InputError(
            "MuJoCo is not installed: pip install 'cavalcade[physics]'", key="physics"
        ) from None
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(lambda _: None)
    return mujoco
