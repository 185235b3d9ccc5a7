"""Put trunks that a user gives on the outlines, and check that they correspond (ours)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from riot.construction.plan import TrunkPair
from riot.construction.tuning import MERGE_DISTANCE
from riot.errors import TrunkError
from riot.geometry.polyline import arc_length
from riot.geometry.shape import Shape
from riot.types import FloatArray, IntArray
from riot.units import D_C


def given_pair(
    a: Shape, b: Shape, trunk_a: npt.ArrayLike, trunk_b: npt.ArrayLike, snap: float, reach: float
) -> TrunkPair:
    """Put given trunk vertices (n, 2) on the outlines, and check that they correspond (ours).

    They may lie ``snap`` from the outline, in units of ``D_c``; ``reach`` as in `TrunkPair`. Raises TrunkError if they
    are not finite, lie farther off, differ in number, or do not run around the outlines in opposite directions.

    >>> from riot import Shape
    >>> house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    >>> kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    >>> base, ends = [[0, 0], [4, 0], [2, 5]], [[-2, 0], [0, 3], [2, 0]]  # one runs counter-clockwise, one clockwise
    >>> given_pair(house, kite, house.from_source(base), kite.from_source(ends), 0.1, 0.1).corners.shape
    (2, 3, 2)
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

    Raises TrunkError if one is farther than ``reach`` from the outline.
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
    position = np.where(lengths[-1] - position < MERGE_DISTANCE, 0.0, position)
    # A vertex of the outline that is as good as the wanted point stands for it.
    nearest = np.abs(lengths[None, :-1] - position[:, None])
    merged = nearest.min(axis=1) < MERGE_DISTANCE
    position = np.where(merged, lengths[nearest.argmin(axis=1)], position)
    all_positions = np.unique(np.concatenate([lengths[:-1], position]))
    closed = np.concatenate([points, points[:1]])
    outline = np.stack([np.interp(all_positions, lengths, closed[:, axis]) for axis in (0, 1)], axis=1)
    return outline, np.searchsorted(all_positions, position).astype(np.int64)


def _direction(indices: IntArray, shape: Shape) -> int:
    """+1 if the indices run forwards round the outline, once; −1 if backwards; TrunkError otherwise."""
    for sign in (1, -1):
        if (np.diff(np.roll(indices[::sign], -int(indices[::sign].argmin()))) > 0).all():
            return sign
    raise TrunkError(
        f"the trunk vertices do not follow one another round the outline of {shape.name or 'the shape'}, "
        "or two are the same"
    )
