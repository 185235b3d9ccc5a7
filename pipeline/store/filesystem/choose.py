"""Open the files below a location, whichever file system holds it."""

from __future__ import annotations

from pathlib import Path

from pipeline.store.filesystem.base import Files
from pipeline.store.filesystem.local import LocalFiles
from pipeline.store.filesystem.objects import open_objects
from pipeline.store.location import Location


def open_files(location: Location) -> Files:
    """The files below a location; raises `pipeline.errors.StartError` when what it takes is not installed."""
    if isinstance(location, Path):
        return LocalFiles(location)
    return open_objects(location)
