"""QCRS and CRS: fast = brute force, the area term = exact overlay, exact pairs score high (paper §4.2, §5.2)."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from blobs import blob, pair_shapes
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.cross import best_trunk_pairs, crs, gaussian
from riot.groundtruth import exact_pair
from riot.kernels.coverage import area_terms, swung_arcs, uncovered
from riot.parameters import D_C, CrsParameters, QcrsParameters
from riot.quick import TrunkStack, brute_force, corresponding, qcrs, score_block, stack
from riot.shape import Shape
from riot.trunks import Trunks, full_trunks, quick_trunks

SEEDS = st.integers(0, 10_000)


def random_trunks(rng: np.random.Generator, count: int, coarse: bool) -> Trunks:
    """Trunk data without a shape, angles summing as a polygon's must; ``coarse`` rounds it, so that ties are common."""
    sizes = np.sort(rng.integers(3, 7, count))
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    total = int(offsets[-1])
    areas = rng.uniform(0.2, 0.8, count)
    edges, bends, thetas = rng.uniform(0.2, 1.0, total), rng.uniform(0.2, 1.0, total), rng.uniform(2.0, 5.0, total)
    if coarse:
        areas, edges, bends, thetas = np.round(areas, 1), np.round(edges, 1), np.ones(total), np.round(thetas, 1)
    trunk = np.repeat(np.arange(count), sizes)
    alphas = math.pi - 2.0 * math.pi * bends / np.bincount(trunk, bends, count)[trunk]
    data = [edges, alphas, thetas]
    areas = np.concatenate([np.sort(areas[sizes == n]) for n in np.unique(sizes)]) if count else areas
    return Trunks(offsets.astype(np.int64), np.zeros(total, dtype=np.int32), *data, areas)


def random_stack(seed: int, shapes: int, coarse: bool) -> TrunkStack:
    rng = np.random.default_rng(seed)
    return stack([random_trunks(rng, int(rng.integers(0, 12)), coarse) for _ in range(shapes)])


@given(SEEDS, st.booleans())
@settings(max_examples=40, deadline=None)
def test_pruned_qcrs_equals_brute_force(seed: int, coarse: bool) -> None:
    a, b = random_stack(seed, 4, coarse), random_stack(seed + 1, 3, coarse)
    fast, slow = score_block(a, b), brute_force(a, b)
    for name in ("i", "j", "score", "n", "trunk_i", "trunk_j", "shift"):
        assert np.array_equal(getattr(fast, name), getattr(slow, name)), name


def test_pruned_qcrs_equals_brute_force_on_shapes() -> None:
    trunks = stack([quick_trunks(blob(seed, waves=6)) for seed in range(5)])
    fast, slow = score_block(trunks, trunks, same=True), brute_force(trunks, trunks, same=True)
    assert len(fast.i) == 10
    assert (fast.i < fast.j).all()
    assert fast.score.max() > 0.3
    for name in ("score", "n", "trunk_i", "trunk_j", "shift"):
        assert np.array_equal(getattr(fast, name), getattr(slow, name)), name


def plain_qcrs(a: Trunks, t: int, b: Trunks, u: int, shift: int, p: QcrsParameters) -> float:
    """The score as the paper writes it, corner by corner (eqs. 3, 4, 6; §5.2)."""
    n = int(a.sizes[t])
    x, y = int(a.offsets[t]), int(b.offsets[u])
    edge, angle = 0.0, 0.0
    for j in range(n):
        k = (shift - j) % n
        # Edge j runs from corner j to corner j + 1, hence from corner k to corner k − 1 of the other trunk.
        edge += abs(a.edges[x + j] - b.edges[y + (k - 1) % n])
        omega = a.thetas[x + j] + a.alphas[x + j] + b.alphas[y + k]
        omega_bar = b.thetas[y + k] + b.alphas[y + k] + a.alphas[x + j]
        angle += abs(2.0 * math.pi - omega) + abs(2.0 * math.pi - omega_bar)
    area = abs(a.areas[t] - (1.0 - b.areas[u])) + abs(b.areas[u] - (1.0 - a.areas[t]))
    return min(
        gaussian(edge / n, p.sigma_e * D_C), gaussian(angle / (2 * n), p.sigma_angle), gaussian(area, p.sigma_area)
    )


@given(SEEDS)
@settings(max_examples=10, deadline=None)
def test_qcrs_is_the_best_of_the_papers_formula(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = random_trunks(rng, 5, False), random_trunks(rng, 6, False)
    parameters = QcrsParameters()
    best = max(
        (
            plain_qcrs(a, t, b, u, s, parameters)
            for t in range(len(a))
            for u in range(len(b))
            if a.sizes[t] == b.sizes[u]
            for s in range(int(a.sizes[t]))
        ),
        default=0.0,
    )
    assert score_block(stack([a]), stack([b]), parameters).score[0] == pytest.approx(best, rel=1e-9, abs=1e-300)


@given(SEEDS)
@settings(max_examples=15, deadline=None)
def test_qcrs_does_not_depend_on_the_order_of_the_pair(seed: int) -> None:
    a, b = random_stack(seed, 3, False), random_stack(seed + 7, 3, False)
    there, back = score_block(a, b), score_block(b, a)
    swapped = back.score.reshape(3, 3).T.ravel()
    assert there.score == pytest.approx(swapped, rel=1e-9, abs=1e-300)


def test_pairs_without_a_common_n_score_nothing() -> None:
    empty = stack([Trunks.from_arrays(full_trunks(blob(1)).to_arrays())]), stack([])
    assert len(score_block(*empty).i) == 0
    none = random_trunks(np.random.default_rng(0), 0, False)
    found = score_block(stack([none]), stack([none]))
    assert (found.score[0], found.n[0], found.trunk_i[0], found.shift[0]) == (0.0, 0, -1, -1)


def overlay(target: np.ndarray, arcs: np.ndarray, offsets: np.ndarray) -> tuple[float, float, float]:
    """Gaps, overlaps and outside by exact polygon overlay; the regions must be simple polygons."""
    trunk = shapely.Polygon(target)
    regions = [shapely.Polygon(arcs[offsets[k] : offsets[k + 1]]) for k in range(len(target))]
    assert all(region.is_valid for region in regions)
    inside = [region.intersection(trunk) for region in regions]
    covered = shapely.union_all(inside).area
    outside = sum(region.difference(trunk).area for region in regions)
    return trunk.area - covered, sum(part.area for part in inside) - covered, outside


@pytest.mark.parametrize("seed", range(6))
def test_area_term_matches_exact_overlay(seed: int) -> None:
    pair = exact_pair(4, seed)
    p, q = pair_shapes(pair)
    trunks_p, trunks_q = full_trunks(p), full_trunks(q)
    compared = 0
    for score in best_trunk_pairs(p, q, trunks_p, trunks_q, count=12):
        target = q.points[score.trunk_b]
        arcs, offsets = np.empty((len(p.points) + score.n, 2)), np.empty(score.n + 1, dtype=np.int64)
        swung_arcs(p.points, score.trunk_a, target, arcs, offsets)
        if not all(shapely.Polygon(arcs[offsets[k] : offsets[k + 1]]).is_valid for k in range(score.n)):
            continue  # an arc that crosses its own trunk edge; the winding test below covers it
        exact = overlay(target, arcs, offsets)
        assert uncovered(target, arcs, offsets, 128) == pytest.approx(exact, abs=5e-4)
        assert uncovered(target, arcs, offsets, 4096) == pytest.approx(exact, abs=2e-5)
        compared += 1
    assert compared >= 3


def test_an_arc_that_dips_inside_the_trunk_counts_once() -> None:
    # The upper arc of a unit square dips below its edge in a notch of area 0.02, which lies outside once swung in.
    target = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])
    sides = [[[0, 0], [0.5, 0.5], [0, 1]], [[0, 1], [0.4, 1.0], [0.5, 1.2], [0.6, 1.0], [1, 1]]]
    sides += [[[1, 1], [0.5, 0.5], [1, 0]], [[1, 0], [0.5, 0.5], [0, 0]]]
    arcs = np.array([point for side in sides for point in side], dtype=float)
    offsets = np.array([0, 3, 8, 11, 14])
    gaps, overlaps, outside = uncovered(target, arcs, offsets, 4096)
    assert gaps == pytest.approx(0.25, abs=1e-3)
    assert overlaps == pytest.approx(0.0, abs=1e-3)
    assert outside == pytest.approx(0.02, abs=1e-3)


def brute_crs(a: Shape, b: Shape, trunks_a: Trunks, trunks_b: Trunks, p: CrsParameters) -> float:
    best = 0.0
    for t in range(len(trunks_a)):
        for u in range(len(trunks_b)):
            n = int(trunks_a.sizes[t])
            if trunks_b.sizes[u] != n:
                continue
            x, y = int(trunks_a.offsets[t]), int(trunks_b.offsets[u])
            for s in range(n):
                k = (s - np.arange(n)) % n
                edge = np.abs(trunks_a.edges[x : x + n] - trunks_b.edges[y + (k - 1) % n]).mean()
                omega = trunks_a.thetas[x : x + n] + trunks_a.alphas[x : x + n] + trunks_b.alphas[y + k]
                other = trunks_b.thetas[y + k] + trunks_b.alphas[y + k] + trunks_a.alphas[x : x + n]
                angle = (np.abs(2 * math.pi - omega) + np.abs(2 * math.pi - other)).mean() / 2
                corners_b = np.ascontiguousarray(corresponding(trunks_b.of(u), s)[None])
                area = area_terms(a.points, b.points, trunks_a.of(t)[None], corners_b, p.lines).max()
                terms = (edge, p.sigma_e * D_C), (angle, p.sigma_angle), (area, p.sigma_area)
                best = max(best, min(gaussian(float(d), sigma) for d, sigma in terms))
    return best


def thinned(trunks: Trunks, count: int) -> Trunks:
    """Every so manieth trunk, to keep brute force short."""
    chosen = np.unique(np.linspace(0, len(trunks) - 1, count).astype(int))
    rows = np.concatenate([np.arange(trunks.offsets[t], trunks.offsets[t + 1]) for t in chosen])
    offsets = np.concatenate([[0], np.cumsum(trunks.sizes[chosen])]).astype(np.int64)
    per_corner = (trunks.vertices[rows], trunks.edges[rows], trunks.alphas[rows], trunks.thetas[rows])
    return Trunks(offsets, *per_corner, trunks.areas[chosen])


@pytest.mark.parametrize(("one", "other"), [(1, 2), (3, 4), (5, 6)])
def test_best_first_crs_equals_brute_force(one: int, other: int) -> None:
    a, b = blob(one), blob(other)
    trunks_a, trunks_b = thinned(full_trunks(a), 25), thinned(full_trunks(b), 25)
    found = crs(a, b, trunks_a, trunks_b)
    assert found.score == pytest.approx(brute_crs(a, b, trunks_a, trunks_b, CrsParameters()), abs=1e-12)
    assert found.score > 0.0
    ranked = [score.score for score in best_trunk_pairs(a, b, trunks_a, trunks_b, count=10)]
    assert ranked == sorted(ranked, reverse=True)
    assert ranked[0] == found.score


@pytest.mark.parametrize("first_limit", [1e-3, 0.3, 5.0, math.inf])
def test_the_first_limit_changes_nothing(first_limit: float, monkeypatch: pytest.MonkeyPatch) -> None:
    a, b = blob(1), blob(2)
    trunks_a, trunks_b = thinned(full_trunks(a), 40), thinned(full_trunks(b), 40)
    expected = best_trunk_pairs(a, b, trunks_a, trunks_b, count=5)
    monkeypatch.setattr("riot.cross.FIRST_LIMIT", first_limit)
    found = best_trunk_pairs(a, b, trunks_a, trunks_b, count=5)
    assert [score.score for score in found] == [score.score for score in expected]
    assert all(np.array_equal(x.trunk_b, y.trunk_b) for x, y in zip(found, expected, strict=True))
    # More than there are: all of them, whatever their distance.
    few_a, few_b = thinned(full_trunks(a), 2), thinned(full_trunks(b), 2)
    everything = best_trunk_pairs(a, b, few_a, few_b, count=1000)
    assert len(everything) == sum(int(n) for n in few_a.sizes for other in few_b.sizes if other == n)
    with pytest.raises(ValueError, match="one pair at least"):
        best_trunk_pairs(a, b, few_a, few_b, count=0)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_exact_pairs_score_high(seed: int) -> None:
    p, q = pair_shapes(exact_pair(4, seed))
    assert qcrs(p, q).score > 0.8
    found = crs(p, q)
    assert found.score > 0.85
    assert found.area < 0.1


def test_found_trunks_correspond() -> None:
    p, q = pair_shapes(exact_pair(4, 2))
    for found in (qcrs(p, q), crs(p, q)):
        corners_p, corners_q = p.points[found.trunk_a], q.points[found.trunk_b]
        lengths = [np.hypot(*(np.roll(corners, -1, axis=0) - corners).T) for corners in (corners_p, corners_q)]
        assert np.abs(lengths[0] - lengths[1]).mean() < 0.05
        assert shapely.LinearRing(corners_p).is_ccw
        assert not shapely.LinearRing(corners_q).is_ccw
