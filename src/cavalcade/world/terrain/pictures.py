"""Heights as brightness of a PNG picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cavalcade.files import read_bytes, read_head
from cavalcade.geometry import Array
from cavalcade.world._images import decode_png, png_size
from cavalcade.world.terrain.samples import Samples, check_sample_count

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

_HEAD = 64
_BYTES_PER_PIXEL = 16


def read_picture(path: Path) -> Samples:
    """Brightness 0 (black) to 1 (white) of a PNG of 8 or 16 bits; nan where it is transparent.

    Raises:
        MapError: Not such a picture, damaged or too large.
    """
    width, height = png_size(read_head(path, _HEAD), path)
    check_sample_count(height, width)
    content = read_bytes(path, _BYTES_PER_PIXEL * width * height + 1_000_000)
    return Samples(decode_png(content, _brightness, path)[::-1])


def _brightness(picture: Picture) -> Array:
    transparent = picture.info.get("transparency")
    if picture.mode.startswith("I"):  # 16 bits
        values = np.asarray(picture).astype(np.float64)
        seen = np.ones(values.shape, dtype=bool)
        if isinstance(transparent, int):
            seen = values != transparent
        return np.where(seen, values / 65535.0, np.nan)
    if transparent is None and picture.mode not in ("LA", "PA", "RGBA"):
        return np.asarray(picture.convert("L")).astype(np.float64) / 255.0
    full = picture.convert("RGBA")
    grey = np.asarray(full.convert("RGB").convert("L")).astype(np.float64) / 255.0
    return np.where(np.asarray(full.getchannel("A")) >= 128, grey, np.nan)
