"""Ingest: pictures, vector files and sample definitions become shapes."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path, PurePath
from typing import Any

from pipeline.datasets.item import SOURCE, Item, open_item
from pipeline.datasets.sample import PREFIX
from pipeline.stages.items import ErrorRow, attempt, pack_shapes
from pipeline.store.artifact import Artifact
from riot.parameters import ShapeParameters


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Sequence[Item]) -> Artifact:
    """One batch of items → `pipeline.stages.items.pack_shapes` arrays, and a row for each failure."""
    (settings,) = parameters
    assert isinstance(settings, ShapeParameters)
    errors: list[ErrorRow] = []
    for item in spec:
        check_unchanged(item)
    shapes = [
        attempt(index, lambda item=item: open_item(item, settings), errors)  # type: ignore[misc]
        for index, item in enumerate(spec)
    ]
    for row in errors:
        row["message"] = _without_path(row["message"], str(spec[row["index"]].source))
    return Artifact(pack_shapes(shapes), {"errors": errors})


def _without_path(message: str, source: str) -> str:
    return message.replace(source, SOURCE).replace(PurePath(source).name, SOURCE)


def check_unchanged(item: Item) -> None:
    """Raise RuntimeError when a file is not what the plan was made of: its key would name something else."""
    if item.source.startswith(PREFIX):
        return
    if hashlib.sha256(Path(item.source).read_bytes()).hexdigest() != item.digest:
        raise RuntimeError(f"{item.name}: the file changed while the run went on; start the run again")
