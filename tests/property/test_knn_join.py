"""The join finds the best partners of many shapes at once: those of scoring every pair, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_pair_scores import SEEDS, random_stack

import riot.scores.index
from riot.parameters import QcrsParameters
from riot.scores.index import TrunkIndex
from riot.scores.knn_join import join_partners, lay_out_queries
from riot.scores.qcrs import brute_force, distance_of
from riot.scores.trunk_stack import TrunkStack, of_trunks

QUERIES, OTHERS = 4, 7
Rows = list[tuple[float, ...]]


def plain(query: TrunkStack, others: TrunkStack, earlier: np.ndarray) -> Rows:
    """(i, j, score, trunk of i, trunk of j, shift) of every pair, scored with its earlier shape first."""
    after, before = brute_force(query, others), brute_force(others, query)
    rows: Rows = []
    for i, j in np.ndindex(QUERIES, OTHERS):
        if j < earlier[i]:
            k = int(np.flatnonzero((before.i == j) & (before.j == i))[0])
            rows.append((i, j, before.score[k], before.trunk_j[k], before.trunk_i[k], before.shift[k]))
        else:
            k = int(np.flatnonzero((after.i == i) & (after.j == j))[0])
            rows.append((i, j, after.score[k], after.trunk_i[k], after.trunk_j[k], after.shift[k]))
    return rows


def best(rows: Rows, i: int, count: int) -> Rows:
    mine = [row for row in rows if row[0] == i and row[2] > 0]
    return sorted(mine, key=lambda row: (-row[2], row[1]))[:count]


@given(SEEDS, st.integers(1, 9), st.booleans(), st.booleans(), st.lists(st.integers(0, OTHERS), min_size=QUERIES))
@settings(max_examples=20)
def test_the_best_partners_are_among_the_rows(
    seed: int, count: int, coarse: bool, small_cells: bool, earlier: list[int]
) -> None:
    # Coarse trunks tie by the dozen.
    query, others = random_stack(seed, QUERIES, coarse, 50), random_stack(seed + 1, OTHERS, coarse, 50)
    before, known = np.array(earlier[:QUERIES]), np.full((QUERIES, count), np.inf)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(riot.scores.index, "CELL_LEAVES", 2 if small_cells else 128)
        joined = join_partners(TrunkIndex.build([others]), lay_out_queries(query, known), known, earlier=before)
    scores, every = joined.scores, plain(query, others, before)
    columns = (scores.i, scores.j, scores.score, scores.trunk_i, scores.trunk_j, scores.shift)
    rows: Rows = list(zip(*(column.tolist() for column in columns), strict=True))
    assert set(rows) <= set(every)
    for i in range(QUERIES):
        assert best(rows, i, count) == best(every, i, count)
        found = np.exp(-0.5 * joined.tops[i] ** 2)
        assert found == pytest.approx(
            [row[2] for row in best(every, i, count)] + [0.0] * (count - len(best(every, i, count))), abs=1e-6
        )


@given(SEEDS, st.sampled_from([0.9, 0.5]))
@settings(max_examples=10)
def test_known_partners_leave_out_what_is_worse(seed: int, score: float) -> None:
    query, others = random_stack(seed, QUERIES, False, 50), random_stack(seed + 1, OTHERS, False, 50)
    known = np.full((QUERIES, 2), float(distance_of(score)))
    joined = join_partners(TrunkIndex.build([others]), lay_out_queries(query, known), known)
    every = plain(query, others, np.zeros(QUERIES))
    for i in range(QUERIES):
        wanted = [row for row in best(every, i, 2) if row[2] >= score]
        mine = joined.scores.i == i
        assert {row[1] for row in wanted} <= set(joined.scores.j[mine].tolist())
        assert (joined.scores.score[mine] >= score - 1e-3).all()
    assert (joined.tops <= known).all() and (np.diff(joined.tops, axis=1) >= 0).all()


@given(SEEDS, st.sampled_from([0.01, 0.1, 0.5]))
@settings(max_examples=10)
def test_with_epsilon_every_score_is_at_most_that_much_too_low(seed: int, epsilon: float) -> None:
    query, others = random_stack(seed, QUERIES, False, 50), random_stack(seed + 1, OTHERS, False, 50)
    known, parameters = np.full((QUERIES, 3), np.inf), QcrsParameters(epsilon=epsilon)
    joined = join_partners(TrunkIndex.build([others]), lay_out_queries(query, known), known, parameters)
    found = np.exp(-0.5 * joined.tops**2)
    for i in range(QUERIES):
        true = np.array([row[2] for row in best(plain(query, others, np.zeros(QUERIES)), i, 3)])
        assert (found[i, : len(true)] >= true - epsilon - 1e-6).all() and (found[i, : len(true)] <= true + 1e-6).all()


def test_queries_of_some_trunks_find_what_these_score() -> None:
    query, others = random_stack(5, QUERIES, False, 60), random_stack(6, OTHERS, False, 60)
    few = of_trunks(query, np.arange(len(query.areas)) % 7 == 0)
    known = np.full((QUERIES, OTHERS), np.inf)
    scores = join_partners(TrunkIndex.build([others]), lay_out_queries(few, known), known).scores
    plain_scores = brute_force(few, others)
    for name in ("i", "j", "score", "trunk_i", "trunk_j", "shift"):
        there = plain_scores.score > 0
        assert np.array_equal(getattr(scores, name), getattr(plain_scores, name)[there])


def test_neither_an_empty_index_nor_no_queries_have_partners() -> None:
    none, some = random_stack(1, 0, False), random_stack(2, 3, False, 30)
    for query, others in ((none, some), (some, none)):
        known = np.full((len(query), 2), np.inf)
        joined = join_partners(TrunkIndex.build([others]), lay_out_queries(query, known), known)
        assert len(joined.scores.i) == 0
