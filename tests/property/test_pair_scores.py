"""QCRS: fast = brute force, exact pairs score high (paper §5.2)."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from blobs import blob, pair_shapes
from hypothesis import given, settings
from hypothesis import strategies as st

from riot.groundtruth.pairs import exact_pair
from riot.kernels.bounds import FEATURES, QCRS_LEAF
from riot.kernels.leaves import features
from riot.parameters import QcrsParameters
from riot.scores.crs import gaussian
from riot.scores.leaves import gather_leaves
from riot.scores.qcrs import brute_force, qcrs, score_block, score_pairs
from riot.scores.trunk_stack import TrunkStack, stack
from riot.scores.trunks import Trunks, full_trunks, quick_trunks
from riot.units import D_C

SEEDS = st.integers(0, 10_000)


NAMES = ("i", "j", "score", "n", "trunk_i", "trunk_j", "shift")


def random_trunks(rng: np.random.Generator, count: int, coarse: bool, most: int = 9) -> Trunks:
    """Trunk data without a shape, angles summing as a polygon's must; ``coarse`` rounds it, so that ties are common."""
    sizes = np.sort(rng.integers(3, most, count))
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


def random_stack(seed: int, shapes: int, coarse: bool, most: int = 12) -> TrunkStack:
    rng = np.random.default_rng(seed)
    return stack([random_trunks(rng, int(rng.integers(0, most)), coarse) for _ in range(shapes)])


@given(SEEDS, st.booleans())
@settings(max_examples=40)
def test_pruned_qcrs_equals_brute_force(seed: int, coarse: bool) -> None:
    a, b = random_stack(seed, 4, coarse), random_stack(seed + 1, 3, coarse)
    fast, slow = score_block(a, b), brute_force(a, b)
    for name in ("i", "j", "score", "n", "trunk_i", "trunk_j", "shift"):
        assert np.array_equal(getattr(fast, name), getattr(slow, name)), name


@given(SEEDS)
@settings(max_examples=8)
def test_pruned_qcrs_equals_brute_force_with_many_leaves(seed: int) -> None:
    # Hundreds of trunks a shape and few sizes: many leaves, more than one tile of boxes.
    rng = np.random.default_rng(seed)
    a, b = (stack([random_trunks(rng, 900, bool(seed % 2), 4 + seed % 3)]) for _ in range(2))
    fast, slow = score_block(a, b), brute_force(a, b)
    for name in NAMES:
        assert np.array_equal(getattr(fast, name), getattr(slow, name)), name


@given(SEEDS, st.floats(1e-3, 1e3), st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
@settings(max_examples=25)
def test_pruned_qcrs_equals_brute_force_for_any_sigmas(seed: int, edge: float, angle: float, area: float) -> None:
    a, b = random_stack(seed, 2, True, 60), random_stack(seed + 1, 2, False, 60)
    parameters = QcrsParameters(0.1 * edge, 0.5 * angle, 0.1 * area)
    fast, slow = score_block(a, b, parameters), brute_force(a, b, parameters)
    for name in NAMES:
        assert np.array_equal(getattr(fast, name), getattr(slow, name)), name


@given(SEEDS, st.sampled_from([0.0, 1e-6, 0.2, 0.6, 0.9, 1.0]))
@settings(max_examples=20)
def test_a_least_score_changes_nothing_above_it(seed: int, least: float) -> None:
    a, b = random_stack(seed, 4, bool(seed % 2), 40), random_stack(seed + 1, 4, bool(seed % 2), 40)
    everything, good = score_block(a, b), score_block(a, b, least=least)
    above = everything.score >= least
    for name in NAMES:
        assert np.array_equal(getattr(good, name)[above], getattr(everything, name)[above]), name
    rest = ~above & (good.score > 0)
    assert np.array_equal(good.score[rest], everything.score[rest])
    pairs = np.stack([everything.i, everything.j], axis=1).astype(np.int64)[::-1].copy()
    one_by_one = score_pairs(a, b, pairs, least=everything.score[::-1])
    assert np.array_equal(one_by_one.score[::-1], everything.score)


@given(SEEDS)
@settings(max_examples=15)
def test_leaves_contain_every_trunk_and_decide_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    trunks = [random_trunks(rng, int(count), bool(seed % 2)) for count in rng.integers(0, 120, 3)]
    for shape_trunks in trunks:
        leaves = gather_leaves(shape_trunks)
        assert np.array_equal(np.unique(leaves), np.arange(len(shape_trunks)))
        assert (shape_trunks.sizes[leaves] == shape_trunks.sizes[leaves[:, :1]]).all()
        assert (np.diff(shape_trunks.sizes[leaves[:, 0]]) >= 0).all()
    plain = []
    for shape_trunks in trunks:  # the trunks in the order in which they come, the most foolish leaves there are
        groups = [np.flatnonzero(shape_trunks.sizes == n).astype(np.int32) for n in np.unique(shape_trunks.sizes)]
        rows = [np.resize(g[k : k + QCRS_LEAF], QCRS_LEAF) for g in groups for k in range(0, len(g), QCRS_LEAF)]
        plain.append(np.array(rows, dtype=np.int32).reshape(-1, QCRS_LEAF))
    good, poor = stack(trunks), stack(trunks, plain)
    for name in NAMES:
        assert np.array_equal(getattr(score_block(good, good), name), getattr(score_block(poor, poor), name)), name


@given(SEEDS, st.integers(3, 12))
@settings(max_examples=20)
def test_contrasts_bound_the_distance_at_every_shift(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-1.0, 6.0, (2, n))
    ones = np.ones(1)
    offsets = np.array([0, n], dtype=np.int64)
    first, second = (features(offsets, v, v, v, ones)[0] for v in (x, y))
    least = min(np.abs(x - np.roll(y[::-1], s)).sum() for s in range(n))
    assert first.shape == (FEATURES,)
    assert np.abs(first - second)[1 : FEATURES - 1].max() <= least + 1e-12


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
@settings(max_examples=10)
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
@settings(max_examples=15)
def test_qcrs_does_not_depend_on_the_order_of_the_pair(seed: int) -> None:
    a, b = random_stack(seed, 3, False), random_stack(seed + 7, 3, False)
    there, back = score_block(a, b), score_block(b, a)
    swapped = back.score.reshape(3, 3).T.ravel()
    assert there.score == pytest.approx(swapped, rel=1e-9, abs=1e-300)


def test_pairs_without_a_common_n_score_nothing() -> None:
    empty = stack([Trunks.from_arrays(full_trunks(blob(1)).to_arrays())]), stack([])
    assert len(score_block(*empty).i) == 0
    none = random_trunks(np.random.default_rng(0), 0, False)
    scores = score_block(stack([none]), stack([none]))
    assert (scores.score[0], scores.n[0], scores.trunk_i[0], scores.shift[0]) == (0.0, 0, -1, -1)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_exact_pairs_score_high(seed: int) -> None:
    p, q = pair_shapes(exact_pair(4, seed))
    assert qcrs(p, q).score > 0.8


def test_best_trunks_correspond() -> None:
    p, q = pair_shapes(exact_pair(4, 2))
    best = qcrs(p, q)
    corners_p, corners_q = p.points[best.trunk_a], q.points[best.trunk_b]
    lengths = [np.hypot(*(np.roll(corners, -1, axis=0) - corners).T) for corners in (corners_p, corners_q)]
    assert np.abs(lengths[0] - lengths[1]).mean() < 0.05
    assert shapely.LinearRing(corners_p).is_ccw
    assert not shapely.LinearRing(corners_q).is_ccw
