"""Files that a study writes beside its table, figures and page."""

from __future__ import annotations

from pathlib import Path

from pipeline.store import write_atomically
from pipeline.study.finished import Finished


def write_beside(finished: Finished, study: str, name: str, content: bytes) -> Path:
    """Write a file into the folder of a study of a run; returns its path."""
    path = finished.mined.folder / "study" / study / name
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, content)
    return path
