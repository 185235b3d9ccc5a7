"""Trunks of a batch's shapes as arrays, for the stages that make or read them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipeline.store.artifact import AnyArray, Artifact
from riot import scores

if TYPE_CHECKING:
    from riot.scores.trunks import Trunks

CORNERS = ("vertices", "edges", "alphas", "thetas")
"""Fields of `Trunks` with an entry for each corner."""


def no_trunks() -> Trunks:
    """The trunks of a shape that failed before: none."""
    return scores.trunks.Trunks(np.zeros(1, np.int64), np.empty(0, np.int32), *(np.empty(0) for _ in range(4)))


def pack_trunks(stack: Sequence[Trunks | None]) -> dict[str, AnyArray]:
    """Trunks of the shapes of a batch as arrays: ``trunk_offsets`` (k+1,) int64 into the concatenated `Trunks`."""
    empty = no_trunks()
    present = [trunks if trunks is not None else empty for trunks in stack]
    counts = np.array([len(trunks) for trunks in present], dtype=np.int64)
    sizes = np.concatenate([np.empty(0, np.int64), *(np.diff(trunks.offsets) for trunks in present)])
    arrays: dict[str, AnyArray] = {
        "trunk_offsets": np.concatenate([np.zeros(1, np.int64), np.cumsum(counts)]),
        "offsets": np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes)]).astype(np.int64),
    }
    for name in empty.to_arrays():
        if name != "offsets":
            columns = [trunks.to_arrays()[name] for trunks in present]
            arrays[name] = np.concatenate([empty.to_arrays()[name], *columns])
    return arrays


def unpack_trunks(artifact: Artifact, index: int) -> Trunks:
    """The trunks of the shape at ``index`` of a batch; none where there is no shape."""
    arrays = artifact.arrays
    first, last = int(arrays["trunk_offsets"][index]), int(arrays["trunk_offsets"][index + 1])
    low, high = int(arrays["offsets"][first]), int(arrays["offsets"][last])
    # Copies: compiled kernels would compile a second time for read-only arrays.
    return scores.trunks.Trunks(
        offsets=arrays["offsets"][first : last + 1] - low,
        areas=np.array(arrays["areas"][first:last]),
        **{name: np.array(arrays[name][low:high]) for name in CORNERS},
    )
