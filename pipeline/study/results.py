"""The results of finished runs of one collection, side by side, for studies of what a policy chooses. Ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.errors import StartError
from pipeline.study.finished import StudiedRun
from pipeline.tables.record import RECORD
from riot.errors import needs_extra
from riot.geometry.polyline import signed_area
from riot.parameters import LikenessParameters
from riot.scores.descriptor import Descriptor, descriptor, outline_descriptor
from riot.scores.likeness import DescriptorIndex, near_duplicates
from riot.types import FloatArray, IntArray

with needs_extra("mine"):
    import shapely

OTHERS = "Folders of other finished runs of the same collection, such as one with select=global, to stand beside."
"""Meaning of the parameter that names them."""


@dataclass(frozen=True, eq=False)
class Likenesses:
    """The shapes of a collection by number: descriptors, clusters of near-duplicates, things (classes or clusters)."""

    index: DescriptorIndex
    cluster: IntArray
    thing: IntArray
    likeness: LikenessParameters

    @classmethod
    def of(cls, finished: StudiedRun) -> Likenesses:
        """Those of a run, described anew: a millisecond each."""
        settings = finished.config.likeness
        index = DescriptorIndex.build([descriptor(shape) for shape in finished.shapes])
        cluster = near_duplicates(index, settings.near_duplicate, mirrored=settings.mirrored)
        numbers: dict[str, int] = {}
        thing = [
            numbers.setdefault(name or f"\0{number}", len(numbers))
            for name, number in zip(finished.classes, cluster.tolist(), strict=True)
        ]
        return cls(index, cluster, np.array(thing, dtype=np.int64), settings)

    def nearest(self, described: Descriptor, own: int) -> int:
        """The shape nearest to a description of shape ``own``, which counts only if no other is the same thing."""
        alone = int((self.thing == self.thing[own]).sum()) == 1
        exclude = [] if alone else [own]
        numbers, _ = self.index.nearest(described, 1, exclude=exclude, mirrored=self.likeness.mirrored)
        return int(numbers[0])


def chosen_rows(finished: StudiedRun) -> list[dict[str, Any]]:
    """The rows of `transforms` that a run chose and that have a transform, in order of rank; raises `StartError`."""
    rows = [row for row in finished.table("transforms").to_pylist() if row["chosen"] and row["file"]]
    if not rows:
        raise StartError(f"{finished.mined.folder}: no transform; this study needs a run that made some")
    return sorted(rows, key=lambda row: int(row["rank"]))


def outline(row: dict[str, Any], side: str) -> FloatArray:
    """(m, 2) the outline that the pieces make as ``p`` or ``q``."""
    return np.asarray(shapely.from_wkb(row[f"outline_{side}"]).exterior.coords, dtype=np.float64)[:-1]


def described_outline(row: dict[str, Any], side: str) -> Descriptor:
    """The descriptor of that outline, which crosses itself where the paper's method makes it."""
    points = outline(row, side)
    return outline_descriptor(points if signed_area(points) > 0 else points[::-1])


def beside(finished: StudiedRun, folders: Sequence[str]) -> dict[str, StudiedRun]:
    """The run and those in ``folders``, each by its policy, and its folder where two have the same.

    Raises `StartError` for a folder without a finished run, or of another collection.
    """
    runs = {_policy(finished): finished}
    for folder in map(Path, folders):
        if not (folder / RECORD).exists():
            raise StartError(f"others: no finished run in {folder}")
        other = StudiedRun.open(folder)
        if other.mined.digests != finished.mined.digests:
            raise StartError(f"others: {folder} is a run of another collection than {finished.mined.folder}")
        name = _policy(other)
        runs[name if name not in runs else f"{name}, {folder}"] = other
    return runs


def _policy(finished: StudiedRun) -> str:
    method = finished.config.construct.method
    return finished.config.select.policy + ("" if method == "exact" else f", {method}")
