"""How much of each trunk edge other pieces cover, so that the edge's own piece loses it, with derivatives (ours).

The partition gives a point to the piece of smallest signed distance. Where that is not the edge's own, contact is lost
there; a share that grows with the difference of the two distances lets a maximisation see it coming.
"""

from __future__ import annotations

import numpy as np

from riot.construction.tuning import CONTACT_INSET, CONTACT_RAMP, CONTACT_SAMPLES
from riot.kernels.pulls import nearest_arcs
from riot.types import FloatArray, IntArray


def contact_cost(
    arcs: FloatArray, offsets: IntArray, spare: float, weight: float
) -> tuple[float, FloatArray, FloatArray]:
    """What lost contact costs, its gradient by the arcs' points (s, 2), and the covered share of every edge (n,).

    ``arcs`` (s, 2) with ``offsets`` (n + 1,) run round a convex trunk, as they are swung into it; their end points are
    its corners. The cost is ``weight`` times the squares of what shares exceed ``spare``.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> arcs = np.stack([square[::-1], np.roll(square[::-1], -1, axis=0)], axis=1).reshape(8, 2)
    >>> contact_cost(arcs, np.arange(0, 9, 2), 0.15, 0.5)[0]
    0.0
    """
    n = len(offsets) - 1
    first, last = arcs[offsets[:-1]], arcs[offsets[1:] - 1]
    edge = np.repeat(np.arange(n), CONTACT_SAMPLES)
    at = ((np.arange(CONTACT_SAMPLES) + 0.5) / CONTACT_SAMPLES)[None, :, None]
    inwards = CONTACT_INSET * (first.mean(axis=0) - 0.5 * (first + last))
    samples = (((1.0 - at) * first[:, None] + at * last[:, None]) + inwards[:, None]).reshape(-1, 2)
    distances, segments, shares = nearest_arcs(samples, edge, arcs, offsets)
    lead = (distances[:, 0] - distances[:, 1]) / CONTACT_RAMP
    covered = np.clip(lead, 0.0, 1.0).reshape(n, -1).mean(axis=1)
    beyond = np.maximum(covered - spare, 0.0)
    gradient = np.zeros_like(arcs)
    rows = np.flatnonzero((lead > 0.0) & (lead < 1.0) & (beyond[edge] > 0.0))
    if len(rows) == 0:
        return weight * float(beyond @ beyond), gradient, covered
    k = edge[rows]
    share_at = at[0, rows % CONTACT_SAMPLES]
    for column, sign in ((0, 1.0), (1, -1.0)):
        segment, share = segments[rows, column], shares[rows, column][:, None]
        distance = distances[rows, column]
        away = samples[rows] - (1.0 - share) * arcs[segment] - share * arcs[segment + 1]
        factor = 2.0 * sign * weight / (CONTACT_RAMP * CONTACT_SAMPLES) * beyond[k]
        pull = np.where(distance != 0.0, factor / np.where(distance != 0.0, distance, 1.0), 0.0)[:, None] * away
        for point, part in (
            (segment, share - 1.0),
            (segment + 1, -share),
            (offsets[k], 1.0 - share_at),
            (offsets[k + 1] - 1, share_at),
        ):
            np.add.at(gradient, point, part * pull)
    return weight * float(beyond @ beyond), gradient, covered
