"""From a place to its files."""

from __future__ import annotations

from pathlib import Path

from pipeline.store.filesystem.base import Files, Place
from pipeline.store.filesystem.local import LocalFiles


def open_files(place: Place) -> Files:
    """The files below a place; raises `pipeline.errors.StartError` when what it takes is not installed."""
    if isinstance(place, Path):
        return LocalFiles(place)
    from pipeline.store.filesystem.objects import open_objects  # takes fsspec: only who needs it waits for it

    return open_objects(place)
