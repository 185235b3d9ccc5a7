"""From two shapes to a transform: which trunks to construct on, given by the user or found by CRS."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from riot.construct.exact import construct_plan
from riot.construct.plan import Plan, TrunkPair, plan_pair
from riot.construct.refine import refine
from riot.cross import CrossScore, best_trunk_pairs
from riot.errors import ConstructionError, TrunkError
from riot.parameters import D_C, ConstructParameters, CrsParameters, RefineParameters, TrunkParameters
from riot.polyline import arc_length
from riot.shape import FloatArray, IntArray, Shape
from riot.transform import Transform
from riot.trunks import full_trunks

MERGE = 1e-9
"""Boundary points closer than this along the outline are one."""


def construct(
    a: Shape,
    b: Shape,
    trunks: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    parameters: ConstructParameters | None = None,
    refinement: RefineParameters | None = None,
) -> Transform:
    """Construct an exact transform of a into b.

    Parameters
    ----------
    a, b : Shape
    trunks : two (n, 2) arrays, optional
        Trunk vertices of a and of b as coordinates in the shapes' frames (`Shape.from_source` converts), on or near the
        outlines, in corresponding order: round a one way, round b the other. Given them, no search takes place. Without
        them the trunk pairs of highest CRS are tried, and the transform of least deformation is returned.
    parameters : ConstructParameters, optional
    refinement : RefineParameters, optional
        Of the trunks that are found; given ones are made conjugate and left there.

    Raises
    ------
    TrunkError
        There is no trunk pair, or the given one is not on the outlines, not convex, or not in corresponding order.
    ConstructionError
        No trunk pair gave an exact transform; ``reason`` and the message say why the best one failed.
    """
    parameters, refinement = parameters or ConstructParameters(), refinement or RefineParameters()
    if trunks is not None:
        if len(trunks) != 2:
            raise TrunkError(f"trunks holds {len(trunks)} items: give two, the vertices on a and those on b")
        pair = given_pair(a, b, *trunks, parameters.snap, refinement.reach)
        return construct_plans(*plan_pairs([pair], refinement), parameters)
    full_a, full_b = full_trunks(a, TrunkParameters()), full_trunks(b, TrunkParameters())
    for shape, found in ((a, full_a), (b, full_b)):
        if len(found) == 0:
            raise TrunkError(
                f"{shape.name or 'the shape'} has no trunk: no convex polygon inscribed in it passes all tests"
            )
    scores = best_trunk_pairs(a, b, full_a, full_b, CrsParameters(), refinement.candidates)
    return construct_scored(a, b, scores, parameters, refinement)


def construct_scored(
    a: Shape,
    b: Shape,
    scores: Sequence[CrossScore],
    parameters: ConstructParameters | None = None,
    refinement: RefineParameters | None = None,
) -> Transform:
    """The transform of least deformation on the trunk pairs of ``scores``, refined; errors as `construct`."""
    if not scores:
        raise TrunkError(f"{a.name or 'P'} and {b.name or 'Q'} have no trunks with the same number of vertices")
    refinement = refinement or RefineParameters()
    plans, unplanned = plan_pairs(trunk_pairs(a, b, scores, refinement.reach), refinement)
    return construct_plans(refine_best(plans, refinement), unplanned, parameters or ConstructParameters())


def trunk_pairs(a: Shape, b: Shape, scores: Sequence[CrossScore], reach: float) -> list[TrunkPair]:
    """The trunk pairs of ``scores``, in order; ``reach`` as in `TrunkPair`."""
    return [TrunkPair(a, b, a.points, b.points, score.trunk_a, score.trunk_b, reach) for score in scores]


def plan_pairs(pairs: Sequence[TrunkPair], parameters: RefineParameters) -> tuple[list[Plan], list[ConstructionError]]:
    """Plans, highest bound first, and why the other trunk pairs gave none."""
    plans: list[Plan] = []
    unplanned: list[ConstructionError] = []
    for pair in pairs:
        try:
            plans.append(plan_pair(pair, parameters.bound_lines))
        except ConstructionError as error:
            unplanned.append(error)
    return sorted(plans, key=lambda plan: -plan.bound), unplanned


def refine_best(plans: Sequence[Plan], parameters: RefineParameters) -> list[Plan]:
    """Plans, highest bound first, with the most promising refined a little, and the best of these to the end."""
    rest = list(plans)
    for count, steps in ((parameters.sketched, parameters.sketch_steps), (parameters.refined, parameters.steps)):
        rest = [refine(plan, steps, parameters) for plan in rest[:count]] + rest[count:]
        rest.sort(key=lambda plan: -plan.bound)
    return rest


def construct_plans(
    plans: Sequence[Plan], unplanned: Sequence[ConstructionError], parameters: ConstructParameters
) -> Transform:
    """The best transform of the first ``attempts`` plans that give one; one whose bound is passed is left out."""
    best: Transform | None = None
    best_iou = -1.0
    failures: list[ConstructionError] = []
    certified = 0
    for plan in plans:
        if certified == parameters.attempts:
            break
        if best is not None and plan.bound <= best_iou:
            continue
        try:
            made = construct_plan(plan, parameters)
            _require_certificate(made)
        except ConstructionError as error:
            failures.append(error)
            continue
        certified += 1
        iou = min(made.overlap_ratios)
        if iou > best_iou:
            best, best_iou = made, iou
    if best is None:
        first = [*failures, *unplanned][0]
        count = len(plans) + len(unplanned)
        tried = "the trunk pair gives no" if count == 1 else f"none of {count} trunk pairs gives an"
        raise ConstructionError(first.reason, f"{tried} exact transform; the most promising: {first}")
    return best


def _require_certificate(made: Transform) -> None:
    certificate = made.certificate()
    if not certificate.passed:
        reason = "overlap" if certificate.p.simple and certificate.q.simple else "not-simple"
        raise ConstructionError(reason, f"the certificate fails: {certificate.failure}")


def given_pair(
    a: Shape, b: Shape, trunk_a: npt.ArrayLike, trunk_b: npt.ArrayLike, snap: float, reach: float
) -> TrunkPair:
    """Put given trunk vertices on the outlines, and check that they correspond; TrunkError if they do not.

    They may lie ``snap`` from the outline, in units of ``D_c``; ``reach`` as in `TrunkPair`.
    """
    try:
        wanted = [np.asarray(trunk, dtype=np.float64) for trunk in (trunk_a, trunk_b)]
    except (TypeError, ValueError) as error:
        raise TrunkError(f"trunks are lists of (x, y) coordinates, all of them numbers ({error})") from None
    for name, trunk in zip(("first", "second"), wanted, strict=True):
        if trunk.ndim != 2 or trunk.shape[1] != 2 or len(trunk) < 3 or not np.isfinite(trunk).all():
            raise TrunkError(f"the {name} trunk has shape {trunk.shape}: give (n, 2) finite coordinates, n ≥ 3")
    if len(wanted[0]) != len(wanted[1]):
        raise TrunkError(f"the trunks have {len(wanted[0])} and {len(wanted[1])} vertices: they must have equally many")
    outline_a, indices_a = insert_vertices(a, wanted[0], snap * D_C)
    outline_b, indices_b = insert_vertices(b, wanted[1], snap * D_C)
    around_a, around_b = _direction(indices_a, a), _direction(indices_b, b)
    if around_a == around_b:
        raise TrunkError(
            "both trunks run the same way round: corresponding vertices run opposite ways, "
            "for the chain of pieces closes one way as P and the other way as Q; reverse one of the two lists"
        )
    if around_a < 0:
        indices_a, indices_b = indices_a[::-1].copy(), indices_b[::-1].copy()
    return TrunkPair(a, b, outline_a, outline_b, indices_a, indices_b, reach)


def insert_vertices(shape: Shape, wanted: FloatArray, reach: float) -> tuple[FloatArray, IntArray]:
    """The outline, (m + k, 2), with the boundary points nearest to (n, 2) ``wanted`` among its vertices; their indices.

    TrunkError if one is farther than ``reach`` from the outline.
    """
    points = shape.points
    ahead = np.roll(points, -1, axis=0) - points
    offset = wanted[:, None] - points[None]
    share = np.clip((offset * ahead).sum(axis=2) / (ahead**2).sum(axis=1), 0.0, 1.0)
    distance = np.hypot(*np.moveaxis(offset - share[..., None] * ahead, 2, 0))
    edge = distance.argmin(axis=1)
    rows = np.arange(len(wanted))
    if (distance[rows, edge] > reach).any():
        far = int(distance[rows, edge].argmax())
        raise TrunkError(
            f"trunk vertex {far} at ({wanted[far, 0]:.4g}, {wanted[far, 1]:.4g}) lies {distance[far, edge[far]]:.3g} "
            f"from the outline of {shape.name or 'the shape'}, more than {reach:.3g}: give coordinates in the shape's "
            "frame (unit area, centroid at the origin; Shape.from_source converts the picture's or polygon's own)"
        )
    lengths = arc_length(points)
    position = lengths[edge] + share[rows, edge] * np.hypot(*ahead[edge].T)
    position = np.where(lengths[-1] - position < MERGE, 0.0, position)
    # A vertex of the outline that is as good as the wanted point stands for it.
    nearest = np.abs(lengths[None, :-1] - position[:, None])
    merged = nearest.min(axis=1) < MERGE
    position = np.where(merged, lengths[nearest.argmin(axis=1)], position)
    everything = np.unique(np.concatenate([lengths[:-1], position]))
    closed = np.concatenate([points, points[:1]])
    outline = np.stack([np.interp(everything, lengths, closed[:, axis]) for axis in (0, 1)], axis=1)
    return outline, np.searchsorted(everything, position).astype(np.int64)


def _direction(indices: IntArray, shape: Shape) -> int:
    """+1 if the indices run forwards round the outline, once; −1 if backwards; TrunkError otherwise."""
    for sign in (1, -1):
        if (np.diff(np.roll(indices[::sign], -int(indices[::sign].argmin()))) > 0).all():
            return sign
    raise TrunkError(
        f"the trunk vertices do not follow one another round the outline of {shape.name or 'the shape'}, "
        "or two are the same"
    )
