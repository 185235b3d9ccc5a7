"""Search through the index: the same pairs, scores and trunks as scoring every pair."""

from __future__ import annotations

import numpy as np
import pytest
from blobs import blob
from hypothesis import given, settings
from hypothesis import strategies as st
from test_pair_scores import SEEDS, random_stack

import riot.scores.index
from riot.scores.index import TrunkIndex, best_pairs, best_partners, join
from riot.scores.qcrs import BlockScores, brute_force
from riot.scores.trunk_stack import TrunkStack, stack
from riot.scores.trunks import quick_trunks

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


@given(SEEDS, st.integers(1, 9), st.sampled_from([0.0, 0.3, 0.7]), st.booleans())
@settings(max_examples=20)
def test_best_partners_are_those_of_scoring_all(seed: int, count: int, least: float, coarse: bool) -> None:
    # Coarse trunks tie by the dozen. What a tie decides is which distance is less, not which score rounds alike.
    everything = random_stack(seed, 7, coarse, 50)
    index = TrunkIndex.build([everything])
    best = best_partners(index, everything, count, least=least, itself=range(7)).scores
    plain = plain_partners(everything, everything, count, least, True)
    assert rows(best, np.arange(len(best.i))) == rows(plain, np.arange(len(plain.i)))


@given(SEEDS, st.integers(1, 30))
@settings(max_examples=15)
def test_best_pairs_are_those_of_scoring_all(seed: int, count: int) -> None:
    everything = random_stack(seed, 8, False, 50)
    every = brute_force(everything, everything, same=True)
    order = np.lexsort((every.j, every.i, -every.score))
    order = order[every.score[order] > 0][:count]
    best = best_pairs(TrunkIndex.build([everything]), count)
    assert rows(best.scores, np.arange(len(best.scores.i))) == rows(every, order)
    assert len(best.scores.i) <= best.compared <= len(every.i)


def test_cells_decide_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_an_empty_index_has_no_partners() -> None:
    best = best_partners(TrunkIndex.build([stack([])]), random_stack(1, 2, False, 20), 3)
    assert (len(best.scores.i), best.compared) == (0, 0)


def test_no_partners_cannot_be_asked_for() -> None:
    index = TrunkIndex.build([random_stack(1, 2, False, 20)])
    with pytest.raises(ValueError, match="count=0"):
        best_partners(index, index.trunks, 0)
    with pytest.raises(ValueError, match="count=0"):
        best_pairs(index, 0)
