"""Choose the trunks on which two shapes are transformed, given by the user or of highest CRS, and construct on them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy.typing as npt

from riot.construction.bend import bend_best
from riot.construction.bent_choice import construct_bent
from riot.construction.given_trunks import given_pair
from riot.construction.pins import Pins
from riot.construction.plan import ConstructionPlan
from riot.construction.plan_search import PieceCounts, find_plans, plan_pairs, refine_best
from riot.construction.plan_transform import construct_plans
from riot.construction.stiff import StiffRegions
from riot.errors import ConstructionError, TrunkError
from riot.geometry.shape import Shape
from riot.parameters import BendParameters, ConstructParameters, RefineParameters
from riot.transform.transform import Transform


def construct(
    a: Shape,
    b: Shape,
    trunks: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    parameters: ConstructParameters | None = None,
    refinement: RefineParameters | None = None,
    pins: Pins | None = None,
    pieces: PieceCounts | None = None,
    bend: BendParameters | None = None,
    stiff: StiffRegions | None = None,
) -> Transform:
    """Construct an exact transform of a into b.

    Parameters
    ----------
    a, b : Shape
    trunks : two (n, 2) arrays, optional
        Trunk vertices of a and of b as coordinates in the shapes' frames (`Shape.from_source` converts), on or near the
        outlines, in corresponding order: round a one way, round b the other. Given them, no search takes place; they
        are made conjugate and refined. Without them the trunk pairs of highest CRS are tried, and the transform of
        least deformation is returned.
    parameters : ConstructParameters, optional
        With ``method="laplacian"`` the transform is the paper's, which overlaps and leaves gaps: its certificate fails.
    refinement : RefineParameters, optional
        Of the trunks, found or given; with ``sketched=0, refined=0`` they are only made conjugate.
    pins : Pins, optional
        Sections of either outline to keep, or drawn anew (exact method).
    pieces : two int, optional
        Least and greatest number of pieces; any number by default. Given trunks have theirs.
    bend : BendParameters, optional
        With ``method="elastic"`` both shapes are bent a little first, and the transform is that of the bent shapes,
        ``p`` and ``q``; it keeps a and b as ``input_p`` and ``input_q``.
        `riot.construction.bend.bend_best` tells how they are bent. Plans that are not bent are tried after those that
        are. Pins are of the inputs, and go along with the bend.
    stiff : StiffRegions, optional
        Parts of either shape that bend less; without a bend they mean nothing.

    Raises
    ------
    TrunkError
        There is no trunk pair, or the given one is not on the outlines, not convex, or not in corresponding order.
    ConstructionError
        No trunk pair gave an exact transform; ``reason`` and the message say why the best one failed.

    Examples
    --------
    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)], name="house")
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)], name="kite")
    >>> len(construct(house, kite))  # pieces
    4
    """
    parameters, refinement = parameters or ConstructParameters(), refinement or RefineParameters()
    if trunks is not None:
        if len(trunks) != 2:
            raise TrunkError(f"trunks holds {len(trunks)} items: give two, the vertices on a and those on b")
        pair = given_pair(a, b, *trunks, parameters.snap, refinement.reach)
        plans, unplanned = plan_pairs([pair], refinement)
        # Refined trunks may lose contact that the given ones have.
        plans = sorted({*refine_best(plans, refinement), *plans}, key=lambda plan: -plan.bound)
    else:
        starts = bend.starts if bend is not None and bend.method == "elastic" else 0
        plans, unplanned = find_plans(a, b, refinement, pieces, starts)
    return construct_from(plans, unplanned, parameters, refinement, pins, bend, stiff)


def construct_from(
    plans: Sequence[ConstructionPlan],
    unplanned: Sequence[ConstructionError],
    parameters: ConstructParameters,
    refinement: RefineParameters | None = None,
    pins: Pins | None = None,
    bend: BendParameters | None = None,
    stiff: StiffRegions | None = None,
) -> Transform:
    """Construct plans of one pair of shapes, bent if ``bend`` asks for it; arguments and errors as of `construct`.

    >>> from riot.construction import alternatives
    >>> plans = alternatives(house, kite)
    >>> bent = construct_from(plans, [], ConstructParameters(), bend=BendParameters(method="elastic", steps=8))
    >>> bent.input_p is house
    True
    """
    if bend is None or bend.method == "off" or not plans:
        return construct_plans(plans, unplanned, parameters, pins)
    bent = bend_best(plans, bend, refinement, parameters, stiff)
    return construct_bent(bent, plans, unplanned, bend, parameters, pins)
