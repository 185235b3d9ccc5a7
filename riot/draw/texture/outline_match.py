"""Match the outline that pieces make with the input's, between trunk corners that correspond (theory §9). Ours.

Every arc of one outline is matched with the arc of the other between the same two corners, monotonely, near points with
near points.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import shapely

from riot.draw.texture.tuning import (
    LEAST_MATCH_STEPS,
    MATCH_STEP,
    SLIVER_SHARE,
    SMOOTHING_REACH,
    STRETCH_COST,
    WARP_SPACING,
)
from riot.errors import RiotError
from riot.geometry.polyline import arc_length, at_length

if TYPE_CHECKING:
    from riot.types import FloatArray, IntArray

_STEPS = ((1, 1), (1, 2), (2, 1), (1, 3), (3, 1))
"""Steps (assembled, input) of a match: an arc is stretched against the other by three at most, and never stops."""


class WarpError(RiotError, ValueError):
    """Outlines between which no map can be made."""


def match_outlines(
    assembled: FloatArray, starts: IntArray, target: FloatArray, corners: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Match two outlines: points (k, 2) on ``assembled`` and (k, 2) on ``target``, the vertices of both among them.

    Arguments and errors as `riot.draw.texture.warp.make_warp`. Both run around once, counter-clockwise; between the
    points both outlines are straight.
    """
    lengths, around = arc_length(assembled), arc_length(target)
    at = np.asarray(shapely.line_locate_point(shapely.LinearRing(target), shapely.points(corners)))
    begin = np.concatenate([lengths[starts], [lengths[starts[0]] + lengths[-1]]])
    steps = np.mod(np.diff(np.concatenate([at, at[:1]])), around[-1])
    if len(at) == 1:
        steps[:] = around[-1]
    if abs(float(steps.sum()) - around[-1]) > 1e-9 * around[-1] or not (steps > 0.0).all():
        raise WarpError("the trunk's corners are not in order on the input's outline: no texture can follow them")
    end = at[0] + np.concatenate([[0.0], np.cumsum(steps)])
    s, u = [begin[:1]], [end[:1]]
    for k in range(len(starts)):
        count = max(LEAST_MATCH_STEPS, int(np.ceil(max(begin[k + 1] - begin[k], end[k + 1] - end[k]) / MATCH_STEP)))
        here = np.linspace(begin[k], begin[k + 1], count + 1)
        there = np.linspace(end[k], end[k + 1], count + 1)
        match = _aligned(at_length(assembled, here), at_length(target, there))
        s.append(here[1:])
        u.append(np.interp(match[1:], np.arange(count + 1), there))
    return _common(assembled, np.concatenate(s), target, np.concatenate(u))


def _aligned(a: FloatArray, b: FloatArray) -> FloatArray:
    """(k,) strictly increasing positions among b's k points for those of a, least in squared distance (dynamic
    programming over `_STEPS`), then smoothed; ends go to ends."""
    count = len(a)
    cost = ((a[:, None] - b[None]) ** 2).sum(axis=2)
    total = np.full((count, count), np.inf)
    choice = np.zeros((count, count), dtype=np.int8)
    total[0, 0] = 0.0
    for i in range(1, count):
        for kind, (di, dj) in enumerate(_STEPS):
            if i < di:
                continue
            way = 0.5 * (di + dj) * cost[i, dj:] + (di != dj) * STRETCH_COST
            reached = total[i - di, : count - dj] + way
            better = reached < total[i, dj:]
            total[i, dj:][better] = reached[better]
            choice[i, dj:][better] = kind
    i = j = count - 1
    knots = [(i, j)]
    while i > 0:
        di, dj = _STEPS[choice[i, j]]
        i, j = i - di, j - dj
        knots.append((i, j))
    here, there = np.array(knots[::-1], dtype=np.float64).T
    positions = np.interp(np.arange(count), here, there)
    # Mirrored about both ends, a moving mean leaves straight lines and the ends as they are.
    reach = min(SMOOTHING_REACH, count - 1)
    before = 2 * positions[0] - positions[reach:0:-1]
    after = 2 * positions[-1] - positions[-2 : -2 - reach : -1]
    padded = np.concatenate([before, positions, after])
    width = 2 * reach + 1
    return np.convolve(padded, np.full(width, 1.0 / width), mode="valid")


def _common(assembled: FloatArray, s: FloatArray, target: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points of both outlines at the vertices of either, given matched positions s and u, (k,), increasing."""
    lengths, around = arc_length(assembled), arc_length(target)
    own = np.sort(_unrolled(lengths[:-1], s[0], lengths[-1]))
    other = np.sort(_unrolled(around[:-1], u[0], around[-1]))
    from_own = np.column_stack([own, np.interp(own, s, u)])
    from_other = np.column_stack([np.interp(other, u, s), other])
    # Vertices of both that nearly match are matched: two points so close would only make slivers.
    nearest = np.abs(from_own[:, :1] - from_other[None, :, 0]).argmin(axis=0)
    close = np.abs(from_own[nearest, 0] - from_other[:, 0]) < SLIVER_SHARE * WARP_SPACING
    first = np.zeros(len(other), dtype=np.bool_)
    first[np.unique(np.where(close, nearest, -1 - np.arange(len(other))), return_index=True)[1]] = True
    joined = close & first
    from_own[nearest[joined], 1] = other[joined]
    both = np.concatenate([from_own, from_other[~joined]])
    both = both[np.lexsort((both[:, 1], both[:, 0]))]
    both[:, 1] = np.maximum.accumulate(both[:, 1])
    parts = np.diff(np.concatenate([both, both[:1] + np.array([lengths[-1], around[-1]])]), axis=0)
    keep = (parts > 1e-9).all(axis=1)
    both, parts = both[keep], parts[keep]
    pieces = np.maximum(1, np.ceil(parts.max(axis=1) / WARP_SPACING)).astype(np.int64)
    index = np.repeat(np.arange(len(both)), pieces)
    share = (np.arange(len(index)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[index]
    fine = both[index] + share[:, None] * parts[index]
    return at_length(assembled, fine[:, 0]), at_length(target, fine[:, 1])


def _unrolled(positions: FloatArray, first: float, period: float) -> FloatArray:
    return first + np.mod(positions - first, period)
