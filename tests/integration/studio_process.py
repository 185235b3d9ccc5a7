"""The studio as a process of its own, for tests in a browser: started, killed, and started again."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

HOUSE = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 2L2 0L4 2V5H0Z"/></svg>'
KITE = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 3L-2 6L0 8L2 6Z"/></svg>'


class StudioProcess:
    """A running studio; ``address`` has the token."""

    def __init__(self, folder: Path, *more: str) -> None:
        """Start it, and wait until it says where it is."""
        command = [sys.executable, "-m", "pipeline.cli.main", "studio", "--no-browser", "--folder", str(folder), *more]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert "http://" in line, line
        self.address = line.split()[-1]
        self.port = str(urlsplit(self.address).port)

    def end(self, how: signal.Signals = signal.SIGINT) -> None:
        """End it as Ctrl-C does, or as told."""
        self.process.send_signal(how)
        self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()


@contextlib.contextmanager
def studio(folder: Path, *more: str) -> Iterator[StudioProcess]:
    """A studio while it is needed."""
    started = StudioProcess(folder, *more)
    try:
        yield started
    finally:
        started.end()


def pictures(folder: Path) -> tuple[Path, Path]:
    """Two pictures as files."""
    paths = folder / "house.svg", folder / "kite.svg"
    for path, text in zip(paths, (HOUSE, KITE), strict=True):
        path.write_text(text, encoding="utf-8")
    return paths
