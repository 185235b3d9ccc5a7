"""Measure the deformation of a transform: how far its two assemblies are from the inputs (theory §8)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from riot.transform.transform import Transform
from riot.transform.transform_cache import once_per_transform
from riot.transform.tuning import BOUNDARY_SAMPLE_STEP, LEAST_BOUNDARY_SAMPLES, LEAST_CHANGE
from riot.types import FloatArray
from riot.units import L_C


@dataclass(frozen=True)
class Deformation:
    """How far the two assembled shapes are from the inputs; distances in units of ``L_c``.

    Inputs that were bent first count as they are bent: IoU and distances tell what cutting costs. What bending costs
    stands beside it: the strains (`riot.geometry.bend.Bend`), and the IoU with the inputs themselves, of which a limb
    that stands a little elsewhere takes much away. Without a bend there is no strain, and both IoUs are the same.
    """

    iou_p: float
    iou_q: float
    hausdorff_p: float
    hausdorff_q: float
    mean_distance_p: float
    mean_distance_q: float
    input_iou_p: float
    input_iou_q: float
    rms_strain_p: float
    rms_strain_q: float
    max_strain_p: float
    max_strain_q: float

    @property
    def iou(self) -> float:
        """Of the worse shape."""
        return min(self.iou_p, self.iou_q)

    @property
    def bent(self) -> bool:
        """Whether an input is bent."""
        return max(self.max_strain_p, self.max_strain_q) > 0.0


def overlap_ratios(transform: Transform) -> tuple[float, float]:
    """IoU of the assembled P with P, and of the assembled Q with Q, as they are bent; computed once for each transform.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> min(overlap_ratios(exact_transform(dudeney()))) > 1 - 1e-9
    True
    """
    return _overlap_ratios(transform)


@once_per_transform
def _overlap_ratios(transform: Transform) -> tuple[float, float]:
    return (
        overlap_ratio(transform.outline_p(), transform.p.points),
        overlap_ratio(transform.outline_q(), transform.q.points),
    )


def measure_deformation(transform: Transform) -> Deformation:
    """Measure IoU, symmetric Hausdorff and mean boundary distance of both assemblies to the inputs (theory §8).

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> measure_deformation(exact_transform(dudeney())).hausdorff_p < 1e-9
    True
    """
    far_p, mean_p = boundary_distance(transform.outline_p(), transform.p.points)
    far_q, mean_q = boundary_distance(transform.outline_q(), transform.q.points)
    bends = transform.bend_p, transform.bend_q
    return Deformation(
        *overlap_ratios(transform), far_p, far_q, mean_p, mean_q,
        *input_overlap_ratios(transform),
        *(0.0 if bend is None else bend.rms_strain for bend in bends),
        *(0.0 if bend is None else bend.max_strain for bend in bends),
    )  # fmt: skip


def input_overlap_ratios(transform: Transform) -> tuple[float, float]:
    """IoU of the assembled P with P, and of the assembled Q with Q, as they were before they were bent.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> min(input_overlap_ratios(exact_transform(dudeney()))) > 1 - 1e-9
    True
    """
    if transform.bend_p is None and transform.bend_q is None:
        return overlap_ratios(transform)
    return (
        overlap_ratio(transform.outline_p(), transform.input_p.points),
        overlap_ratio(transform.outline_q(), transform.input_q.points),
    )


def change_ratio(iou: float, bound: float) -> float:
    """(1 − IoU) / (1 − bound): how much a shape changes, over the least that its trunks allow (theory §8, ours).

    1 is as good as an exact construction can be. nan where the bound is as near to 1 as its scanlines can tell.

    >>> round(change_ratio(iou=0.94, bound=0.95), 3)
    1.2
    """
    return (1.0 - iou) / (1.0 - bound) if 1.0 - bound > LEAST_CHANGE else math.nan


def boundary_distance(outline: FloatArray, reference: FloatArray) -> tuple[float, float]:
    """(symmetric Hausdorff, symmetric mean distance) of two closed polygons' boundaries (m, 2), in units of ``L_c``.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> far, _ = boundary_distance(square, square + [L_C / 10, 0.0])
    >>> round(far, 3)
    0.1
    """
    there = _distances(outline, reference)
    back = _distances(reference, outline)
    far = max(float(there.max()), float(back.max()))
    return far / L_C, 0.5 * float(there.mean() + back.mean()) / L_C


def overlap_ratio(outline: FloatArray, reference: FloatArray) -> float:
    """IoU of the regions inside two closed polygons (m, 2); what a crossing outline encloses is made valid first.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> round(overlap_ratio(square, square * [2.0, 1.0]), 3)
    0.5
    """
    regions = [shapely.make_valid(shapely.polygons(points)) for points in (outline, reference)]
    a, b, union = shapely.area([*regions, shapely.union(*regions)]).tolist()
    return float((a + b - union) / union)


def _distances(outline: FloatArray, reference: FloatArray) -> FloatArray:
    """Distances from points of one boundary (m, 2), its vertices among them, to another (k, 2)."""
    ring = shapely.LinearRing(outline)
    count = max(LEAST_BOUNDARY_SAMPLES, int(np.ceil(ring.length / BOUNDARY_SAMPLE_STEP)))
    samples = shapely.line_interpolate_point(ring, np.arange(count) / count, normalized=True)
    target = shapely.LinearRing(reference)
    shapely.prepare(target)
    distances: FloatArray = shapely.distance(np.concatenate([samples, shapely.points(outline)]), target)
    return distances
