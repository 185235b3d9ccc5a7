"""The studio of a running server: its sessions, its workers, and the collection if one is open."""

from __future__ import annotations

import asyncio
from pathlib import Path

from riot.errors import FormatError
from studio.live.session import LiveSession
from studio.session.folder import SessionFolder, is_name, new_folder, newest
from studio.work.collection import Listing, list_collection
from studio.work.warm import answer_once
from studio.work.workers import Workers


class Studio:
    """Sessions by name in a folder of the user's data."""

    def __init__(self, root: Path, run: Path | None = None) -> None:
        """Open the studio; ``run`` is the folder of a finished run."""
        self.root, self.run_folder = root, run
        self.workers = Workers()
        self._listing: Listing | None = None
        self._open: dict[str, LiveSession] = {}
        self._warming: list[asyncio.Task[None]] = []

    def warm(self) -> None:
        """Start the workers and make them ready, before they are needed; called in the event loop."""
        for worker in (self.workers.live, self.workers.background):
            self._warming.append(asyncio.create_task(worker.run(answer_once)))
        if self.run_folder is not None:
            self._warming.append(asyncio.create_task(self._open_collection(self.run_folder)))

    async def listing(self) -> Listing | None:
        """The collection, when it is read; None if none is open."""
        if self.run_folder is None:
            return None
        if self._listing is None:
            await self._open_collection(self.run_folder)
        return self._listing

    async def _open_collection(self, folder: Path) -> None:
        self._listing = await self.workers.background.run(list_collection, folder)

    def session(self, name: str) -> LiveSession:
        """The session of this name; KeyError if there is none."""
        if name not in self._open:
            if not is_name(name) or not (self.root / name).is_dir():
                raise KeyError(name)
            self._open[name] = LiveSession(SessionFolder(self.root / name), self.workers, self.run_folder)
        return self._open[name]

    def new(self) -> LiveSession:
        """A new session."""
        return self.session(new_folder(self.root).name)

    def folders(self) -> list[SessionFolder]:
        """All sessions, the one that changed last first."""
        return newest(self.root)

    def current(self) -> str:
        """The session that a new tab shows: the one that changed last, or a new one."""
        folders = self.folders()
        return folders[0].name if folders else self.new().folder.name

    def names(self, name: str) -> tuple[str | None, str | None]:
        """The names of a session's two inputs; None where there is none, or it cannot be read."""
        try:
            return self.session(name).input_names
        except (KeyError, FormatError):
            return None, None

    def close(self) -> None:
        """End all work."""
        for session in self._open.values():
            session.jobs.stop_all()
        for task in self._warming:
            task.cancel()
        self.workers.close()
