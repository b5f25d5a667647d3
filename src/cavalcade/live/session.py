"""What a navigation leaves in a folder: begun once robots are driven, finished when it ends."""

from __future__ import annotations

from pathlib import Path

from cavalcade.errors import CavalcadeError, OutputError
from cavalcade.geometry import Array
from cavalcade.jobs.live_folder import finish_recording, record_live
from cavalcade.jobs.running import JobResult
from cavalcade.live.team_file import Team
from cavalcade.recording.live_writer import LiveRecording
from cavalcade.world import OccupancyMap


class SessionFolder:
    """The folder of a team's session, with the same files as that of any run.

    Args:
        team: Who is driven.
        out: The folder, missing or empty.
        force: Replace what an earlier session left there.

    Attributes:
        out: The folder.
        recording: A sink of frames, from `begin` on.

    Raises:
        OutputError: The folder holds something, and `force` is not said.
    """

    def __init__(self, team: Team, out: Path, force: bool = False) -> None:
        self.out = out
        self._team, self._force = team, force
        self.recording: LiveRecording | None = None
        if not force and out.is_dir() and any(out.iterdir()):
            raise OutputError(f"{out}: the folder is not empty; name another one or use --force")

    def begin(self, area: OccupancyMap, poses: Array) -> LiveRecording:
        """Begin the folder of robots that stand at `poses` `(N, 3)` on a map; once is enough.

        Raises:
            OutputError: It cannot be written to.
        """
        if self.recording is None:
            team = self._team
            self.recording = record_live(
                self.out,
                name=team.name,
                models=team.models,
                starts=poses,
                area=area,
                rate=team.rate,
                backend=team.fleet,
                formation=team.formation,
                names=team.names,
                unitree=team.go2s,
                force=self._force,
            )
        return self.recording

    def close(self) -> None:
        """Write the recording's end, if anybody was driven."""
        if self.recording is not None:
            self.recording.close()

    def finish(self) -> JobResult | None:
        """Close the recording and make the rest of the folder; None if nobody was driven.

        Raises:
            CavalcadeError: It cannot be made of what was recorded; the recording stays.
        """
        if self.recording is None:
            return None
        self.recording.close()
        if self.recording.problem:
            raise OutputError(self.recording.problem)
        try:
            return finish_recording(self.out)
        except CavalcadeError as error:
            raise error.at(file=error.file or self.out) from None
