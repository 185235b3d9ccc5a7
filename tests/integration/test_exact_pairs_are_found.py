"""The search meets ground truth: exact pairs score near one, at the trunks they were made from."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from riot import Shape, construct, crs, qcrs
from riot.geometry.silhouette import mask_shape
from riot.groundtruth.pairs import ExactPair, dudeney, exact_pair
from riot.parameters import RefineParameters
from riot.types import FloatArray


def shapes(pair: ExactPair) -> tuple[Shape, Shape]:
    return Shape.from_polygon(pair.p, "P"), Shape.from_polygon(pair.q, "Q")


def farthest(corners: FloatArray, expected: FloatArray) -> float:
    """Greatest distance of corresponding vertices, at the best of the cyclic starts."""
    return (
        min(float(np.hypot(*(np.roll(corners, k, axis=0) - expected).T).max()) for k in range(len(expected)))
        if corners.shape == expected.shape
        else float("inf")
    )


@pytest.mark.parametrize(("n", "seed"), [(3, 0), (4, 1), (5, 2), (6, 3)])
def test_quick_score_finds_the_trunks(n: int, seed: int) -> None:
    pair = exact_pair(n, seed)
    p, q = shapes(pair)
    score = qcrs(p, q)
    assert score.score > 0.99
    assert farthest(p.points[score.trunk_a], pair.trunk_p) < 0.06
    assert farthest(q.points[score.trunk_b], pair.trunk_q) < 0.06


@pytest.mark.parametrize(("n", "seed"), [(3, 0), (4, 1), (5, 2), (6, 3)])
def test_cross_score_and_construction_come_near(n: int, seed: int) -> None:
    p, q = shapes(exact_pair(n, seed))
    assert crs(p, q).score > 0.97
    transform = construct(p, q)
    assert transform.certificate().passed
    assert transform.deformation().iou > 0.97


@pytest.mark.parametrize("seed", range(3))
def test_construction_on_the_true_trunks_is_almost_exact(seed: int) -> None:
    pair = exact_pair(3 + seed, seed)
    p, q = shapes(pair)
    transform = construct(p, q, trunks=(pair.trunk_p, pair.trunk_q))
    assert transform.certificate().passed
    assert transform.deformation().iou > 0.999


def picture(polygon: FloatArray, side: int = 256) -> Shape:
    """The shape of a binary picture of a polygon."""
    low, extent = polygon.min(axis=0), np.ptp(polygon, axis=0).max()
    placed = shapely.Polygon((polygon - low) * ((side - 16) / extent) + 8.0)
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    return mask_shape(shapely.contains_xy(placed, x.ravel(), y.ravel()).reshape(side, side)[::-1])


@pytest.mark.parametrize("n", [3, 4, 5, 6])
def test_pictures_of_an_exact_pair_come_back_on_its_trunks(n: int) -> None:
    pair = exact_pair(n, 1)
    outlines, pictures = shapes(pair), (picture(pair.p), picture(pair.q))
    # Both frames are the same but for the pixels.
    trunks = outlines[0].from_source(pair.trunk_p), outlines[1].from_source(pair.trunk_q)
    transform = construct(*pictures, trunks=trunks)
    assert transform.certificate().passed
    assert min(transform.overlap_ratios) > 0.985
    kept = construct(*pictures, trunks=trunks, refinement=RefineParameters(sketched=0, refined=0))
    assert min(transform.overlap_ratios) >= min(kept.overlap_ratios) - 0.001


def test_dudeney_is_constructed_from_its_trunks() -> None:
    pair = dudeney()
    p, q = shapes(pair)
    transform = construct(p, q, trunks=(pair.trunk_p, pair.trunk_q))
    assert transform.certificate().passed
    assert transform.deformation().iou > 0.98
