"""Triangulate the inside of an outline, evenly, with all its edges (theory §9). Ours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import shapely
from scipy.spatial import Delaunay

from riot.draw.texture.outline_match import WarpError
from riot.draw.texture.tuning import OUTLINE_DISTANCE, SPLIT_ROUNDS, WARP_SPACING

if TYPE_CHECKING:
    from riot.types import FloatArray, IntArray


def triangulate(outline: FloatArray, images: FloatArray) -> tuple[FloatArray, FloatArray, IntArray, int]:
    """Points, images (of the boundary), triangles and the number of boundary points of a triangulated outline.

    Delaunay's, with edges of the outline split in the middle until all are there.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> points, images, triangles, boundary = triangulate(square, 2.0 * square)
    >>> round(float(signed_areas(points, triangles).sum()), 9), len(images) == boundary
    (1.0, True)
    """
    inner = _grid(outline)
    for turn in range(SPLIT_ROUNDS):
        m = len(outline)
        points = np.concatenate([outline, inner])
        triangles = _inside(points, Delaunay(points).simplices.astype(np.int64), outline)
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        rim = np.sort(np.column_stack([np.arange(m), (np.arange(m) + 1) % m]), axis=1)
        size = len(points)
        missing = ~np.isin(rim[:, 0] * size + rim[:, 1], edges[:, 0] * size + edges[:, 1])
        # An inner edge between two boundary points could not bend; its middle becomes a point.
        chords = np.unique(edges[(edges < m).all(axis=1)], axis=0)
        chords = chords[~np.isin(chords[:, 0] * size + chords[:, 1], rim[:, 0] * size + rim[:, 1])]
        if not missing.any() and (len(chords) == 0 or turn > SPLIT_ROUNDS // 2):
            return points, images, triangles, m
        if missing.any():
            edges_to_split = np.flatnonzero(missing)
            outline = _halved(outline, edges_to_split)
            images = _halved(images, edges_to_split)
        elif len(chords):
            inner = np.concatenate([inner, 0.5 * (outline[chords[:, 0]] + outline[chords[:, 1]])])
    raise WarpError("the outline that the pieces make is too sharp to be triangulated")


def _halved(points: FloatArray, edges: IntArray) -> FloatArray:
    """A polygon with the middles of some ``edges`` as further vertices."""
    middles = 0.5 * (points[edges] + points[(edges + 1) % len(points)])
    return np.insert(points, edges + 1, middles, axis=0)


def _grid(outline: FloatArray) -> FloatArray:
    """(k, 2) a triangular grid inside, not near the outline."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    rise = 0.5 * np.sqrt(3.0) * WARP_SPACING
    rows = np.arange(int((high[1] - low[1]) / rise) + 1)
    columns = np.arange(int((high[0] - low[0]) / WARP_SPACING) + 2)
    x = low[0] + WARP_SPACING * (columns[None] - 0.5 * (rows % 2)[:, None])
    y = np.broadcast_to((low[1] + rise * (rows + 0.5))[:, None], x.shape)
    points = np.column_stack([x.ravel(), y.ravel()])
    region = shapely.Polygon(outline)
    shapely.prepare(region)
    points = points[shapely.contains_xy(region, points)]
    ring = shapely.LinearRing(outline)
    shapely.prepare(ring)
    kept: FloatArray = points[shapely.distance(ring, shapely.points(points)) > OUTLINE_DISTANCE * WARP_SPACING]
    return kept


def _inside(points: FloatArray, triangles: IntArray, outline: FloatArray) -> IntArray:
    """The triangles whose middles are inside the outline, counter-clockwise."""
    region = shapely.Polygon(outline)
    shapely.prepare(region)
    triangles = triangles[shapely.contains_xy(region, points[triangles].mean(axis=1))]
    turned = signed_areas(points, triangles) < 0.0
    triangles[turned] = triangles[turned][:, ::-1]
    return triangles[signed_areas(points, triangles) > 1e-14]


def signed_areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    """(t,) areas of triangles (t, 3) among points (k, 2), negative where they are clockwise.

    >>> corners = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]])
    >>> signed_areas(corners, np.array([[0, 1, 2], [0, 2, 1]])).tolist()
    [1.0, -1.0]
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    sizes: FloatArray = 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))
    return sizes


def barycentric(corners: FloatArray, xy: FloatArray) -> FloatArray:
    """(m, 3) weights of points in their triangles, (m, 3, 2).

    >>> corners = np.array([[[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]])
    >>> barycentric(corners, np.array([[1.0, 2.0]])).tolist()
    [[0.25, 0.25, 0.5]]
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]

    def cross(u: FloatArray, v: FloatArray) -> FloatArray:
        return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]

    whole = cross(b - a, c - a)
    second, third = cross(xy - a, c - a) / whole, cross(b - a, xy - a) / whole
    return np.column_stack([1.0 - second - third, second, third])
