"""Reading artifacts that are wanted again and again: each small one is read, and its digest checked, once."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable

from pipeline.store.artifact import Artifact

SMALL = 2**17
"""Bytes of arrays up to which an artifact is kept: those of single pairs are; batches of shapes and blocks are not."""

MOST = 4096
"""So many artifacts are kept at most: with documents of some 30 kB, a tenth of a gigabyte."""


class ArtifactReader:
    """Artifacts by stage and key, of which the small ones that were used last are kept."""

    def __init__(self, get: Callable[[str, str], Artifact]) -> None:
        """``get`` reads an artifact from the store; its errors pass."""
        self._get = get
        self._kept: OrderedDict[tuple[str, str], Artifact] = OrderedDict()

    def __call__(self, stage: str, key: str) -> Artifact:
        """The artifact of a stage with this key."""
        artifact = self._kept.pop((stage, key), None)
        if artifact is None:
            artifact = self._get(stage, key)
            if sum(array.nbytes for array in artifact.arrays.values()) > SMALL:
                return artifact
        self._kept[stage, key] = artifact
        if len(self._kept) > MOST:
            self._kept.popitem(last=False)
        return artifact
