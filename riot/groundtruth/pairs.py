"""Any number of exact reversible pairs, from conjugate polygons and planar trees (theory §1.2, §11). Ours.

Any planar tree inside T̄ and any planar tree inside T, if both unfold without overlap, is an exact RIOT: P is T with
T̄'s regions hinged outside, Q is T̄ with T's regions hinged outside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely

from riot.errors import ConstructionError
from riot.geometry.polyline import centroid, trunk_angles
from riot.geometry.shape import Shape
from riot.groundtruth.conjugate_polygons import conjugate_polygons
from riot.groundtruth.limits import PairLimits
from riot.groundtruth.tree import PlanarTree, curve, embed, random_tree, star, walk
from riot.transform.pose import Placement
from riot.transform.transform import Piece, Transform
from riot.types import FloatArray

Topology = Literal["star", "binary", "random"]
TOPOLOGIES: tuple[Topology, ...] = ("star", "binary", "random")

# All constants below are ours: they decide which pairs are drawn, and how long it takes to find one.

_CURVE_HEIGHT = 0.3
"""Height of the waves of a curved arc, in lengths of the arc, at the first try; the waves flatten as tries fail."""

_LEAF_WEIGHT = 0.5
"""Stiffness of the arcs to the leaves: less than 1, so that these arcs are long and the hinges distinct."""

_TRUNK_TRIES, _TREE_TRIES, _RELAX_AFTER = 20_000, 20, 30
"""Conjugate polygons drawn, trees drawn in each, and dissected polygons before the corner tolerance shrinks."""

_RELAX = 0.7
"""Factor by which it shrinks."""

_CORNER_HEIGHT = 0.25
"""Height of a hinge's corner per sine of its angle: its two legs are about 0.5 long, rarely longer."""


@dataclass(frozen=True, eq=False)
class ExactPair:
    """Two shapes that are exactly reversible, with their trunks and pieces.

    Parameters
    ----------
    p, q : (m, 2) float64
        Simple counter-clockwise polygons, unit area, centroid at the origin; hinges are vertices of both.
    trunk_p, trunk_q : (n, 2) float64
        Trunk vertices in corresponding order, ``trunk_p`` counter-clockwise on p, ``trunk_q`` clockwise on q. Edge j
        runs from vertex j to j + 1, and is equally long in both.
    pieces : tuple of n `riot.transform.transform.Piece`
        The rigid pieces, each in its own frame, piece j owning edge j.
    """

    p: FloatArray
    q: FloatArray
    trunk_p: FloatArray
    trunk_q: FloatArray
    pieces: tuple[Piece, ...]


def exact_pair(
    n: int, seed: int, *, curved: bool = True, topology: Topology = "random", limits: PairLimits | None = None
) -> ExactPair:
    """An exact reversible pair with n pieces; the same arguments give the same pair.

    ``curved`` bends the arcs of both dissections, otherwise all pieces are convex polygons; ``topology`` is that of
    both trees. Pairs are drawn until both shapes are simple and keep the ``limits`` (`PairLimits` by default).

    Raises ValueError for n < 3, a negative seed or an unknown topology, ConstructionError ``none-found``.

    >>> pair = exact_pair(4, seed=1)
    >>> len(pair.pieces), pair.trunk_p.shape
    (4, (4, 2))
    """
    limits = limits or PairLimits()
    if n < 3 or seed < 0 or topology not in TOPOLOGIES:
        allowed = f"n ≥ 3, seed ≥ 0, topology one of {', '.join(TOPOLOGIES)}"
        raise ValueError(f"exact_pair({n=}, {seed=}, {topology=}): choose {allowed}")
    rng = np.random.default_rng([n, seed, int(curved), TOPOLOGIES.index(topology)])
    tolerance, tries = limits.corner_tolerance, 0
    for _ in range(_TRUNK_TRIES):
        trunks = conjugate_polygons(rng, n, limits)
        if trunks is None:
            continue
        v, w = trunks
        hinges = trunk_angles(v) + trunk_angles(w)
        if hinges.min() < limits.least_hinge_angle or hinges.max() > limits.greatest_hinge_angle:
            continue
        if _CORNER_HEIGHT * np.abs(np.sin(hinges)).min() < tolerance:
            continue
        arcs_p = _dissect(rng, w, v, tolerance, limits, curved=curved, topology=topology)
        arcs_q = None if arcs_p is None else _dissect(rng, v, w, tolerance, limits, curved=curved, topology=topology)
        if arcs_p is not None and arcs_q is not None:
            return _assemble(v, w, arcs_p, arcs_q)
        tries += 1
        if tries % _RELAX_AFTER == 0:
            tolerance *= _RELAX
    raise ConstructionError(
        "none-found", f"no exact pair with n = {n}, seed = {seed}: try another seed, or fewer pieces"
    )


def dudeney() -> ExactPair:
    """Dudeney's triangle (p) and square (q), scaled to unit area; one of the four exterior pieces of p is empty.

    Hinges: the middles E, F of two sides, and two points P, Q of the third, in the order E, Q, P, F.

    >>> len(dudeney().pieces)
    4
    """
    corner_a, corner_c = np.array([0.0, 0.0]), np.array([1.0, 0.0])
    corner_b = np.array([0.5, math.sqrt(3.0) / 2.0])
    e, f = (corner_a + corner_b) / 2.0, (corner_b + corner_c) / 2.0
    # The cut from E to P is as long as the square's side; any other P would give a rectangle.
    p = np.array([e[0] + math.sqrt(math.sqrt(3.0) / 4.0 - e[1] ** 2), 0.0])
    q = p - [0.5, 0.0]
    cut = (p - e) / math.dist(p, e)
    r, s = e + cut * ((f - e) @ cut), e + cut * ((q - e) @ cut)

    v = np.array([e, q, p, f])
    # Turned about E and F, the triangle's three corners meet in B, on the edge between the images of Q and P.
    w = np.array([e, 2.0 * e - q, 2.0 * f - p, f])
    in_square = PlanarTree(4, (5, 5, 4, 4, -1, 4))  # R joins P and F, S joins E and Q
    nodes = np.array([*v, r, s])
    arcs_q = _walks(in_square, {k: nodes[[k, in_square.parent[k]]] for k in in_square.arcs})
    meeting = star(4)
    arcs_p = _walks(meeting, {k: np.array([w[k], corner_b]) for k in meeting.arcs})
    arcs_p[1] = w[1:3]  # the empty piece
    scale = 1.0 / math.sqrt(math.sqrt(3.0) / 4.0)
    return _assemble(v * scale, w * scale, [a * scale for a in arcs_p], [a * scale for a in arcs_q])


def exact_transform(pair: ExactPair) -> Transform:
    """The pair as a `riot.transform.transform.Transform`; its inputs are its own outlines.

    >>> exact_transform(dudeney()).certificate().passed
    True
    """
    return Transform(
        pair.pieces,
        trunk_angles(pair.trunk_p),
        trunk_angles(pair.trunk_q),
        Placement.of(pair.trunk_p),
        Placement.of(pair.trunk_q),
        Shape(pair.p, np.ones(len(pair.p), dtype=np.bool_), "P"),
        Shape(pair.q, np.ones(len(pair.q), dtype=np.bool_), "Q"),
        pair.trunk_p,
        pair.trunk_q,
        1.0,
        1.0,
    )


def _dissect(
    rng: np.random.Generator,
    inner: FloatArray,
    outer: FloatArray,
    tolerance: float,
    limits: PairLimits,
    *,
    curved: bool,
    topology: Topology,
) -> list[FloatArray] | None:
    """Dissect the trunk ``inner`` so that its regions, hinged around ``outer``, make a good silhouette.

    Returns the n arcs, from vertex j to j + 1 of ``inner``; None if all tries are bad.
    """
    n = len(inner)
    for attempt in range(_TREE_TRIES):
        tree = star(n) if topology == "star" else random_tree(rng, n, binary=topology == "binary")
        weights = np.exp(2.0 * (rng.random(len(tree.parent)) - 0.5))
        weights[:n] *= _LEAF_WEIGHT
        nodes = embed(tree, inner, weights)
        bend = _CURVE_HEIGHT * (1.0 - attempt / _TREE_TRIES) if curved else 0.0
        curves = {k: curve(rng, nodes[k], nodes[tree.parent[k]], bend) for k in tree.arcs}
        arcs = _walks(tree, curves)
        outline = _outline(arcs, inner, outer)
        # The cheapest check comes first.
        if (
            limits.allow_hinges(outline, outer, tolerance)
            and (not curved or _planar(inner, curves))
            and all(map(limits.allow_piece, arcs))
            and limits.allow_outline(outline, arcs)
        ):
            return arcs
    return None


def _planar(corners: FloatArray, curves: dict[int, FloatArray]) -> bool:
    """Whether the tree's arcs and the polygon's edges meet in their common end points only."""
    edges = [corners[[j, (j + 1) % len(corners)]] for j in range(len(corners))]
    return bool(shapely.MultiLineString([*edges, *curves.values()]).is_simple)


def _walks(tree: PlanarTree, curves: dict[int, FloatArray]) -> list[FloatArray]:
    return [walk(tree, curves, leaf) for leaf in range(tree.leaves)]


def _carry(points: FloatArray, edge: FloatArray, onto: FloatArray) -> FloatArray:
    """Move (k, 2) points by the rigid motion, never a reflection, that brings one segment (2, 2) onto another."""
    source, target = (complex(*(e[1] - e[0])) for e in (edge, onto))
    turn = target / source
    turn /= abs(turn)
    relative = points - edge[0]
    rotation = np.array([[turn.real, turn.imag], [-turn.imag, turn.real]])
    return np.asarray(relative @ rotation + onto[0])


def _outline(arcs: list[FloatArray], inner: FloatArray, outer: FloatArray) -> FloatArray:
    """The arcs of ``inner``'s dissection hinged around ``outer``, in the order in which ``outer`` is listed."""
    n = len(inner)
    ends = [[j, (j + 1) % n] for j in range(n)]
    return np.concatenate([_carry(arcs[j][:-1], inner[e], outer[e]) for j, e in enumerate(ends)])


def _assemble(v: FloatArray, w: FloatArray, arcs_p: list[FloatArray], arcs_q: list[FloatArray]) -> ExactPair:
    """The pair of the conjugate trunks v, w with ``arcs_p`` dissecting w, and ``arcs_q`` dissecting v."""
    n = len(v)
    p, q = _outline(arcs_p, w, v), _outline(arcs_q, v, w)[::-1].copy()
    centre_p, centre_q = centroid(p), centroid(q)
    pieces = []
    for j in range(n):
        e = [j, (j + 1) % n]
        length = math.dist(v[e[0]], v[e[1]])
        axis = np.array([[0.0, 0.0], [length, 0.0]])
        lower, upper = _carry(arcs_p[j], w[e], axis), _carry(arcs_q[j], v[e], axis)[::-1].copy()
        lower[0], lower[-1], upper[0], upper[-1] = axis[0], axis[1], axis[1], axis[0]
        pieces.append(Piece(length, lower, upper))
    return ExactPair(p - centre_p, q - centre_q, v - centre_p, w - centre_q, tuple(pieces))
