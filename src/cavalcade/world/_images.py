"""Map pictures: PGM and PNG to 8-bit grey and back, row 0 at the top.

Sizes are checked in the header, before memory is taken for the picture. PNG is Pillow's, but for
colours of 16 bits, which that one cuts to 8: these are pypng's. PGM is read here: Pillow takes
pixel by pixel what is text or has another largest grey than 255, rounds it otherwise, and lets pass
what exceeds the largest grey.
"""

from __future__ import annotations

import io
import re
import warnings
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cavalcade.errors import MapError
from cavalcade.files import read_bytes, read_head
from cavalcade.geometry import Array
from cavalcade.world.occupancy import check_cell_count

Pixels = NDArray[np.uint8]

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_GAP = rb"(?:\s|#[^\r\n]*[\r\n])+"
_PGM_HEADER = re.compile(
    rb"P([25])" + _GAP + rb"(\d{1,9})" + _GAP + rb"(\d{1,9})" + _GAP + rb"(\d{1,5})\s"
)
_HEAD = 65_536
"""Bytes in which a header must have ended."""

_LUMINANCE = (0.299, 0.587, 0.114)
"""Of red, green and blue (ITU-R BT.601)."""

_BYTES_PER_PIXEL = 16
"""More than any picture needs: text with spaces and comments, or 16 bits in four channels."""


def read_grey(path: Path) -> tuple[Pixels, Pixels | None]:
    """Brightness `(height, width)` of a PGM or PNG picture, and its opacity if it has any.

    The format is told by the content, not by the file's name. Colours become luminance
    (ITU-R BT.601); more or less than 8 bits are scaled to 0..255.

    Raises:
        MapError: Not such a picture, truncated, damaged, or too large.
    """
    head = read_head(path, _HEAD)
    if head.startswith(PNG_SIGNATURE):
        width, height = png_size(head, path)
    elif head[:2] in (b"P2", b"P5"):
        _, width, height, _ = (int(part) for part in _pgm_header(head, path).groups())
    else:
        raise MapError("expected a PGM (P2, P5) or PNG picture", file=path)
    check_cell_count(height, width, file=str(path), key="picture")
    content = read_bytes(path, _BYTES_PER_PIXEL * width * height + 16 * _HEAD)
    if head.startswith(PNG_SIGNATURE):
        grey, alpha = decode_png(content, path)
        if grey.dtype == np.uint16:
            grey = ((grey.astype(np.int64) + 128) // 257).astype(np.uint8)
        return grey.astype(np.uint8, copy=False), alpha
    return _decode_pgm(content, path), None


def encode_pgm(grey: Pixels) -> bytes:
    """A binary PGM (P5) of the brightness `(height, width)`."""
    height, width = grey.shape
    return b"P5\n%d %d\n255\n" % (width, height) + grey.tobytes()


def encode_png(grey: Pixels, alpha: Pixels | None = None) -> bytes:
    """A grey PNG of the brightness `(height, width)`; RGBA if an opacity is given.

    RGBA instead of grey with alpha, because GraphicsMagick, which Nav2 reads with, loses the
    alpha of the latter.
    """
    from PIL import Image

    if alpha is None:
        picture = Image.fromarray(grey)
    else:
        picture = Image.fromarray(np.stack([grey, grey, grey, alpha], axis=2))
    stream = io.BytesIO()
    picture.save(stream, format="PNG")
    return stream.getvalue()


def _pgm_header(content: bytes, path: Path) -> re.Match[bytes]:
    """The header with its four numbers: format, width, height, largest grey."""
    header = _PGM_HEADER.match(content)
    if header is None:
        raise MapError("the header of the PGM picture is damaged", file=path)
    return header


def _decode_pgm(content: bytes, path: Path) -> Pixels:
    header = _pgm_header(content, path)
    kind, width, height, largest = (int(part) for part in header.groups())
    if not 1 <= largest <= 65535:
        raise MapError(f"the largest grey must be 1 to 65535, not {largest}", file=path)
    count = width * height
    body = memoryview(content)[header.end() :]
    values: NDArray[np.integer]
    if kind == 5:
        sample = np.dtype(np.uint8 if largest < 256 else ">u2")
        size = count * sample.itemsize
        if len(body) < size:
            raise MapError(f"the picture is truncated: {len(body)} of {size} bytes", file=path)
        values = np.frombuffer(body, dtype=sample, count=count)
    else:
        text = re.sub(rb"#[^\r\n]*", b"", body)
        if text.translate(None, b"0123456789 \t\r\n\v\f"):
            raise MapError("the picture holds something else than numbers", file=path)
        values = np.fromstring(text.decode("ascii"), dtype=np.int64, sep=" ")[:count]
        if len(values) < count:
            raise MapError(f"the picture is truncated: {len(values)} of {count} pixels", file=path)
    if values.max() > largest:
        raise MapError(f"a grey value exceeds the largest one, {largest}", file=path)
    if largest != 255:
        values = (values.astype(np.int64) * 510 + largest) // (2 * largest)
    return values.astype(np.uint8).reshape(height, width)


def png_size(head: bytes, path: Path) -> tuple[int, int]:
    """Width and height from the first chunk."""
    if len(head) < 24 or not head.startswith(PNG_SIGNATURE) or head[12:16] != b"IHDR":
        raise MapError("the header of the PNG picture is damaged", file=path)
    return int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")


def decode_png(content: bytes, path: Path) -> tuple[NDArray[np.uint8 | np.uint16], Pixels | None]:
    """Brightness `(height, width)` of a PNG in its 8 or 16 bits, and its opacity if it has any."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(content), formats=["PNG"]) as picture:
            picture.load()
            transparent = picture.info.get("transparency")
            if picture.mode.startswith("I"):  # 16-bit grey
                values = np.asarray(picture).astype(np.uint16)
                if not isinstance(transparent, int):
                    return values, None
                return values, np.where(values == transparent, 0, 255).astype(np.uint8)
            if transparent is None and picture.mode not in ("LA", "PA", "RGBA"):
                return np.asarray(picture.convert("L")), None
            full = picture.convert("RGBA")
            grey = np.asarray(full.convert("RGB").convert("L"))
            return grey, np.asarray(full.getchannel("A"))
    except MemoryError:
        raise
    except Exception:
        # The decoder answers damaged pictures with errors of about ten unrelated types.
        raise MapError("the PNG picture is truncated or damaged", file=path) from None


def has_deep_colours(head: bytes) -> bool:
    """Whether a PNG has 16 bits in each of several channels."""
    return len(head) > 25 and head[24] == 16 and head[25] in (2, 4, 6)


def decode_deep_colours(content: bytes, path: Path) -> tuple[Array, NDArray[np.bool_]]:
    """Brightness `(height, width)`, 0 to 65535, of such a PNG, and where it is transparent."""
    import png

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            width, height, rows, _ = png.Reader(bytes=content).asDirect()
            table = np.stack([np.asarray(row) for row in islice(rows, height)])
    except MemoryError:
        raise
    except Exception:
        # As Pillow's, the decoder's errors are of many types.
        raise MapError("the PNG picture is truncated or damaged", file=path) from None
    if len(table) != height:
        raise MapError("the PNG picture is truncated or damaged", file=path)
    channels = table.reshape(height, width, -1).astype(np.float64)
    count = channels.shape[2]
    grey = channels[..., 0] if count < 3 else channels[..., :3] @ _LUMINANCE
    transparent = channels[..., -1] < 32768 if count in (2, 4) else np.zeros(grey.shape, bool)
    return grey, transparent
