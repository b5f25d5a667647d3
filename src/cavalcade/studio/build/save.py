"""The scenario's name, its file as a download, and a copy in the studio's folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cavalcade.files import make_folders, write_file
from cavalcade.studio.build.bench import Bench
from cavalcade.studio.build.packing import download_of
from cavalcade.studio.build.uploads import clean_name
from cavalcade.studio.fields import WAIT


class SavePart:
    """The folder Name and file."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        gui, fields = bench.gui, bench.fields
        name = gui.add_text("Name", "", hint="Of the scenario; also of its file.")
        fields.bind(name, lambda: bench.draft.data["name"], self._rename, WAIT)
        download = gui.add_button(
            "Download YAML",
            icon="download",
            hint="A file for “cavalcade run”; with uploaded files a ZIP that holds them, too.",
        )
        fields.button(download, self._download)
        save = gui.add_button(
            "Save in the studio's folder", icon="device-floppy", color="gray", hint=str(self.folder)
        )
        fields.button(save, lambda event: self._save(event.client))

    @property
    def folder(self) -> Path:
        """Where scenarios are saved."""
        return self._bench.session.folder / "scenarios"

    def _rename(self, name: str) -> None:
        self._bench.draft.set("name", name)

    def _download(self, event: Any) -> None:
        name, content = download_of(self._bench.draft, self._bench.uploads.folder)
        self._bench.session.download(event, name, content)

    def _save(self, client: Any) -> None:
        draft = self._bench.draft
        text = draft.export(self.folder)
        make_folders(self.folder)
        file = self.folder / f"{clean_name(draft.data['name'] + '.yaml')}"
        write_file(file, text)
        self._bench.session.say(f"Saved as {file}", client=client)
