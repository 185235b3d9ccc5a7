"""The memory of artifacts whose files are mapped."""

from __future__ import annotations

import mmap
from typing import Any

import numpy as np

from pipeline.store.artifact import Artifact


def let_go(artifact: Artifact) -> None:
    """Let the system have the memory of an artifact of a mapped file; what is needed of it again is read again."""
    for array in artifact.arrays.values():
        base: Any = array
        while isinstance(base, np.ndarray):
            base = base.base
        if isinstance(base, memoryview) and isinstance(base.obj, mmap.mmap):
            base.obj.madvise(mmap.MADV_DONTNEED)
            return
