"""Ragged arrays: rows of different lengths in one array, with the offsets at which they begin (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.types import IntArray


def running(counts: npt.NDArray[Any]) -> IntArray:
    """(k + 1,) int64 offsets of rows with the lengths ``counts`` (k,): 0, then the running sums.

    >>> running(np.array([2, 0, 3]))
    array([0, 2, 2, 5])
    """
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def joined_offsets(offsets: Sequence[IntArray]) -> IntArray:
    """Offsets of the rows of several ragged arrays after these are concatenated.

    >>> joined_offsets([np.array([0, 2]), np.array([0, 1, 4])])
    array([0, 2, 3, 6])
    """
    return running(np.concatenate([np.zeros(0, dtype=np.int64), *(np.diff(starts) for starts in offsets)]))


def joined(stacks: Sequence[Any], name: str, dtype: npt.DTypeLike = np.float64) -> npt.NDArray[Any]:
    """The arrays called ``name`` of several objects as one; without objects an empty array of ``dtype``."""
    if not stacks:
        return np.zeros(0, dtype=dtype)
    return np.concatenate([getattr(stack, name) for stack in stacks])
