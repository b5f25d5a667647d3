"""Heights as brightness of a PNG picture."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from cavalcade.errors import MapError
from cavalcade.files import read_bytes, read_head
from cavalcade.geometry import Array
from cavalcade.world.terrain.samples import Samples, check_sample_count

SIGNATURE = b"\x89PNG\r\n\x1a\n"
_HEAD = 64
_BYTES_PER_PIXEL = 16


def read_picture(path: Path) -> Samples:
    """Brightness 0 (black) to 1 (white) of a PNG of 8 or 16 bits; nan where it is transparent.

    Raises:
        MapError: Not such a picture, damaged or too large.
    """
    head = read_head(path, _HEAD)
    if len(head) < 24 or not head.startswith(SIGNATURE) or head[12:16] != b"IHDR":
        raise MapError("the header of the PNG picture is damaged")
    width, height = (int.from_bytes(head[k : k + 4], "big") for k in (16, 20))
    check_sample_count(height, width)
    content = read_bytes(path, _BYTES_PER_PIXEL * width * height + 1_000_000)
    return Samples(_decode(content)[::-1])


def _decode(content: bytes) -> Array:
    from PIL import Image

    try:
        with Image.open(io.BytesIO(content), formats=["PNG"]) as picture:
            picture.load()
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
    except MemoryError:
        raise
    except Exception:
        # The decoder answers damaged pictures with errors of about ten unrelated types.
        raise MapError("the PNG picture is truncated or damaged") from None
