"""The greatest memory of a process without the pages of the files that it maps."""

from __future__ import annotations

import threading
from pathlib import Path
from types import TracebackType

SECONDS_BETWEEN_LOOKS = 0.02


class OwnMemory:
    """Looks at the anonymous resident memory of this process, again and again while entered (Linux)."""

    def __init__(self) -> None:
        self.peak_mb = 0.0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> OwnMemory:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        self._thread.join()

    def _watch(self) -> None:
        while True:
            self.peak_mb = max(self.peak_mb, anonymous_mb())
            if self._over.wait(SECONDS_BETWEEN_LOOKS):
                return


def anonymous_mb() -> float:
    """Anonymous resident memory of this process now, in MiB; nan where the system does not tell."""
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    except OSError:
        return float("nan")
    return next((int(line.split()[1]) / 2**10 for line in lines if line.startswith("RssAnon")), float("nan"))
