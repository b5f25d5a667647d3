"""What of a run is taken along: its replay, a picture of the view, its scenario."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from cavalcade.drawing.replay.page import write_replay
from cavalcade.errors import InputError
from cavalcade.geometry import Array
from cavalcade.jobs.output_folder import REPLAY, SCENARIO
from cavalcade.recording import read_recording
from cavalcade.studio.build.draft import Draft
from cavalcade.studio.study.results import Result

WIDTH = 3840
"""Of a picture, pixels: 32 cm at 300 dots per inch."""

_DPI = 300
_PATIENCE = 30.0
"""Longest that a browser may take for a picture, s."""


def replay_page(result: Result) -> bytes:
    """The replay as it lies in the folder, else made anew.

    Raises:
        CavalcadeError: There is none, and none can be made.
    """
    there = result.folder / REPLAY
    try:
        if there.is_file():
            return there.read_bytes()
    except OSError:
        pass  # gone or not readable any more: made anew
    if result.recording is None:
        raise InputError(f"has no {REPLAY}; cavalcade plan makes one", file=result.folder)
    with tempfile.TemporaryDirectory(prefix="cavalcade-") as folder:
        page = write_replay(
            Path(folder) / REPLAY,
            result.scenario,
            result.start,
            recording=read_recording(result.folder),
            summary=result.summary,
        )
        return page.read_bytes()


def scenario_text(result: Result) -> bytes:
    """The scenario as YAML that runs anywhere on this machine: names of files are absolute.

    Raises:
        InputError: It is there no more.
    """
    draft = Draft()
    draft.load(result.folder / SCENARIO)
    return draft.export().encode()


def picture(client: Any, background: tuple[int, int, int]) -> bytes:
    """What a browser shows of the scene, as PNG at print resolution.

    Raises:
        InputError: The browser does not answer.
    """
    aspect = float(client.camera.aspect) or 16.0 / 9.0
    height = round(WIDTH / aspect)
    try:
        seen = client.get_render(height, WIDTH, transport_format="png", timeout=_PATIENCE)
    except Exception as error:  # it has gone, or is too slow; viser raises errors of its own
        raise InputError(f"the browser has given no picture: {error}") from None
    content = io.BytesIO()
    Image.fromarray(_on(np.asarray(seen), background)).save(content, "PNG", dpi=(_DPI, _DPI))
    return content.getvalue()


def _on(seen: Array, background: tuple[int, int, int]) -> Array:
    """A picture with transparency on a colour."""
    if seen.shape[2] == 3:
        return seen
    share = seen[..., 3:].astype(float) / 255.0
    mixed = seen[..., :3] * share + np.array(background) * (1.0 - share)
    return np.rint(mixed).astype(np.uint8)
