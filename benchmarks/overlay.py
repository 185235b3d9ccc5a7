"""CRS with the area term by exact polygon overlay: the reference that the scanlines are measured against."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from riot.geometry.polyline import swept_area
from riot.geometry.shape import Shape
from riot.kernels.coverage import swung_arcs
from riot.parameters import CrsParameters
from riot.scores.trunks import Trunks
from riot.types import FloatArray, IntArray
from riot.units import D_C

CHUNK = 64
"""Trunks of P whose candidates are listed at once, to bound the memory."""

GRID = 1e-12

FIRST_LIMIT = 0.5
"""First try at the distance up to which candidates are listed; any value gives the same result."""


@dataclass(frozen=True, eq=False)
class OverlayScore:
    """A trunk pair, the vertices in corresponding order, with its distance (score = exp(−distance²/2)) and d_A."""

    distance: float
    area: float
    trunk_a: IntArray
    trunk_b: IntArray


def overlay_best_trunk_pairs(
    a: Shape,
    b: Shape,
    trunks_a: Trunks,
    trunks_b: Trunks,
    parameters: CrsParameters | None = None,
    count: int = 16,
) -> list[OverlayScore]:
    """The ``count`` trunk pairs of highest CRS, best first, as `riot.scores.crs.best_trunk_pairs` but with exact areas.

    Best-first over every (T, T', shift) with the bound of `riot.kernels.candidates`, without pruning or slack.
    """
    parameters = parameters or CrsParameters()
    above, limit = -math.inf, FIRST_LIMIT
    kept: list[tuple[float, tuple[int, int, int], float]] = []
    while True:
        for bound, terms, triple in sorted(candidates(a, b, trunks_a, trunks_b, parameters, above, limit)):
            if len(kept) == count and bound > kept[-1][0]:
                break
            t, u, s = triple
            trunk_b = trunks_b.of(u)[(s - np.arange(trunks_b.sizes[u])) % trunks_b.sizes[u]]
            area = overlay_area_term(a.points, b.points, trunks_a.of(t), trunk_b)
            kept = heapq.nsmallest(count, [*kept, (max(terms, area / parameters.sigma_area), triple, area)])
        worst = kept[-1][0] if len(kept) == count else math.inf
        if limit >= worst:
            break
        above, limit = limit, min(2.0 * limit, worst) if limit < 64.0 else worst
    return [
        OverlayScore(
            distance, area, trunks_a.of(t), trunks_b.of(u)[(s - np.arange(trunks_b.sizes[u])) % trunks_b.sizes[u]]
        )
        for distance, (t, u, s), area in kept
    ]


def overlay_area_term(points_a: FloatArray, points_b: FloatArray, trunk_a: IntArray, trunk_b: IntArray) -> float:
    """d_A of two corresponding trunks (n,), the worse of the two directions, exact."""
    there = sum(_overlay_areas(*_swung(points_a, trunk_a, points_b[trunk_b])))
    back = sum(_overlay_areas(*_swung(points_b, trunk_b[::-1].copy(), points_a[trunk_a[::-1]])))
    return max(there, back)


def _swung(points: FloatArray, trunk: IntArray, target: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    arcs, offsets = np.empty((len(points) + len(trunk), 2)), np.empty(len(trunk) + 1, dtype=np.int64)
    total = swung_arcs(points, trunk, target, arcs, offsets)
    return target, arcs[:total], offsets


def _overlay_areas(target: FloatArray, arcs: FloatArray, offsets: IntArray) -> tuple[float, float, float]:
    """Gaps, overlaps and outside (see `riot.kernels.coverage`) by overlay."""
    trunk = shapely.Polygon(target)
    regions = [shapely.Polygon(arcs[start:stop]) for start, stop in pairwise(offsets)]
    if not all(region.is_valid for region in regions):
        return _overlay_windings(trunk, regions)
    inside = [region.intersection(trunk) for region in regions]
    covered = shapely.union_all(inside).area
    outside = sum(region.area for region in regions) - sum(region.area for region in inside)
    return trunk.area - covered, sum(region.area for region in inside) - covered, outside


def _overlay_windings(trunk: shapely.Polygon, regions: list[shapely.Polygon]) -> tuple[float, float, float]:
    """The same where arcs cross their edges: face by face of all outlines, by winding numbers."""
    # On a grid: else faces get spikes along each other's edges, and points "inside" them lie on the other side.
    outlines = shapely.union_all([trunk.exterior, *(region.exterior for region in regions)], grid_size=GRID)
    faces = [face for face in shapely.polygonize([outlines]).geoms if face.area > 0.0]
    inner = np.array([face.representative_point().coords[0] for face in faces])
    windings = np.stack([_winding(np.array(region.exterior.coords), inner) for region in regions])
    areas = np.array([face.area for face in faces])
    within = _winding(np.array(trunk.exterior.coords), inner) != 0
    # The regions run the same way round as their shape, the trunk the other way in half of the cases.
    whole = windings.sum(axis=0)
    gaps = float((areas * np.maximum(1 - whole, 0))[within].sum())
    overlaps = float((areas * np.maximum(whole - 1, 0))[within].sum())
    outside = float((areas * np.abs(windings).sum(axis=0))[~within].sum())
    return gaps, overlaps, outside


def _winding(ring: FloatArray, points: FloatArray) -> IntArray:
    """(k,) how often a closed ring (m + 1, 2), the last point being the first, runs round each of (k, 2) points."""
    x, y = points[:, :1], points[:, 1:]
    (x0, y0), (x1, y1) = ring[:-1].T, ring[1:].T
    side = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)
    up, down = (y0 <= y) & (y1 > y) & (side > 0.0), (y0 > y) & (y1 <= y) & (side < 0.0)
    winding: IntArray = up.sum(axis=1) - down.sum(axis=1)
    return winding


def candidates(
    a: Shape, b: Shape, trunks_a: Trunks, trunks_b: Trunks, parameters: CrsParameters, above: float, limit: float
) -> Iterator[tuple[float, float, tuple[int, int, int]]]:
    """(bound, max(d_E/σ_E, d_∠/σ_∠), (T, T', shift)) of every bound greater than ``above`` and at most ``limit``."""
    for n in np.intersect1d(trunks_a.sizes, trunks_b.sizes):
        rows_a, rows_b = np.flatnonzero(trunks_a.sizes == n), np.flatnonzero(trunks_b.sizes == n)
        for start in range(0, len(rows_a), CHUNK):
            chosen = rows_a[start : start + CHUNK]
            for s in range(n):
                bounds, terms = _bounds(a, b, trunks_a, trunks_b, chosen, rows_b, s, int(n), parameters)
                for i, j in np.argwhere((bounds > above) & (bounds <= limit)):
                    yield float(bounds[i, j]), float(terms[i, j]), (int(chosen[i]), int(rows_b[j]), s)


def _bounds(
    a: Shape,
    b: Shape,
    trunks_a: Trunks,
    trunks_b: Trunks,
    rows_a: IntArray,
    rows_b: IntArray,
    s: int,
    n: int,
    parameters: CrsParameters,
) -> tuple[FloatArray, FloatArray]:
    """(i, j) bounds and terms of trunks of n vertices at one shift."""
    k = np.arange(n)
    x, y = trunks_a.offsets[rows_a, None] + k, trunks_b.offsets[rows_b, None] + (s - k) % n
    y_edges = trunks_b.offsets[rows_b, None] + (s - 1 - k) % n
    edges_a, edges_b = trunks_a.edges[x][:, None], trunks_b.edges[y_edges][None]
    edge = np.abs(edges_a - edges_b).sum(axis=2) / (n * parameters.sigma_e * D_C)
    angles = np.abs(trunks_a.betas[x][:, None] - trunks_b.alphas[y][None])
    angles += np.abs(trunks_a.alphas[x][:, None] - trunks_b.betas[y][None])
    terms = np.maximum(edge, angles.sum(axis=2) / (2.0 * n * parameters.sigma_angle))
    # A piece swung onto the other trunk grows by the square of the edges' ratio.
    grown = (edges_b / edges_a) ** 2
    sum_a = (_pieces(a, trunks_a, rows_a, k)[:, None] * grown).sum(axis=2)
    sum_b = (_pieces(b, trunks_b, rows_b, (s - 1 - k) % n)[None] / grown).sum(axis=2)
    deficit = np.maximum(np.abs(trunks_b.areas[rows_b] - sum_a), np.abs(trunks_a.areas[rows_a, None] - sum_b))
    return np.maximum(terms, deficit / parameters.sigma_area), terms


def _pieces(shape: Shape, trunks: Trunks, rows: IntArray, edges: IntArray) -> FloatArray:
    """(rows, edges) signed areas of the exterior pieces on edges of trunks that have equally many."""
    n, running = len(edges), swept_area(shape.points)
    offsets = trunks.offsets[rows, None]
    start, stop = trunks.vertices[offsets + edges], trunks.vertices[offsets + (edges + 1) % n]
    swept = running[stop] - running[start] + np.where(stop < start, running[-1], 0.0)
    (x0, y0), (x1, y1) = np.moveaxis(shape.points[start], 2, 0), np.moveaxis(shape.points[stop], 2, 0)
    areas: FloatArray = swept + 0.5 * (x1 * y0 - y1 * x0)
    return areas
