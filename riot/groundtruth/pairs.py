"""Exact reversible pairs without end, from conjugate polygons and planar trees (theory §1.2, §11). Ours.

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
from riot.geometry.polyline import centroid, edge_lengths, signed_area, simplify, trunk_angles
from riot.geometry.shape import Shape
from riot.groundtruth.tree import PlanarTree, embed, random_tree, star, walk
from riot.transform.pose import Placement
from riot.transform.transform import Piece, Transform
from riot.types import FloatArray
from riot.units import L_C

Topology = Literal["star", "binary", "random"]
TOPOLOGIES: tuple[Topology, ...] = ("star", "binary", "random")

# What a pair must keep to look like two silhouettes and to survive the miner's own filters with a margin.
# Lengths and areas are in the unit-area frame, angles in radians.
TRUNK_ANGLES = (math.radians(40), math.radians(158))
"""Least and greatest angle of both trunks."""
HINGE_ANGLES = (math.radians(60), math.radians(325))
"""Least and greatest angle of the assembled shape at a hinge."""
CORNER_TOLERANCE, CORNER_DISTANCE = 0.11, 0.03
"""Every hinge is within this distance of a vertex of the outline simplified by Douglas–Peucker with this tolerance, so
that a search which starts from feature points can meet it. The tolerance shrinks where such pairs are rare."""
LEAST_AREA = 0.02
"""Of an exterior piece."""
LEAST_DEPTH = 0.13
"""Of an exterior piece over its trunk edge: more than the paper's τ_s, so that it keeps a convex point."""
CLEARANCE = 0.02
"""Half the width of the narrowest limb or piece, and of the narrowest mouth of a bay."""
GREATEST_TIP = 4.0
"""How far a limb may reach beyond where it is narrower than twice the clearance, in clearances: no whiskers, and no
tip sharper than 29°."""
GREATEST_ARC = 0.45
"""Boundary length of an exterior piece, in units of the perimeter."""
GREATEST_PERIMETER = 2.0 * L_C
CURVE_STEP = L_C / 120
"""Spacing of the points on curved arcs."""
TRUNK_TRIES, TREE_TRIES, RELAX_AFTER = 20_000, 20, 30
"""Conjugate polygons drawn, trees drawn in each, and dissected pairs of polygons before the tolerance shrinks."""


@dataclass(frozen=True, eq=False)
class ExactPair:
    """Two shapes which are reversible exactly, with the way they are.

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


def exact_pair(n: int, seed: int, *, curved: bool = True, topology: Topology = "random") -> ExactPair:
    """An exact reversible pair with n pieces; the same arguments give the same pair.

    ``curved`` bends the arcs of both dissections, otherwise all pieces are convex polygons; ``topology`` is that of
    both trees. Drawn and redrawn until both shapes are simple and look like silhouettes (the limits of this module).

    Raises ValueError for n < 3, a negative seed or an unknown topology, ConstructionError if nothing was found.
    """
    if n < 3 or seed < 0 or topology not in TOPOLOGIES:
        allowed = f"n ≥ 3, seed ≥ 0, topology one of {', '.join(TOPOLOGIES)}"
        raise ValueError(f"exact_pair({n=}, {seed=}, {topology=}): choose {allowed}")
    rng = np.random.default_rng([n, seed, int(curved), TOPOLOGIES.index(topology)])
    tolerance, tries = CORNER_TOLERANCE, 0
    for _ in range(TRUNK_TRIES):
        trunks = _conjugate_polygons(rng, n)
        if trunks is None:
            continue
        v, w = trunks
        hinges = trunk_angles(v) + trunk_angles(w)
        if hinges.min() < HINGE_ANGLES[0] or hinges.max() > HINGE_ANGLES[1]:
            continue
        # A corner on two legs of 0.5 has this height; longer ones are rare.
        if 0.25 * np.abs(np.sin(hinges)).min() < tolerance:
            continue
        arcs_p = _dissect(rng, w, v, tolerance, curved=curved, topology=topology)
        arcs_q = None if arcs_p is None else _dissect(rng, v, w, tolerance, curved=curved, topology=topology)
        if arcs_p is not None and arcs_q is not None:
            return _assemble(v, w, arcs_p, arcs_q)
        tries += 1
        if tries % RELAX_AFTER == 0:
            tolerance *= 0.7
    raise ConstructionError(
        "none-found", f"no exact pair with n = {n}, seed = {seed}: try another seed, or fewer pieces"
    )


def dudeney() -> ExactPair:
    """Dudeney's triangle (p) and square (q), scaled to unit area; one of the four exterior pieces of p is empty.

    Hinges: the middles E, F of two sides, and two points P, Q of the third, in the order E, Q, P, F.
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
    """The pair as a `riot.transform.transform.Transform`, its inputs being its own outlines."""
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


def _conjugate_polygons(rng: np.random.Generator, n: int) -> tuple[FloatArray, FloatArray] | None:
    """(v, w), total area 1: convex, equal edge lengths, v listed counter-clockwise and w clockwise."""
    lengths = 0.55 + 0.9 * rng.random(n)
    if 2.0 * lengths.max() > 0.95 * lengths.sum():
        return None
    first, second = _convex_polygon(rng, lengths), _convex_polygon(rng, lengths)
    if first is None or second is None:
        return None
    second = second * [1.0, -1.0]
    scale = 1.0 / math.sqrt(signed_area(first) - signed_area(second))
    return first * scale, second * scale


def _convex_polygon(rng: np.random.Generator, lengths: FloatArray) -> FloatArray | None:
    """A counter-clockwise convex polygon with these edge lengths and headings near random ones."""
    n = len(lengths)
    turns = 1.0 + 1.2 * (rng.random(n) - 0.5)
    headings = 2.0 * math.pi * np.cumsum(turns) / turns.sum()
    for _ in range(50):
        edges = lengths[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=1)
        gap = edges.sum(axis=0)
        if np.abs(gap).max() < 1e-15 * n:
            break
        # Minimum-norm step: d(edge)/d(heading) is the edge turned by a quarter.
        jacobian = np.stack([-edges[:, 1], edges[:, 0]])
        gram = jacobian @ jacobian.T
        if np.linalg.det(gram) < 1e-6:
            return None
        headings = headings - jacobian.T @ np.linalg.solve(gram, gap)
    polygon = np.concatenate([np.zeros((1, 2)), np.cumsum(edges, axis=0)[:-1]])
    turned = np.diff(headings, append=headings[0] + 2.0 * math.pi)
    angles = math.pi - turned
    if np.abs(gap).max() > 1e-12 or angles.min() < TRUNK_ANGLES[0] or angles.max() > TRUNK_ANGLES[1]:
        return None
    return polygon


def _dissect(
    rng: np.random.Generator,
    inner: FloatArray,
    outer: FloatArray,
    tolerance: float,
    *,
    curved: bool,
    topology: Topology,
) -> list[FloatArray] | None:
    """Dissect the trunk ``inner`` so that its regions, hinged around ``outer``, make a good silhouette.

    Returns the n arcs, from vertex j to j + 1 of ``inner``; None if all tries are bad.
    """
    n = len(inner)
    for attempt in range(TREE_TRIES):
        tree = star(n) if topology == "star" else random_tree(rng, n, binary=topology == "binary")
        # Inner nodes hold together, so that the leaves' arcs are long and the hinges plain to see.
        weights = np.exp(2.0 * (rng.random(len(tree.parent)) - 0.5))
        weights[:n] *= 0.5
        nodes = embed(tree, inner, weights)
        # Calmer curves as tries fail.
        bend = 0.3 * (1.0 - attempt / TREE_TRIES) if curved else 0.0
        curves = {k: _curve(rng, nodes[k], nodes[tree.parent[k]], bend) for k in tree.arcs}
        arcs = _walks(tree, curves)
        outline = _outline(arcs, inner, outer)
        # Cheapest first.
        if (
            _marked(outline, outer, tolerance)
            and (not curved or _planar(inner, curves))
            and all(map(_good_piece, arcs))
            and _good_outline(outline, arcs)
        ):
            return arcs
    return None


def _curve(rng: np.random.Generator, start: FloatArray, end: FloatArray, bend: float) -> FloatArray:
    """A polyline from start to end, straight if ``bend`` is 0, else a few waves of about that height × length."""
    if bend == 0.0:
        return np.array([start, end])
    along = end - start
    t = np.linspace(0.0, 1.0, max(5, math.ceil(float(np.hypot(*along)) / CURVE_STEP) + 1))
    waves = 2.0 * (rng.random(3) - 0.5) / [1.0, 2.0, 4.0]
    height = bend * sum(a * np.sin((k + 1) * math.pi * t) for k, a in enumerate(waves))
    points = start + t[:, None] * along + height[:, None] * np.array([-along[1], along[0]])
    points[0], points[-1] = start, end
    return np.asarray(points)


def _planar(corners: FloatArray, curves: dict[int, FloatArray]) -> bool:
    """Whether the tree's arcs and the polygon's edges meet in their common end points only."""
    edges = [corners[[j, (j + 1) % len(corners)]] for j in range(len(corners))]
    return bool(shapely.MultiLineString([*edges, *curves.values()]).is_simple)


def _good_piece(arc: FloatArray) -> bool:
    edge = (arc[-1] - arc[0]) / math.dist(arc[0], arc[-1])
    depth = np.abs((arc - arc[0]) @ [-edge[1], edge[0]]).max()
    polygon = shapely.Polygon(arc)
    return bool(depth >= LEAST_DEPTH and polygon.area >= LEAST_AREA and _in_one_part(polygon.buffer(-CLEARANCE)))


def _good_outline(outline: FloatArray, arcs: list[FloatArray]) -> bool:
    perimeter = float(edge_lengths(outline).sum())
    longest = max(float(np.hypot(*np.diff(arc, axis=0).T).sum()) for arc in arcs)
    if perimeter > GREATEST_PERIMETER or longest > GREATEST_ARC * perimeter:
        return False
    polygon = shapely.Polygon(outline)
    return (
        polygon.is_valid and _in_one_part(polygon.buffer(-CLEARANCE)) and len(polygon.buffer(CLEARANCE).interiors) == 0
    )


def _marked(outline: FloatArray, trunk: FloatArray, tolerance: float) -> bool:
    """Whether every vertex of the trunk is at a corner of the simplified outline."""
    corners = outline[simplify(outline, tolerance)]
    gaps = np.hypot(*(trunk[:, None, :] - corners[None, :, :]).transpose(2, 0, 1)).min(axis=1)
    return bool(gaps.max() <= CORNER_DISTANCE)


def _in_one_part(polygon: shapely.Geometry) -> bool:
    return bool(polygon.geom_type == "Polygon" and not polygon.is_empty)


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
