"""CRS: best-first = brute force, the area term = exact overlay, exact pairs score high (paper §4.2)."""

from __future__ import annotations

import importlib.util
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import shapely
from blobs import blob, pair_shapes

from riot.geometry.shape import Shape
from riot.groundtruth.pairs import exact_pair
from riot.kernels.candidates import Units, leaf_pairs, nearest_candidates
from riot.kernels.coverage import area_terms, swung_arcs, uncovered
from riot.parameters import CrsParameters
from riot.scores.crs import AREA_SLACK, NO_SCORE, best_of_prepared, best_trunk_pairs, crs, gaussian, prepare
from riot.scores.qcrs import corresponding
from riot.scores.trunks import Trunks, full_trunks
from riot.units import D_C


def benchmark(name: str) -> ModuleType:
    """A module of the benchmarks, which are no package."""
    path = Path(__file__).parents[2] / "benchmarks" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


overlay = benchmark("overlay")


def overlaid(target: np.ndarray, arcs: np.ndarray, offsets: np.ndarray) -> tuple[float, float, float]:
    """Gaps, overlaps and outside by exact polygon overlay; the regions must be simple polygons."""
    trunk = shapely.Polygon(target)
    regions = [shapely.Polygon(arcs[offsets[k] : offsets[k + 1]]) for k in range(len(target))]
    assert all(region.is_valid for region in regions)
    inside = [region.intersection(trunk) for region in regions]
    covered = shapely.union_all(inside).area
    outside = sum(region.difference(trunk).area for region in regions)
    return trunk.area - covered, sum(region.area for region in inside) - covered, outside


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
        exact = overlaid(target, arcs, offsets)
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


def plain_candidates(
    a: Shape, b: Shape, trunks_a: Trunks, trunks_b: Trunks, p: CrsParameters
) -> Iterator[tuple[int, int, int, float]]:
    """(T, T', shift) of every candidate, with max(d_E/σ_E, d_∠/σ_∠), corner by corner (paper eqs. 3, 4)."""
    betas_a, betas_b = trunks_a.betas, trunks_b.betas
    for t in range(len(trunks_a)):
        for u in range(len(trunks_b)):
            n = int(trunks_a.sizes[t])
            if trunks_b.sizes[u] != n:
                continue
            x, y = int(trunks_a.offsets[t]), int(trunks_b.offsets[u])
            for s in range(n):
                edge, angle = 0.0, 0.0
                for j in range(n):
                    k = (s - j) % n
                    edge += abs(trunks_a.edges[x + j] - trunks_b.edges[y + (k - 1) % n])
                    angle += abs(betas_a[x + j] - trunks_b.alphas[y + k]) + abs(trunks_a.alphas[x + j] - betas_b[y + k])
                edge *= 1.0 / (n * p.sigma_e * D_C)
                yield t, u, s, float(max(edge, angle * (1.0 / (2.0 * n * p.sigma_angle))))


def brute_crs(
    a: Shape, b: Shape, trunks_a: Trunks, trunks_b: Trunks, p: CrsParameters
) -> list[tuple[float, tuple[int, int, int], float]]:
    """(distance, (T, T', shift), d_A) of all candidates, in order: the reference without pruning."""
    candidates = []
    for t, u, s, terms in plain_candidates(a, b, trunks_a, trunks_b, p):
        corners_b = np.ascontiguousarray(corresponding(trunks_b.of(u), s)[None])
        area = float(area_terms(a.points, b.points, trunks_a.of(t)[None], corners_b, p.lines).max())
        candidates.append((max(terms, area / p.sigma_area), (t, u, s), area))
    return sorted(candidates)


def thinned(trunks: Trunks, count: int, times: int = 1) -> Trunks:
    """Every so manieth trunk, to keep brute force short; each several ``times``."""
    return selected(trunks, np.repeat(np.unique(np.linspace(0, len(trunks) - 1, count).astype(int)), times))


def of_size(trunks: Trunks, n: int) -> Trunks:
    return selected(trunks, np.flatnonzero(trunks.sizes == n))


def selected(trunks: Trunks, chosen: np.ndarray) -> Trunks:
    rows = np.concatenate([np.arange(trunks.offsets[t], trunks.offsets[t + 1]) for t in chosen])
    offsets = np.concatenate([[0], np.cumsum(trunks.sizes[chosen])]).astype(np.int64)
    per_corner = (trunks.vertices[rows], trunks.edges[rows], trunks.alphas[rows], trunks.thetas[rows])
    return Trunks(offsets, *per_corner, trunks.areas[chosen])


@pytest.mark.parametrize(("one", "other"), [(1, 2), (3, 4), (5, 6), (7, 7)])
def test_best_first_crs_equals_brute_force(one: int, other: int) -> None:
    a, b = blob(one), blob(other)
    trunks_a, trunks_b = thinned(full_trunks(a), 25), thinned(full_trunks(b), 25)
    expected = brute_crs(a, b, trunks_a, trunks_b, CrsParameters())[:16]
    scores = best_trunk_pairs(a, b, trunks_a, trunks_b, count=16)
    assert [score.area for score in scores] == [area for _, _, area in expected]
    assert [score.score for score in scores] == pytest.approx([gaussian(far, 1.0) for far, _, _ in expected], rel=1e-12)
    for score, (_, (t, u, s), _) in zip(scores, expected, strict=True):
        assert np.array_equal(score.trunk_a, trunks_a.of(t))
        assert np.array_equal(score.trunk_b, corresponding(trunks_b.of(u), s))
    best = crs(a, b, trunks_a, trunks_b)
    assert best.score == scores[0].score > 0.0
    assert np.array_equal(best.trunk_b, scores[0].trunk_b)


def test_equals_come_in_order_of_trunks_and_shift() -> None:
    # Every trunk four times, so that every candidate has fifteen equals.
    a, b = blob(1), blob(2)
    trunks_a, trunks_b = (thinned(full_trunks(shape), 3, times=4) for shape in (a, b))
    expected = brute_crs(a, b, trunks_a, trunks_b, CrsParameters())[:30]
    side_a, side_b = prepare(a, trunks_a), prepare(b, trunks_b)
    scores = best_of_prepared(side_a, side_b, count=30)
    assert len({far for far, _, _ in expected}) < 5
    assert [score.area for score in scores] == [area for _, _, area in expected]
    for score, (_, (t, u, s), _) in zip(scores, expected, strict=True):
        assert np.array_equal(score.trunk_a, trunks_a.of(t))
        assert np.array_equal(score.trunk_b, corresponding(trunks_b.of(u), s))


@pytest.mark.parametrize("limit", [1.0, 1.6, math.inf])
def test_all_candidates_within_the_limit_are_listed(limit: float) -> None:
    a, b, p = blob(1), blob(4), CrsParameters()
    trunks_a, trunks_b = thinned(full_trunks(a), 60), thinned(full_trunks(b), 60)
    side_a, side_b = prepare(a, trunks_a).side, prepare(b, trunks_b).side
    units = Units(p.sigma_e * D_C, p.sigma_angle, p.sigma_area, AREA_SLACK)
    bounds, pairs = leaf_pairs(side_a, side_b, units)
    order = np.argsort(bounds)
    candidates, which = np.empty((100_000, 2)), np.empty((100_000, 3), dtype=np.int64)
    count, reached = nearest_candidates(
        side_a, side_b, units, bounds[order], pairs[order], -math.inf, limit, candidates, which
    )
    assert reached == limit
    expected = {(t, u, s): terms for t, u, s, terms in plain_candidates(a, b, trunks_a, trunks_b, p)}
    exact = {
        triple: bound
        for bound, _, triple in overlay.candidates(a, b, trunks_a, trunks_b, p, -math.inf, math.inf)
        if bound <= limit
    }
    listed = {(int(t), int(u), int(s)): row for (t, u, s), row in zip(which[:count], candidates[:count], strict=True)}
    assert len(listed) == count > 0
    assert all(expected[triple] == terms for triple, (_, terms) in listed.items())
    # The area term's bound is lowered by the slack of the scanlines: some more are listed, none fewer.
    assert exact.keys() <= listed.keys()
    assert all(bound <= limit for bound, _ in listed.values())
    for triple, bound in exact.items():
        assert listed[triple][0] == pytest.approx(max(expected[triple], bound - AREA_SLACK / p.sigma_area), abs=1e-9)
        assert listed[triple][0] <= bound + 1e-12
    # What was listed before is not listed again.
    if limit < math.inf:
        again = nearest_candidates(
            side_a, side_b, units, bounds[order], pairs[order], limit, 2.0 * limit, candidates, which
        )[0]
        assert not listed.keys() & {(int(t), int(u), int(s)) for t, u, s in which[:again]}


@pytest.mark.parametrize(("one", "other"), [(1, 2), (3, 8), (9, 9)])
def test_area_terms_match_overlay_within_the_slack(one: int, other: int) -> None:
    a, b = blob(one), blob(other, waves=7)
    trunks_a, trunks_b = thinned(full_trunks(a), 80), thinned(full_trunks(b), 80)
    pairs = best_trunk_pairs(a, b, trunks_a, trunks_b, count=16)
    for score in pairs:
        exact = overlay.overlay_area_term(a.points, b.points, score.trunk_a, score.trunk_b)
        assert score.area == pytest.approx(exact, abs=AREA_SLACK / 2)
        terms = area_terms(a.points, b.points, score.trunk_a[None], score.trunk_b[None], 4096)
        assert terms.max() == pytest.approx(exact, abs=1e-4)
    by_overlay = overlay.overlay_best_trunk_pairs(a, b, trunks_a, trunks_b, count=16)
    scores = [math.exp(-0.5 * score.distance**2) for score in by_overlay]
    assert [score.score for score in pairs] == pytest.approx(scores, abs=AREA_SLACK / CrsParameters().sigma_area)


def test_shapes_without_trunks_of_one_n_have_no_trunk_pair() -> None:
    a, trunks_a = blob(1), full_trunks(blob(1))
    none = Trunks.from_arrays({name: values[: name == "offsets"] for name, values in trunks_a.to_arrays().items()})
    assert best_trunk_pairs(a, a, trunks_a, none) == []
    assert crs(a, a, none, none) is NO_SCORE
    triangles, squares = (of_size(trunks_a, n) for n in (3, 4))
    assert len(triangles) > 0
    assert len(squares) > 0
    assert best_trunk_pairs(a, a, triangles, squares) == []


@pytest.mark.parametrize("capacity", [1, 2, 7, 100_000])
def test_the_capacity_for_candidates_changes_nothing(capacity: int, monkeypatch: pytest.MonkeyPatch) -> None:
    a, b = blob(1), blob(2)
    trunks_a, trunks_b = thinned(full_trunks(a), 40), thinned(full_trunks(b), 40)
    expected = best_trunk_pairs(a, b, trunks_a, trunks_b, count=5)
    monkeypatch.setattr("riot.scores.crs.FIRST_LISTED", capacity)
    scores = best_trunk_pairs(a, b, trunks_a, trunks_b, count=5)
    assert [score.score for score in scores] == [score.score for score in expected]
    assert all(np.array_equal(x.trunk_b, y.trunk_b) for x, y in zip(scores, expected, strict=True))
    # More than there are: all of them, whatever their distance.
    few_a, few_b = thinned(full_trunks(a), 2), thinned(full_trunks(b), 2)
    everything = best_trunk_pairs(a, b, few_a, few_b, count=1000)
    assert len(everything) == sum(int(n) for n in few_a.sizes for other in few_b.sizes if other == n)
    with pytest.raises(ValueError, match="one pair at least"):
        best_trunk_pairs(a, b, few_a, few_b, count=0)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_exact_pairs_score_high(seed: int) -> None:
    p, q = pair_shapes(exact_pair(4, seed))
    best = crs(p, q)
    assert best.score > 0.85
    assert best.area < 0.1


def test_best_trunks_correspond() -> None:
    p, q = pair_shapes(exact_pair(4, 2))
    best = crs(p, q)
    corners_p, corners_q = p.points[best.trunk_a], q.points[best.trunk_b]
    lengths = [np.hypot(*(np.roll(corners, -1, axis=0) - corners).T) for corners in (corners_p, corners_q)]
    assert np.abs(lengths[0] - lengths[1]).mean() < 0.05
    assert shapely.LinearRing(corners_p).is_ccw
    assert not shapely.LinearRing(corners_q).is_ccw
