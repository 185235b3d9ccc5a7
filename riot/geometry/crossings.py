"""Refuse outlines that cross themselves so often that their regions would fill the memory. Ours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from riot.types import FloatArray

_MAX_CROSSINGS = 20_000
"""Pairs of edges that may meet, in addition to `_MEETINGS` for each edge. Ours: each crossing is a vertex of a
region."""

_MEETINGS = 50
"""Meetings allowed for each edge: with itself, its neighbours, and those of copies that lie on it. Ours."""

_PAIRS_AT_ONCE = 2_000_000
"""Greatest number of pairs of edges that are tested together. Ours: it bounds the memory."""


class TangleError(Exception):
    """A drawing that would take more time or memory than any outline is worth."""


def refuse_tangles(rings: Sequence[FloatArray]) -> None:
    """Raise `TangleError` when the edges of closed rings, (m, 2) each, meet too often."""
    if not rings:
        return
    ends = np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in rings])
    edges = shapely.linestrings(ends)
    most = _MEETINGS * len(edges) + _MAX_CROSSINGS
    tree, met = shapely.STRtree(edges), 0
    step = max(1, _PAIRS_AT_ONCE // len(edges))
    for start in range(0, len(edges), step):
        met += tree.query(edges[start : start + step], predicate="intersects").shape[1]
        if met > most:
            raise TangleError(f"{len(edges)} edges meet more than {most} times")
