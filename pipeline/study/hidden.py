"""Exact pairs to hide in a collection: generate them, draw them, and look for their trunks among candidates."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from pipeline.study.waves import deformed
from riot.geometry.polyline import TOUCH, arc_length, edge_lengths
from riot.geometry.shape import Shape
from riot.geometry.silhouette import mask_shape
from riot.groundtruth.limits import PairLimits
from riot.groundtruth.pairs import ExactPair, Topology, exact_pair
from riot.kernels.segments import inside_shares
from riot.kernels.simplify import TIE
from riot.parameters import TrunkParameters
from riot.scores.edges import exterior_areas
from riot.scores.reversibility import cut_off, reversibility
from riot.scores.trunks import Trunks
from riot.scores.vertices import congruency, convex_points, passes_visibility, sparse_points
from riot.types import BoolArray, FloatArray, IntArray
from riot.units import D_C, L_C

SEED = 4711
"""Seed before the first pair's, so that every study hides the same pairs."""

KINDS: tuple[tuple[Topology, bool], ...] = tuple(itertools.product(("star", "binary"), (False, True)))
LEAST_PIECE, LEAST_EDGE = 0.01, L_C / TrunkParameters().spacing
"""Pairs with a smaller exterior piece or a shorter trunk edge are not hidden: no candidate trunk is like theirs."""
NEAR = L_C / 25
"""A trunk whose every corner is so near to the true one counts as the true trunk: a little over half the spacing of
the sparse points."""
NARROW = PairLimits(
    corner_tolerance=0.0,
    corner_distance=100.0,
    least_trunk_angle=math.radians(25),
    greatest_trunk_angle=math.radians(172),
    least_hinge_angle=math.radians(40),
    greatest_hinge_angle=math.radians(340),
    least_area=LEAST_PIECE,
    least_depth=0.05,
    greatest_arc=0.5,
)
"""Limits of pairs that are hard to find: hinges anywhere, shallow pieces (ours)."""
PIXELS, FINER, MARGIN = 256, 4, 8
"""Side of a picture in pixels; supersampling per side; empty pixels at the border (ours: as MPEG-7's pictures)."""


@dataclass(frozen=True, eq=False)
class Hidden:
    """One shape of an exact pair, drawn: its name, its pair's number, and the true trunk in the shape's frame.

    ``corners`` (n, 2) run counter-clockwise; those of the pair's second shape in reverse of the corresponding order.
    """

    pair: int
    shape: Shape
    corners: FloatArray


@dataclass(frozen=True, eq=False)
class HiddenPair:
    """An exact pair and how it was drawn by lot."""

    n: int
    topology: Topology
    curved: bool
    seed: int
    exact: ExactPair
    p: Hidden
    q: Hidden


def hide(count: int, pieces: Sequence[int], deform: float = 0.0, narrow: bool = False) -> tuple[list[HiddenPair], int]:
    """``count`` exact pairs, numbers of pieces and kinds of trees in turn; and how many were left out as degenerate.

    Before they are drawn, both are deformed by waves of amplitude ``deform``, in units of √area. The generator keeps
    its own margins to what the search needs, or only the ``narrow`` ones.
    """
    hidden_pairs: list[HiddenPair] = []
    left_out, seed = 0, SEED
    while len(hidden_pairs) < count:
        k = len(hidden_pairs)
        n, (topology, curved) = pieces[k % len(pieces)], KINDS[k // len(pieces) % len(KINDS)]
        seed += 1
        exact = exact_pair(n, seed, curved=curved, topology=topology, limits=NARROW if narrow else None)
        if degenerate(exact):
            left_out += 1
            continue
        name = f"hidden{k:03d}"
        rng = np.random.default_rng([SEED, seed])
        p = Hidden(k, *drawn(exact.p, exact.trunk_p, f"{name}-p", deform, rng))
        q = Hidden(k, *drawn(exact.q, exact.trunk_q[::-1], f"{name}-q", deform, rng))
        hidden_pairs.append(HiddenPair(n, topology, curved, seed, exact, p, q))
    return hidden_pairs, left_out


def degenerate(pair: ExactPair) -> bool:
    """Whether an exterior piece or a trunk edge is too small for the filters of candidate trunks."""
    arcs = [(arc, pair.trunk_p) for piece in pair.pieces for arc in (piece.lower, piece.upper)]
    areas = [0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) for (arc, _) in arcs for x, y in (arc.T,)]
    return min(areas) < LEAST_PIECE or float(edge_lengths(pair.trunk_p).min()) < LEAST_EDGE


def drawn(
    polygon: FloatArray, corners: FloatArray, name: str, deform: float, rng: np.random.Generator
) -> tuple[Shape, FloatArray]:
    """The shape of a polygon's `picture`, and points of the polygon in its frame."""
    image, corners = picture(polygon, corners, deform, rng)
    shape = mask_shape(image.astype(np.float64), name)
    # A shape's source coordinates are whole at the middles of pixels.
    return shape, shape.from_source(corners - 0.5)


def picture(
    polygon: FloatArray, corners: FloatArray, deform: float, rng: np.random.Generator
) -> tuple[npt.NDArray[np.uint8], FloatArray]:
    """A polygon as a picture, deformed and grey at the border, and points of the polygon in it."""
    if deform > 0.0:
        moved = deformed(np.concatenate([polygon, corners]), deform, rng)
        polygon, corners = moved[: len(polygon)], moved[len(polygon) :]
    low, extent = polygon.min(axis=0), np.ptp(polygon, axis=0)
    scale = (PIXELS - 2 * MARGIN) / extent.max()

    def to_picture(points: FloatArray) -> FloatArray:
        return np.asarray((points - low) * [scale, -scale] + [MARGIN, PIXELS - MARGIN])

    image = Image.new("L", (PIXELS * FINER, PIXELS * FINER))
    ImageDraw.Draw(image).polygon([(float(x), float(y)) for x, y in to_picture(polygon) * FINER], fill=255)
    return np.asarray(image.reduce(FINER), dtype=np.uint8), to_picture(corners)


def nearest(hidden: Hidden, trunks: Trunks) -> float:
    """Distance of the nearest trunk with as many corners from the true one: that of its farthest corner.

    In the unit-area frame; inf without such trunks.
    """
    n = len(hidden.corners)
    chosen = trunks.vertices.reshape(-1)[np.repeat(trunks.sizes == n, trunks.sizes)].reshape(-1, n)
    corners = hidden.shape.points[chosen]
    turned = [np.roll(hidden.corners, shift, axis=0) for shift in range(n)]
    return min(
        (float(np.hypot(*np.moveaxis(corners - true, 2, 0)).max(axis=1).min(initial=math.inf)) for true in turned),
        default=math.inf,
    )


def failed_test(hidden: Hidden, trunks: Trunks, quick: bool, parameters: TrunkParameters) -> str:
    """The first test that leaves nothing near the true trunk; "" if one of ``trunks`` is near it."""
    shape, corners = hidden.shape, hidden.corners
    n = len(corners)
    if nearest(hidden, trunks) <= NEAR:
        return ""
    points = sparse_points(shape, parameters)
    kept = np.ones(len(points), dtype=np.bool_)
    gap = np.hypot(*np.moveaxis(shape.points[points][:, None] - corners[None], 2, 0))
    vertex_tests: list[tuple[str, Callable[[], BoolArray]]] = [
        ("spacing", lambda: np.ones(len(points), dtype=np.bool_)),
        ("visibility", lambda: passes_visibility(shape, points)),
    ]
    if quick:
        cut = cut_off(shape, reversibility(shape), parameters.neck_width * D_C)
        vertex_tests.append(("necks", lambda: ~cut[points]))
    else:
        vertex_tests.append(("congruency", lambda: congruency(shape, points, parameters).score > parameters.tau_c))
    for name, test in vertex_tests:
        kept &= test()
        if not (kept[:, None] & (gap <= NEAR)).any(axis=0).all():
            return name
    convex = convex_points(shape, parameters)
    if n > min(len(convex), parameters.max_vertices):
        return "too few convex points for n"
    combinations = np.array(list(itertools.product(*[np.flatnonzero(kept & (gap[:, j] <= NEAR)) for j in range(n)])))
    edge_tests = _edge_tests(shape, points, convex, parameters)
    if not quick:
        edge_tests.append(("overlap of congruent stretches", lambda: _small_overlaps(shape, points, parameters)))
    for name, test in edge_tests:
        combinations = combinations[test()[combinations, np.roll(combinations, -1, axis=1)].all(axis=1)]
        if len(combinations) == 0:
            return name
    return "convex"


def _edge_tests(
    shape: Shape, points: IntArray, convex: IntArray, parameters: TrunkParameters
) -> list[tuple[str, Callable[[], BoolArray]]]:
    """The tests of `riot.scores.trunks.admissible_edges`, each by itself: (c, c) whether edges between points pass."""
    count, arcs = len(shape.points), _arcs(shape, points)
    steps = np.mod(points[None, :] - points[:, None], count)
    steps_to_convex = np.mod(convex[None, :] - points[:, None] - 1, count).min(axis=1) + 1
    return [
        ("convex point of every piece", lambda: steps_to_convex[:, None] < steps),
        ("arc < L/2", lambda: arcs < (parameters.max_arc - TIE) * arc_length(shape.points)[-1]),
        ("area", lambda: exterior_areas(shape.points, points) > parameters.min_area + TIE),
        (
            "inside",
            lambda: (
                np.nan_to_num(inside_shares(shape.points, points, arcs > 0.0, TOUCH)) >= parameters.min_inside - TIE
            ),
        ),
    ]


def _small_overlaps(shape: Shape, points: IntArray, parameters: TrunkParameters) -> BoolArray:
    """(c, c) whether the congruent stretches of two points overlap by less than ``max_overlap`` between the points."""
    stretches, arcs = congruency(shape, points, parameters).length, _arcs(shape, points)
    overlap = np.minimum(stretches[:, None], arcs) + np.minimum(stretches[None, :], arcs) - arcs
    return np.asarray(overlap < parameters.max_overlap * L_C)


def _arcs(shape: Shape, points: IntArray) -> FloatArray:
    """(c, c) length of the boundary from one point forwards to another."""
    lengths = arc_length(shape.points)
    return np.asarray(np.mod(lengths[points][None, :] - lengths[points][:, None], lengths[-1]))
