"""A draft as a file to take away, with the uploaded files that it uses."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cavalcade.errors import ScenarioError
from cavalcade.studio.build.draft import Draft, names_of, text_of, with_names
from cavalcade.studio.build.uploads import clean_name
from cavalcade.yaml_text import parse_yaml

_NAMING = ("image", "file", "x", "y")
"""Keys by which descriptions of maps and terrain name other files."""


def download_of(draft: Draft, uploads: Path) -> tuple[str, bytes]:
    """Name and content of the file to download.

    Uploaded files go with it in a ZIP: they may be gone when the studio has ended.

    Args:
        uploads: The folder of uploaded files.

    Raises:
        ScenarioError: The scenario is not finished.
    """
    if draft.scenario is None:
        raise ScenarioError(draft.error or "is not finished", key="download")
    name = clean_name(draft.data["name"] + ".yaml").removesuffix(".yaml")
    files = uploaded_files(draft.data, uploads)
    if not files:
        return f"{name}.yaml", draft.export().encode()
    used = {str(file) for file in files}
    data = with_names(draft.data, lambda one: Path(one).name if one in used else one)
    own = f"{name}.yaml"
    if any(file.name == own for file in files):
        own = f"{name}-scenario.yaml"
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(f"{name}/{own}", text_of(data))
        for file in files:
            archive.write(file, f"{name}/{file.name}")
    return f"{name}.zip", packed.getvalue()


def uploaded_files(data: Mapping[str, Any], uploads: Path) -> list[Path]:
    """Files in the folder of uploads that a scenario needs, also through others."""
    found: list[Path] = []
    waiting = [Path(name) for name in names_of(data)]
    while waiting:
        file = waiting.pop(0)
        if file.parent != uploads or file in found or not file.is_file():
            continue
        found.append(file)
        if file.suffix in (".yaml", ".yml"):
            said = parse_yaml(file.read_bytes(), file=file)
            named = said if isinstance(said, dict) else {}
            waiting += [uploads / str(named[key]) for key in _NAMING if named.get(key)]
    return found
