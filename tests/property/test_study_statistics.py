"""What studies compute: agreement of two scores, intervals of shares, samples of pairs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import StartError
from pipeline.study.consistency import uniform
from pipeline.study.statistics import agreement, calibration, precision, quantiles, wilson


def scores(seed: int, count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Two sets of scores without ties."""
    rng = np.random.default_rng(seed)
    return rng.permutation(count) / count, rng.permutation(count) / count


@given(st.integers(0, 2**20))
def test_agreement_depends_on_the_order_alone(seed: int) -> None:
    a, b = scores(seed)
    found = agreement(a, b, 100, 1)
    other = agreement(np.exp(3.0 * a), b, 100, 1)
    assert (found.alike, found.share, found.kendall) == (other.alike, other.share, other.kendall)
    # Without ties Kendall's correlation is the share alike less the share otherwise.
    assert found.share == pytest.approx((1.0 + found.kendall) / 2.0)
    assert agreement(-a, b, 100, 1).share == pytest.approx(1.0 - found.share)


def test_a_score_agrees_with_itself_and_not_with_its_reverse() -> None:
    a, _ = scores(3)
    same, reverse = agreement(a, a, 50, 1), agreement(a, -a, 50, 1)
    assert (same.alike, same.drawn, same.share, same.nearly_tied) == (50, 50, 1.0, 0.0)
    assert (reverse.alike, reverse.share) == (0, 0.0)


def test_ties_have_no_order() -> None:
    found = agreement(np.array([0.1, 0.1, 0.5, 0.9]), np.array([0.2, 0.3, 0.3, 0.26]), 100, 1)
    # Of six pairs, one is tied in each score; of the other four one is ordered otherwise per reference below.
    assert found.drawn == 4
    assert (found.alike, found.share) == (2, 0.5)
    assert found.nearly_tied == 1.0
    with pytest.raises(ValueError, match="nothing to compare"):
        agreement(np.ones(4), np.arange(4.0), 10, 1)


@given(st.integers(0, 2**20))
def test_what_the_score_ties_counts_half(seed: int) -> None:
    a, b = (np.round(each, 1) for each in scores(seed))
    pairs = [(i, j) for i in range(len(a)) for j in range(i) if b[i] != b[j]]
    alike = [0.5 if a[i] == a[j] else float((a[i] < a[j]) == (b[i] < b[j])) for i, j in pairs]
    assert agreement(a, b, 10, 1).halved == pytest.approx(np.mean(alike))


def test_draws_are_a_seed_s_own_and_near_the_whole() -> None:
    rng = np.random.default_rng(7)
    a = rng.random(300)
    b = a + 0.3 * rng.random(300)
    one, again, other = (agreement(a, b, 1000, seed) for seed in (1, 1, 2))
    assert one == again
    assert one.alike != other.alike and one.share == other.share
    assert one.low <= one.share <= one.high


def test_precision_counts_what_both_have_among_their_best() -> None:
    a = np.array([0.9, 0.8, 0.7, 0.1, 0.0])
    b = np.array([0.8, 0.1, 0.9, 0.7, 0.0])
    assert [precision(a, b, count) for count in (1, 2, 3, 5)] == [0.0, 0.5, 2 / 3, 1.0]


def test_calibration_is_the_quartiles_of_the_reference() -> None:
    a = np.linspace(0.0, 1.0, 100)
    rows = calibration(a, a**2, 5)
    assert len(rows) == 5
    for at, low, middle, high in rows:
        assert low <= middle <= high
        assert middle == pytest.approx(at**2, abs=0.01)


def test_intervals_hold_the_share_and_shrink() -> None:
    for good, trials in ((0, 20), (9, 10), (20, 20), (774, 1000)):
        low, high = wilson(good, trials)
        assert 0.0 <= low <= good / trials <= high <= 1.0
        wider = wilson(good, trials, together=10) if trials >= 100 else (low, high)
        assert wider[1] - wider[0] >= high - low


def test_quantiles_leave_out_what_is_not_there() -> None:
    assert quantiles([0.0, np.nan, 1.0], (0.0, 0.5, 1.0)) == [0.0, 0.5, 1.0]
    assert np.isnan(quantiles([np.nan], (0.5,))).all()


@given(st.integers(3, 60), st.integers(1, 3000), st.integers(0, 1000))
def test_uniform_pairs_are_distinct_pairs(shapes: int, count: int, seed: int) -> None:
    pairs = uniform(shapes, count, np.random.default_rng(seed))
    every = shapes * (shapes - 1) // 2
    assert len(pairs) == min(count, every)
    assert (pairs[:, 0] < pairs[:, 1]).all() and pairs.min() >= 0 and pairs.max() < shapes
    assert len({tuple(pair) for pair in pairs.tolist()}) == len(pairs)


def test_uniform_pairs_are_all_pairs_when_so_many_are_asked_for() -> None:
    expected = np.stack(np.triu_indices(9, 1), axis=1)
    assert np.array_equal(uniform(9, 36, np.random.default_rng(0)), expected)
    with pytest.raises(StartError, match="3 shapes"):
        uniform(2, 5, np.random.default_rng(0))


def test_other_seeds_draw_other_pairs() -> None:
    one, again, other = (uniform(50, 100, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)
