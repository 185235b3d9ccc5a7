"""Construct on conjugate trunks as the paper does; the pieces do not tile exactly (paper §4.3, theory §8)."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from riot.construction.laplacian.contact import TrunkArcs
from riot.construction.laplacian.phases import close_gaps, part_overlaps, scale_arcs
from riot.construction.laplacian.residual import Residual
from riot.construction.tuning import MOST_EDIT_ROUNDS, MOST_EDIT_STEPS, POINT_SPACING, RESIDUAL_TOLERANCE
from riot.geometry.polyline import edge_lengths
from riot.kernels.coverage import swung_arcs
from riot.parameters import ConstructParameters
from riot.transform.pose import rotate
from riot.transform.transform import Piece, Transform
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from riot.construction.plan import ConstructionPlan


def construct_laplacian(plan: ConstructionPlan, parameters: ConstructParameters) -> Transform:
    """Construct the paper's transform on the trunks of a plan (paper §4.3).

    Arcs follow their trunks by similarity, from the outlines' trunk vertices; the plan's own arcs are not used. Pieces
    overlap and leave gaps, so that the certificate fails, and they may cross themselves where a neighbour has squeezed
    them; `riot.construction.laplacian.residual.residuals` tells how much. The bounds are those of an exact
    construction.

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> from riot.construction import alternatives
    >>> plan = alternatives(house, kite)[0]
    >>> construct_laplacian(plan, ConstructParameters()).certificate().passed  # it never is exact
    False
    """
    pair = plan.pair
    below, _ = tile(pair.outline_p, pair.trunk_p, plan.trunk_q, parameters)
    above, _ = tile(pair.outline_q, pair.trunk_q[::-1], plan.trunk_p[::-1], parameters)
    n = len(plan.trunk_p)
    lengths = 0.5 * (edge_lengths(plan.trunk_p) + edge_lengths(plan.trunk_q))
    pieces = []
    for i, length in enumerate(lengths.tolist()):
        # Corner k of P's trunk read backwards is corner n − 1 − k: arc n − 2 − i runs from corner i + 1 to corner i.
        lower, upper = below[i], above[(n - 2 - i) % n]
        ends = np.array([[0.0, 0.0], [length, 0.0]])
        pieces.append(Piece(length, _carried(lower, ends), _carried(upper, ends[::-1])))
    return plan.assembled(pieces, pair.outline_p[pair.trunk_p], pair.outline_q[pair.trunk_q])


def tile(
    outline: FloatArray, vertices: IntArray, trunk: FloatArray, parameters: ConstructParameters
) -> tuple[list[FloatArray], list[Residual]]:
    """Swing the arcs of one outline into the other's trunk, and make them tile it as far as they do.

    ``outline`` (m, 2) is counter-clockwise, ``vertices`` (n,) are its trunk's, counter-clockwise, and ``trunk`` (n, 2)
    the other's corners in that order, clockwise. Returns the arcs, arc i from corner i to corner i + 1, and the
    residuals: of the swung arcs, of the scaled ones, and after each round. The best round's arcs are returned.
    """
    trunk = np.ascontiguousarray(trunk)
    swung = np.empty((len(outline) + len(trunk), 2))
    offsets = np.empty(len(trunk) + 1, dtype=np.int64)
    swung_arcs(np.array(outline), np.ascontiguousarray(vertices), trunk, swung, offsets)
    dense = [_dense(swung[start:stop]) for start, stop in pairwise(offsets.tolist())]
    for k, arc in enumerate(dense):
        arc[0], arc[-1] = trunk[k], trunk[(k + 1) % len(trunk)]
    residuals = [TrunkArcs.of(trunk, dense).residual(parameters.lines)]
    arcs = TrunkArcs.of(trunk, scale_arcs(trunk, dense))
    residuals.append(arcs.residual(parameters.lines))
    best, least = _copied(arcs), residuals[-1].total
    for _ in range(MOST_EDIT_ROUNDS):
        if residuals[-1].total < RESIDUAL_TOLERANCE:
            break
        # What has been stretched needs points again: an edge across another piece has none that lies in it.
        arcs = TrunkArcs.of(trunk, [_dense(arcs.arc(i)) for i in range(len(arcs))])
        steps = part_overlaps(arcs, MOST_EDIT_STEPS) + close_gaps(arcs, MOST_EDIT_STEPS)
        residuals.append(arcs.residual(parameters.lines))
        gain = least - residuals[-1].total
        if gain > 0.0:
            best, least = _copied(arcs), residuals[-1].total
        if steps == 0 or gain < RESIDUAL_TOLERANCE:
            break
    return best, residuals


def _copied(arcs: TrunkArcs) -> list[FloatArray]:
    return [arcs.arc(i) for i in range(len(arcs))]


def _dense(arc: FloatArray) -> FloatArray:
    """An arc with points between its own, evenly, so that all are closer than `POINT_SPACING`."""
    steps = np.diff(arc, axis=0)
    counts = np.maximum(1, np.ceil(np.hypot(*steps.T) / POINT_SPACING)).astype(np.int64)
    position = np.concatenate(
        [k + np.arange(count) / count for k, count in enumerate(counts.tolist())] + [[len(counts)]]
    )
    whole = np.arange(len(arc))
    dense: FloatArray = np.column_stack([np.interp(position, whole, arc[:, axis]) for axis in (0, 1)])
    return dense


def _carried(arc: FloatArray, ends: FloatArray) -> FloatArray:
    """Move an arc (m, 2) rigidly so that its ends lie at ``ends`` (2, 2), exactly."""
    chord, edge = arc[-1] - arc[0], ends[1] - ends[0]
    moved: FloatArray = rotate(arc - arc[0], math.atan2(edge[1], edge[0]) - math.atan2(chord[1], chord[0])) + ends[0]
    moved[[0, -1]] = ends
    return moved
