"""Give the arcs of the dissection tree the detail of the swung arcs beside them, topology and leaves fixed (theory §8).

The middle lines of the partition round corners off and are wavy where straight lines should be. Both neighbours of a
tree arc know better: each has a section of its swung arc there. The two sections are matched, corners on corners and
linear between, so that two straight lines average to a straight line. The samples of the whole tree then take the
least-squares optimum of the Laplacian coordinates of the averages, junctions free. Where the result crosses itself or
loses area it is drawn back towards the middle lines, which always are a valid tree. Ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from riot.construction.tree import joined
from riot.construction.tree_match import TreeMatch
from riot.construction.tuning import (
    COINCIDENT_SAMPLES,
    COLLINEAR_DISTANCE,
    CROSSING_REACH,
    DISPLACEMENT_CAP_FACTOR,
    DRAW_BACK_PLATEAU,
    DRAW_BACK_ROUNDS,
    EDGE_CLEARANCE_SHARE,
    EVEN_SHARE,
    FIRST_DISPLACEMENT_CAP,
    JUNCTION_HOLD,
    LEAST_SAMPLE_DISTANCE,
)
from riot.geometry.polyline import simplify_open
from riot.kernels.detail import collisions, difference, solved
from riot.kernels.matching import along, at, corresponding
from riot.parameters import DetailParameters
from riot.types import BoolArray, FloatArray, IntArray
from riot.units import L_C


@dataclass(frozen=True, eq=False)
class Pull:
    """Where samples are drawn: to ``wanted`` (k, 2) with ``weights`` (k,)."""

    wanted: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class Detailed:
    """A tree with detail.

    Parameters
    ----------
    paths : list of (l, 2) float64
        The path around cell k, from corner k to corner k + 1.
    rounds : int
        How many rounds of drawing back it took; `DRAW_BACK_ROUNDS` if the middle lines stayed.
    loss : float
        The area that changes hands beyond that of the middle lines.
    """

    paths: list[FloatArray] = field(repr=False)
    rounds: int
    loss: float


def add_detail(
    plain: Sequence[FloatArray],
    arcs: Sequence[FloatArray],
    match: TreeMatch,
    parameters: DetailParameters,
    pull: Pull | None = None,
) -> Detailed:
    """Solve for the tree's samples; draw them back to the middle lines until they are a planar tree that loses little.

    ``plain`` are the paths (l, 2) around the cells along the middle lines, ``arcs`` the swung arcs (s, 2), both by
    trunk edge. ``pull`` draws samples elsewhere; then any loss of area is allowed. Ours (theory §8).
    """
    corners = np.array([arc[0] for arc in arcs])
    least = _losses(plain, arcs, parameters)
    limit = min(parameters.max_loss, parameters.max_share * least) if pull is None else np.inf
    best = _solved(match, arcs, parameters, pull, least, limit)
    free = ~match.fixed & (True if pull is None else pull.weights == 0.0)
    middle = _middle(match, parameters.step * L_C)
    away = np.hypot(*(middle - best).T)
    back = np.zeros(len(match.targets))
    cap = FIRST_DISPLACEMENT_CAP * float(away.max())
    for rounds in range(DRAW_BACK_ROUNDS):
        x = np.where(match.fixed[:, None], best, _inside(best + back[:, None] * (middle - best), corners))
        points, kept = _thinned(x, match.offsets)
        crossing = np.zeros(len(x), dtype=np.bool_)
        crossing[kept] = _crossings(points, match.ends, corners, parameters.clearance)
        paths = [joined(points, walk) for walk in match.walks]
        loss = _losses(paths, arcs, parameters) - least
        if not crossing.any() and loss <= limit:
            return Detailed(paths, rounds, loss)
        if crossing.any():
            distance = np.sqrt(((x[:, None] - x[crossing][None]) ** 2).sum(axis=2).min(axis=1))
            reach = CROSSING_REACH * parameters.step * L_C * 2.0**rounds
            back = np.maximum(back, np.clip(DRAW_BACK_PLATEAU - distance / reach, 0.0, 1.0))
        if loss > limit:
            cap *= DISPLACEMENT_CAP_FACTOR
            back = np.maximum(back, away**2 / (away**2 + cap**2))
        back = np.where(free, back, 0.0)
    return Detailed(list(plain), DRAW_BACK_ROUNDS, 0.0)


def _solved(
    match: TreeMatch,
    arcs: Sequence[FloatArray],
    parameters: DetailParameters,
    pull: Pull | None,
    least: float,
    limit: float,
) -> FloatArray:
    """(k, 2) the samples of the first accuracy whose loss over ``least`` is within the limit, else of least loss."""
    drawn = _junctions(match, parameters)
    if pull is not None:
        drawn = Pull(
            np.where(pull.weights[:, None] > 0.0, pull.wanted, drawn.wanted),
            np.where(pull.weights > 0.0, pull.weights, drawn.weights),
        )
    corners = np.array([arc[0] for arc in arcs])
    best, smallest = match.targets, np.inf
    for accuracy in parameters.accuracy:
        x = solved(
            match.targets,
            match.offsets,
            match.which,
            match.known,
            drawn.wanted,
            drawn.weights,
            _softness(match, accuracy, parameters),
            LEAST_SAMPLE_DISTANCE * parameters.step * L_C,
        )
        x = np.where(match.fixed[:, None], x, _inside(x, corners))
        points, _ = _thinned(x, match.offsets)
        loss = _losses([joined(points, walk) for walk in match.walks], arcs, parameters) - least
        if loss < smallest:
            best, smallest = x, loss
        # With pins all accuracies are tried: what is pinned must not cost more around it than it has to.
        if loss <= limit < np.inf:
            break
    return best


def _softness(match: TreeMatch, accuracy: float, parameters: DetailParameters) -> FloatArray:
    """(k,) weight of positions: between arcs that are apart a displacement costs no area."""
    apart = np.hypot(*(match.sides[0] - match.sides[1]).T) / (parameters.agreement * L_C)
    strong, weak = ((length * L_C) ** -4.0 for length in (accuracy, max(accuracy, parameters.reach)))
    return np.asarray(weak + strong / (1.0 + apart**2))


def _junctions(match: TreeMatch, parameters: DetailParameters) -> Pull:
    """Draw junctions to the mean of the arcs' ends there, but not far from where the partition has them."""
    pull = Pull(match.targets.copy(), np.zeros(len(match.targets)))
    ends: dict[int, list[tuple[int, FloatArray]]] = {}
    for k, arc in enumerate(match.tree):
        for node, row, partitioned in (
            (arc.start, match.offsets[k], arc.points[0]),
            (arc.end, match.offsets[k + 1] - 1, arc.points[-1]),
        ):
            if match.which[row] >= 0:
                ends.setdefault(node, []).append((int(row), partitioned))
    for node, meeting in ends.items():
        rows, partitioned = [row for row, _ in meeting], meeting[0][1]
        # In a gap between smooth arcs nothing tells better than the middle lines where they meet.
        step = match.targets[rows].mean(axis=0) - partitioned if node in match.cornered else np.zeros(2)
        size = float(np.hypot(*step))
        pull.wanted[rows] = partitioned + step * min(1.0, parameters.junction * L_C / max(size, COINCIDENT_SAMPLES))
        pull.weights[rows] = JUNCTION_HOLD * (parameters.reach * L_C) ** -3.0
    return pull


def _inside(x: FloatArray, corners: FloatArray) -> FloatArray:
    """(k, 2) points moved into a counter-clockwise convex polygon (n, 2), off its edges but at its corners."""
    moved = x.copy()
    near = np.sqrt(((x[:, None] - corners[None]) ** 2).sum(axis=2).min(axis=1))
    margin = np.minimum(EDGE_CLEARANCE_SHARE * near, EDGE_CLEARANCE_SHARE * L_C)
    for start, stop in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        ahead = (stop - start) / np.hypot(*(stop - start))
        inward = np.array([-ahead[1], ahead[0]])
        short = margin - (moved - start) @ inward
        moved += np.where(short > 0.0, short, 0.0)[:, None] * inward
    return moved


def _thinned(x: FloatArray, offsets: IntArray) -> tuple[list[FloatArray], IntArray]:
    """Every tree arc without its collinear samples, and which samples are kept."""
    kept = [first + simplify_open(x[first:last], COLLINEAR_DISTANCE) for first, last in pairwise(offsets.tolist())]
    return [x[rows] for rows in kept], np.concatenate(kept)


def _crossings(points: Sequence[FloatArray], ends: IntArray, corners: FloatArray, clearance: float) -> BoolArray:
    """(k,) which points of the tree's arcs are at a crossing of arcs, or of an arc and the trunk."""
    n = len(corners)
    edges = [corners[[k, (k + 1) % n]] for k in range(n)]
    around = np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1)
    offsets = np.concatenate([[0], np.cumsum([len(line) for line in [*points, *edges]])]).astype(np.int64)
    nodes = np.concatenate([ends, around])
    return collisions(np.concatenate([*points, *edges]), offsets, nodes, clearance)[: offsets[len(points)]]


def _losses(paths: Sequence[FloatArray], arcs: Sequence[FloatArray], parameters: DetailParameters) -> float:
    """Area that is in a cell or in its piece, not in both, summed."""
    return sum(difference(path, arc, parameters.lines) for path, arc in zip(paths, arcs, strict=True))


def _middle(match: TreeMatch, step: float) -> FloatArray:
    """(k, 2) where every sample is on the middle lines."""
    on_middle_lines = []
    for arc, (first, last) in zip(match.tree, pairwise(match.offsets.tolist()), strict=True):
        target = match.targets[first:last]
        lengths, middle_lengths = along(target), along(arc.points)
        positions = np.maximum.accumulate(corresponding(target, lengths, arc.points, step))
        positions = (1.0 - EVEN_SHARE) * positions + EVEN_SHARE * lengths * (middle_lengths[-1] / lengths[-1])
        on_middle_lines.append(at(arc.points, middle_lengths, positions))
    return np.concatenate(on_middle_lines)
