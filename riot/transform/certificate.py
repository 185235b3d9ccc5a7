"""The certificate of an exact transform, and how far it is from its inputs (theory §8)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from riot.transform.pose import Pose, direction
from riot.transform.transform import Transform
from riot.types import FloatArray
from riot.units import L_C

AREA_TOLERANCE = 1e-9
"""Greatest overlap, and greatest difference of areas, that a certificate accepts (unit-area shapes)."""

HINGE_TOLERANCE = 1e-12
"""Greatest distance between the two pieces' ideas of one hinge that a certificate accepts."""

LEAST_CHANGE = 1e-4
"""Bounds of the IoU are no more accurate: changes are not compared with less."""

SAMPLE_STEP = L_C / 400
"""Outlines are compared at points this far apart."""


@dataclass(frozen=True)
class Assembly:
    """What was verified of one closed chain; residuals are areas or lengths of unit-area shapes.

    ``overlap`` = Σ piece areas − area of their union; ``gap`` = area within the outline − area of the union;
    ``hinge`` = greatest distance between two pieces' ends that a hinge joins, the closing one too; ``simple``: the
    outline neither touches nor crosses itself, and no piece does. Where one does, areas are of what it encloses an odd
    number of times (`shapely.make_valid`), and say how far off the assembly is, which fails in any case.
    """

    overlap: float
    gap: float
    hinge: float
    simple: bool

    @property
    def failures(self) -> tuple[str, ...]:
        """Which checks fail, in words."""
        checks = (
            (abs(self.overlap) >= AREA_TOLERANCE, f"pieces overlap by {self.overlap:.2g}"),
            (abs(self.gap) >= AREA_TOLERANCE, f"pieces leave gaps of {self.gap:.2g}"),
            (self.hinge >= HINGE_TOLERANCE, f"hinges miss by {self.hinge:.2g}"),
            (not self.simple, "the outline touches or crosses itself"),
        )
        return tuple(words for failed, words in checks if failed)


@dataclass(frozen=True)
class Certificate:
    """The two assemblies of a transform, verified."""

    p: Assembly
    q: Assembly

    @property
    def passed(self) -> bool:
        """All residuals within `AREA_TOLERANCE` and `HINGE_TOLERANCE`, both outlines simple."""
        return not self.p.failures and not self.q.failures

    @property
    def failure(self) -> str:
        """Which checks fail, in words; empty if none does."""
        said = [f"P: {words}" for words in self.p.failures] + [f"Q: {words}" for words in self.q.failures]
        return "; ".join(said)

    @property
    def residual(self) -> float:
        """The greatest of all area residuals."""
        return max(abs(area) for side in (self.p, self.q) for area in (side.overlap, side.gap))


@dataclass(frozen=True)
class Deformation:
    """How far the two assembled shapes are from the inputs; distances in units of ``L_c``."""

    iou_p: float
    iou_q: float
    hausdorff_p: float
    hausdorff_q: float
    mean_distance_p: float
    mean_distance_q: float

    @property
    def iou(self) -> float:
        """Of the worse shape."""
        return min(self.iou_p, self.iou_q)


def certify(transform: Transform) -> Certificate:
    """Verify that the pieces tile P's outline and Q's, with hinges that meet (theory §8).

    Areas are compared as Σ area(piece) − area(∪ piece), never through intersections, which are unreliable between
    polygons that share a noisy edge.
    """
    return Certificate(
        _assembly(transform, transform.pose(0.0), transform.outline_p()),
        _assembly(transform, transform.pose(1.0), transform.outline_q()),
    )


def _assembly(transform: Transform, pose: Pose, outline: FloatArray) -> Assembly:
    polygons = transform.parts(pose)
    owner = np.repeat(np.arange(len(polygons)), [len(polygon) for polygon in polygons])
    parts = shapely.polygons(shapely.linearrings(np.concatenate(polygons), indices=owner))
    ring = shapely.linearrings(outline)
    region = shapely.polygons(ring)
    simple = bool(shapely.is_simple(ring)) and bool(shapely.is_valid(parts).all())
    if not simple:
        parts, region = shapely.make_valid(parts), shapely.make_valid(region)
    union = shapely.union_all(parts).area
    total = float(sum(shapely.area(parts).tolist()))
    return Assembly(total - union, float(shapely.area(region)) - union, _hinge_error(transform, pose), simple)


def _hinge_error(transform: Transform, pose: Pose) -> float:
    worst = 0.0
    n = len(transform)
    for i, piece in enumerate(transform.pieces):
        end = pose.origins[i] + piece.length * direction(float(pose.headings[i]))
        worst = max(worst, float(np.linalg.norm(end - pose.origins[(i + 1) % n])))
    return worst


def measure(transform: Transform) -> Deformation:
    """IoU, symmetric Hausdorff and mean boundary distance of both assemblies to the inputs."""
    far_p, mean_p = boundary_distance(transform.outline_p(), transform.p.points)
    far_q, mean_q = boundary_distance(transform.outline_q(), transform.q.points)
    return Deformation(*transform.overlap_ratios, far_p, far_q, mean_p, mean_q)


def change_ratio(iou: float, bound: float) -> float:
    """(1 − IoU) / (1 − bound): how much a shape changes, over the least that its trunks allow (theory §8, ours).

    1 is as good as an exact construction can be. nan where the bound is as near to 1 as its scanlines can tell.
    """
    return (1.0 - iou) / (1.0 - bound) if 1.0 - bound > LEAST_CHANGE else math.nan


def boundary_distance(outline: FloatArray, reference: FloatArray) -> tuple[float, float]:
    """(symmetric Hausdorff, symmetric mean distance) of two closed polygons' boundaries, in units of ``L_c``."""
    there = _distances(outline, reference)
    back = _distances(reference, outline)
    far = max(float(there.max()), float(back.max()))
    return far / L_C, 0.5 * float(there.mean() + back.mean()) / L_C


def overlap_ratio(outline: FloatArray, reference: FloatArray) -> float:
    """IoU of the regions inside two closed polygons; what a crossing outline encloses is made valid first."""
    regions = [shapely.make_valid(shapely.polygons(points)) for points in (outline, reference)]
    a, b, union = shapely.area([*regions, shapely.union(*regions)]).tolist()
    return float((a + b - union) / union)


def _distances(outline: FloatArray, reference: FloatArray) -> FloatArray:
    """From points of one boundary, its vertices among them, to another's."""
    ring = shapely.LinearRing(outline)
    count = max(16, int(np.ceil(ring.length / SAMPLE_STEP)))
    samples = shapely.line_interpolate_point(ring, np.arange(count) / count, normalized=True)
    target = shapely.LinearRing(reference)
    shapely.prepare(target)
    found: FloatArray = shapely.distance(np.concatenate([samples, shapely.points(outline)]), target)
    return found
