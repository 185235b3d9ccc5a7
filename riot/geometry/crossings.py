"""Outlines that cross themselves so often that their regions would fill the memory, found before that. Ours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from riot.types import FloatArray

_MAX_CROSSINGS = 20_000
"""Pairs of edges that may meet, beside `_MEETINGS` for each edge: every crossing is a vertex of the regions."""

_MEETINGS = 50
"""An edge meets itself and its neighbours, and as many again for each copy that lies upon it."""

_AT_ONCE = 2_000_000
"""Pairs of edges that are looked at together, at most."""


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
    step = max(1, _AT_ONCE // len(edges))
    for start in range(0, len(edges), step):
        met += tree.query(edges[start : start + step], predicate="intersects").shape[1]
        if met > most:
            raise TangleError(f"{len(edges)} edges meet more than {most} times")
