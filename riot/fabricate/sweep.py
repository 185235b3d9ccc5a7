"""What knuckles sweep along the planned motion: other pieces give way; other knuckles stay out. Ours."""

from __future__ import annotations

import math

import numpy as np
import shapely

from riot.errors import FabricationError
from riot.fabricate.model import HingeEnd
from riot.fabricate.outlines import polygons_by_area, subtract
from riot.fabricate.sub_chains import SubChain
from riot.fabricate.tuning import GRID_MM, SAGITTA_MM, SWEEP_QUARTER_SEGMENTS
from riot.parameters import FabricationParameters, allowed_range
from riot.transform.transform import Transform
from riot.types import FloatArray

Ends = list[tuple[HingeEnd, HingeEnd]]


def keep_hinges_apart(
    ends: Ends, chains: list[SubChain], transform: Transform, parameters: FabricationParameters, scale: float
) -> None:
    """Raise `FabricationError` if two hinges' knuckles meet anywhere on the way, with the size at which they do not."""
    n = len(ends)
    radii = _radii(ends)
    closed = [scale * transform.pose(t).origins for t in (0.0, 1.0)]
    distance = np.full((n, n), np.inf)
    where = np.zeros((n, n))
    for t, points in zip((0.0, 1.0), closed, strict=True):
        apart = np.hypot(*np.moveaxis(points[:, None] - points[None], 2, 0))
        where, distance = np.where(apart < distance, t, where), np.minimum(apart, distance)
    for sub_chain in chains:
        hinges = _hinges(sub_chain, n)
        for a, i in enumerate(hinges):
            for b, j in enumerate(hinges[:a]):
                apart = np.hypot(*(sub_chain.points[:, a] - sub_chain.points[:, b]).T)
                k = int(apart.argmin())
                if apart[k] < distance[i, j]:
                    distance[i, j] = distance[j, i] = apart[k]
                    where[i, j] = where[j, i] = sub_chain.times[k]
    worst: tuple[float, int, int] | None = None
    for i in range(n):
        for j in range(i):
            if radii[i] > 0.0 and radii[j] > 0.0 and distance[i, j] > 0.0:
                short = (radii[i] + radii[j] + parameters.gap_mm + SAGITTA_MM) / distance[i, j]
                if worst is None or short > worst[0]:
                    worst = short, j, i
    if worst is not None and worst[0] > 1.0:
        short, i, j = worst
        size = math.ceil(short * parameters.size_mm)
        mend = f"enlarge size_mm ({parameters.size_mm:g}) to {size} or thin pin_mm ({parameters.pin_mm:g})"
        if size > allowed_range(FabricationParameters, "size_mm")[1]:
            mend = f"no allowed size_mm is enough (it takes {size})"
        raise FabricationError(
            "hinges-meet",
            f"hinges {i} and {j} come within {distance[i, j]:.1f} mm of each other at time {where[i, j]:.2f} of the "
            f"motion; their knuckles need {radii[i] + radii[j] + parameters.gap_mm:.1f} mm: {mend}",
            "size_mm",
            size,
        )


def cleared(
    outlines: list[shapely.Polygon],
    ends: Ends,
    chains: list[SubChain],
    transform: Transform,
    gap: float,
    scale: float,
) -> list[shapely.Polygon]:
    """The pieces' outlines less what the knuckles of other pieces' hinges sweep, with the gap around them; mm.

    Of a piece that is cut in two the largest part is kept: that what is lost is not too much, and that knuckles are
    held, is for the layers to check.
    """
    n = len(ends)
    radii = _radii(ends)
    paths: list[list[tuple[float, FloatArray]]] = [[] for _ in outlines]
    for sub_chain in chains:
        for member, piece in enumerate(sub_chain.pieces.tolist()):
            for index, hinge in enumerate(_hinges(sub_chain, n)):
                if hinge not in (piece, (piece + 1) % n) and radii[hinge] > 0.0:
                    seen = sub_chain.seen_from(member, sub_chain.points[:, index])
                    paths[piece].append((radii[hinge], seen))
    for t in (0.0, 1.0) if len(chains) > 1 else ():
        pose = transform.pose(t)
        for piece in range(n):
            c, s = math.cos(pose.headings[piece]), math.sin(pose.headings[piece])
            local = scale * (pose.origins - pose.origins[piece]) @ np.array([[c, -s], [s, c]])
            for hinge in range(n):
                if hinge not in (piece, (piece + 1) % n) and radii[hinge] > 0.0:
                    paths[piece].append((radii[hinge], local[hinge : hinge + 1]))
    return [_less(outline, swept, gap) for outline, swept in zip(outlines, paths, strict=True)]


def _less(outline: shapely.Polygon, swept: list[tuple[float, FloatArray]], gap: float) -> shapely.Polygon:
    shapely.prepare(outline)
    cuts = []
    for radius, points in swept:
        reach = (radius + gap + SAGITTA_MM) / math.cos(math.pi / (4 * SWEEP_QUARTER_SEGMENTS))
        path = shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])
        if shapely.dwithin(outline, path, reach):
            cuts.append(path.simplify(GRID_MM).buffer(reach, quad_segs=SWEEP_QUARTER_SEGMENTS))
    if not cuts:
        return outline
    remaining = polygons_by_area(subtract(outline, shapely.union_all(cuts)))
    return shapely.Polygon(remaining[0].exterior) if remaining else shapely.Polygon()


def _hinges(sub_chain: SubChain, n: int) -> list[int]:
    """The hinges at the sub-chain's points: every piece's start, and the end of the last."""
    return [*sub_chain.pieces.tolist(), (int(sub_chain.pieces[-1]) + 1) % n]


def _radii(ends: Ends) -> list[float]:
    """Of the widest knuckle at every hinge, mm."""
    return [max(ends[hinge][0].radius, ends[hinge - 1][1].radius) for hinge in range(len(ends))]
