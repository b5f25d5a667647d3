"""Where a scenario begins: an empty world, a shipped one, a file or an upload."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cavalcade.errors import InputError
from cavalcade.scenario import scenario_descriptions
from cavalcade.studio.build.bench import Bench
from cavalcade.studio.build.draft import EMPTY
from cavalcade.studio.build.edits import with_world
from cavalcade.studio.build.upload_limit import refuse_early
from cavalcade.studio.build.uploads import ACCEPTED, Upload, check_size

CHOOSE, EMPTY_WORLD = "Choose …", "Empty world"


class StartPart:
    """The folder Start."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        gui, shipped = bench.gui, scenario_descriptions()
        hint = "Takes the place of what is built; Undo brings it back."
        choices = (CHOOSE, EMPTY_WORLD, *shipped)
        self._shipped = gui.add_dropdown("Begin with", choices, hint=hint)
        bench.fields.bind(self._shipped, lambda: CHOOSE, self._choose)
        self._upload = gui.add_upload_button(
            "Upload a map, terrain or scenario",
            mime_type=ACCEPTED,
            hint="At most 64 MB. Of a map both files, one after the other: .yaml and picture.",
            icon="upload",
            color="gray",
        )
        bench.fields.button(self._upload, lambda _: self.take())
        refuse_early(bench.session.server, self._too_large)
        self._file = gui.add_text(
            "Own file",
            "",
            hint="A scenario's file, or the folder of a run, on the studio's computer.",
        )
        open_file = gui.add_button("Open file", icon="folder-open", color="gray")
        bench.fields.button(open_file, lambda _: self._open(self._file.value.strip()))

    def _choose(self, name: str) -> None:
        if name == EMPTY_WORLD:
            self._bench.draft.replace(EMPTY)
        elif name != CHOOSE:
            self._bench.draft.load(name)
        self._bench.session.stage.frame_team()

    def _open(self, name: str) -> None:
        if not name:
            raise InputError("expected the name of a scenario's file", key="Own file")
        self._bench.draft.load(Path(name).expanduser())
        self._bench.session.stage.frame_team()

    def take(self) -> None:
        """Use the file that has come."""
        bench, file = self._bench, self._upload.value
        found = bench.uploads.take(file.name, file.content)
        if found.wanted is not None:
            bench.session.say(f"{found.path.name} is here; {found.wanted}")
            return
        if found.kind == "scenario":
            bench.draft.load(found.path)
        else:
            self._use(found)
        bench.session.say(f"{found.path.name} is in use now")
        bench.session.stage.frame_team()

    def _too_large(self, client: Any, name: str, size: int) -> None:
        self._bench.fields.attempt(lambda: check_size(name, size), client)

    def _use(self, found: Upload) -> None:
        """Take an uploaded world for the ground."""
        draft = self._bench.draft
        draft.replace(with_world(draft, dict(found.world or {})))
