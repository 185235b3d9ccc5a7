"""Search through the index: the same pairs, scores and trunks as scoring every pair."""

from __future__ import annotations

import numpy as np
import pytest
from blobs import blob
from hypothesis import given, settings
from hypothesis import strategies as st
from test_pair_scores import SEEDS, random_stack

import riot.scores.index
from riot.parameters import QcrsParameters
from riot.scores.index import TrunkIndex, best_pairs, best_partners, join
from riot.scores.qcrs import BlockScores, brute_force, distance_of, score_block, score_pairs
from riot.scores.trunk_stack import TrunkStack, of_trunks, stack
from riot.scores.trunks import quick_trunks

ROUNDING = 1e-12

NAMES = ("i", "j", "score", "n", "trunk_i", "trunk_j", "shift")


def rows(scores: BlockScores, order: np.ndarray) -> list[tuple[float, ...]]:
    return list(zip(*(getattr(scores, name)[order].tolist() for name in NAMES), strict=True))


def plain_partners(query: TrunkStack, others: TrunkStack, count: int, least: float, itself: bool) -> BlockScores:
    """Score all, sort, cut."""
    every = brute_force(query, others)
    keep = (every.score > 0) & (every.score >= least) & ~(itself & (every.i == every.j))
    order = [k for k in np.lexsort((every.j, -every.score, every.i)) if keep[k]]
    taken: list[int] = []
    for k in order:
        if sum(every.i[m] == every.i[k] for m in taken) < count:
            taken.append(int(k))
    return BlockScores(*(getattr(every, name)[taken] for name in NAMES))


@given(SEEDS, st.integers(1, 9), st.sampled_from([0.0, 0.3, 0.7]), st.booleans(), st.sampled_from([0, 2]))
@settings(max_examples=20)
def test_best_partners_are_those_of_scoring_all(seed: int, count: int, least: float, coarse: bool, few: int) -> None:
    # Coarse trunks tie by the dozen. What a tie decides is which distance is less, not which score rounds alike.
    everything = random_stack(seed, 7, coarse, 50)
    index = TrunkIndex.build([everything])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(riot.scores.index, "FEW_OTHERS", few)
        best = best_partners(index, everything, count, least=least, itself=range(7)).scores
    plain = plain_partners(everything, everything, count, least, True)
    assert rows(best, np.arange(len(best.i))) == rows(plain, np.arange(len(plain.i)))


@given(SEEDS, st.integers(0, 7), st.booleans(), st.sampled_from([0, 2]))
@settings(max_examples=15)
def test_a_pair_is_scored_with_its_earlier_shape_first(seed: int, earlier: int, coarse: bool, few: int) -> None:
    everything, query = random_stack(seed, 7, coarse, 50), random_stack(seed + 1, 1, coarse, 50)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(riot.scores.index, "FEW_OTHERS", few)
        best = best_partners(TrunkIndex.build([everything]), query, 3, earlier=[earlier]).scores
    after, before = brute_force(query, everything), brute_force(everything, query)
    turned = np.arange(7) < earlier
    score = np.where(turned, before.score, after.score)
    expected = [
        (score[j], before.trunk_j[j], before.trunk_i[j], before.shift[j])
        if turned[j]
        else (score[j], after.trunk_i[j], after.trunk_j[j], after.shift[j])
        for j in best.j
    ]
    assert list(zip(best.score, best.trunk_i, best.trunk_j, best.shift, strict=True)) == expected
    assert np.array_equal(best.score, np.sort(score[score > 0])[::-1][:3])


@given(SEEDS, st.integers(1, 30), st.sampled_from([0, 2]))
@settings(max_examples=15)
def test_best_pairs_are_those_of_scoring_all(seed: int, count: int, few: int) -> None:
    everything = random_stack(seed, 8, False, 50)
    every = brute_force(everything, everything, same=True)
    order = np.lexsort((every.j, every.i, -every.score))
    order = order[every.score[order] > 0][:count]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(riot.scores.index, "FEW_OTHERS", few)
        best = best_pairs(TrunkIndex.build([everything]), count)
    assert rows(best.scores, np.arange(len(best.scores.i))) == rows(every, order)
    assert len(best.scores.i) <= best.compared <= len(every.i)


@given(SEEDS, st.sampled_from([0.01, 0.1, 0.5, 1.0]), st.booleans())
@settings(max_examples=15)
def test_with_epsilon_every_score_is_at_most_that_much_too_low(seed: int, epsilon: float, coarse: bool) -> None:
    everything, parameters = random_stack(seed, 7, coarse, 50), QcrsParameters(epsilon=epsilon)
    exact, quick = brute_force(everything, everything), score_block(everything, everything, parameters)
    assert (quick.score <= exact.score + ROUNDING).all() and (quick.score >= exact.score - epsilon - ROUNDING).all()
    # Of a pair that scores at least as asked so much is found, however great epsilon is.
    pairs = np.column_stack([exact.i, exact.j]).astype(np.int64)
    limited = score_pairs(everything, everything, pairs, parameters, exact.score)
    assert limited.score == pytest.approx(exact.score, abs=1e-6)
    index, count = TrunkIndex.build([everything]), 3
    best = best_partners(index, everything, count, parameters, itself=range(7)).scores
    for i in range(7):
        true = np.sort(exact.score[(exact.i == i) & (exact.j != i)])[::-1][:count]
        found = np.append(best.score[best.i == i], np.zeros(count))[:count]
        assert (found <= true + ROUNDING).all() and (found >= true - epsilon - ROUNDING).all()


def test_cells_decide_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(riot.scores.index, "FEW_OTHERS", 0)
    everything = stack([quick_trunks(blob(seed, waves=6)) for seed in range(6)])
    best = best_partners(TrunkIndex.build([everything]), everything, 3, itself=range(6))
    monkeypatch.setattr(riot.scores.index, "CELL_LEAVES", 2)
    index = TrunkIndex.build([everything])
    small = best_partners(index, everything, 3, itself=range(6))
    assert len(index.cells.groups) > 10
    assert rows(best.scores, np.arange(18)) == rows(small.scores, np.arange(18))


def test_an_index_of_several_stacks_is_that_of_one() -> None:
    stacks = [random_stack(3, 2, False, 30), random_stack(4, 0, False), random_stack(5, 3, False, 30)]
    whole = join(stacks)
    assert len(whole) == 5
    query = random_stack(6, 2, False, 30)
    apart, together = (best_partners(TrunkIndex.build(s), query, 4).scores for s in (stacks, [whole]))
    assert rows(apart, np.arange(len(apart.i))) == rows(together, np.arange(len(together.i)))
    assert rows(apart, np.arange(len(apart.i))) == rows(plain_partners(query, whole, 4, 0.0, False), np.arange(8))


def test_a_shape_of_a_stack_alone_has_the_same_partners() -> None:
    everything = random_stack(9, 5, False, 40)
    index = TrunkIndex.build([everything])
    for i in range(5):
        alone = best_partners(index, everything.shape(i), 3, itself=[i]).scores
        among = best_partners(index, everything, 3, itself=range(5)).scores
        assert np.array_equal(alone.j, among.j[among.i == i])
        assert np.array_equal(alone.score, among.score[among.i == i])


@pytest.mark.parametrize("margin", [1.0, 1.3])
def test_promising_trunks_are_those_near_enough_to_another_shape(margin: float) -> None:
    everything = random_stack(11, 7, False, 40)
    best = best_partners(TrunkIndex.build([everything]), everything, 2, itself=range(7), margin=margin)
    assert rows(best.scores, np.arange(14)) == rows(plain_partners(everything, everything, 2, 0.0, True), np.arange(14))
    for i in range(7):
        shape, others = everything.shape(i), [everything.shape(j) for j in range(7) if j != i]
        alone = [of_trunks(shape, np.arange(len(shape.areas)) == t) for t in range(len(shape.areas))]
        nearest = distance_of(np.array([brute_force(trunk, join(others)).score.max() for trunk in alone]))
        reach = margin * distance_of(best.scores.score[best.scores.i == i][-1])
        assert best.promising[best.promising[:, 0] == i, 1].tolist() == np.flatnonzero(nearest <= reach).tolist()


def test_an_empty_index_has_no_partners() -> None:
    best = best_partners(TrunkIndex.build([stack([])]), random_stack(1, 2, False, 20), 3)
    assert (len(best.scores.i), best.compared) == (0, 0)


def test_no_partners_cannot_be_asked_for() -> None:
    index = TrunkIndex.build([random_stack(1, 2, False, 20)])
    with pytest.raises(ValueError, match="count=0"):
        best_partners(index, index.trunks, 0)
    with pytest.raises(ValueError, match="count=0"):
        best_pairs(index, 0)
