"""The pool of policy varied: the best by score and the best partners of every shape are in it, for each n."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.stages import pool
from pipeline.stages.pool import BY_CLASS, SIZES, Rows, fill_pool

COUNT = 9
FIRST, SECOND = np.triu_indices(COUNT, 1)

scores_of = st.permutations(range(1, len(FIRST) + 1)).map(lambda order: np.array(order) / (len(FIRST) + 1))
sizes_of = st.lists(st.integers(3, 8), min_size=len(FIRST), max_size=len(FIRST)).map(np.array)
SAME = np.full(COUNT, 4.0)
"""Perimeters that weigh the same in all pairs."""

clusters = st.lists(st.integers(0, COUNT - 1), min_size=COUNT, max_size=COUNT).map(np.array)


def rows(scores: np.ndarray, sizes: np.ndarray) -> Rows:
    return Rows(FIRST.astype(np.int64), SECOND.astype(np.int64), scores, sizes.astype(np.int64))


def filled(block: Rows, label: np.ndarray, size: int) -> list[tuple[int, int]]:
    return [(i, j) for i, j in fill_pool(iter([block]), np.arange(COUNT), label, SAME, size).tolist()]


ROUND = 2 * len(SIZES) + BY_CLASS + 1
"""Pairs of a round: of each n the best and the mutual partners, some by class, and one by shape."""


def best_pairs(scores: np.ndarray, of: np.ndarray, most: int) -> set[tuple[int, int]]:
    """The best pair of everything that ``of`` numbers, the ``most`` best of these."""
    rows = {
        max((r for r in range(len(FIRST)) if k in (of[FIRST[r]], of[SECOND[r]])), key=lambda r: scores[r]) for k in of
    }
    return {(int(FIRST[row]), int(SECOND[row])) for row in sorted(rows, key=lambda row: -scores[row])[:most]}


@settings(max_examples=40)
@given(scores_of, sizes_of, clusters, st.integers(1, len(FIRST)))
def test_the_best_of_each_size_class_and_shape_are_in_the_pool(
    scores: np.ndarray, sizes: np.ndarray, label: np.ndarray, size: int
) -> None:
    taken = filled(rows(scores, sizes), label, size)
    assert len(set(taken)) == len(taken) == size
    rounds = size // ROUND
    for k in SIZES:
        best = sorted(np.flatnonzero(np.minimum(sizes, SIZES[-1]) == k), key=lambda row: -scores[row])
        assert {(int(FIRST[row]), int(SECOND[row])) for row in best[:rounds]} <= set(taken)
    assert best_pairs(scores, label, rounds * BY_CLASS) <= set(taken)
    assert best_pairs(scores, np.arange(COUNT), rounds) <= set(taken)


def test_each_shape_has_its_best_partner_in_a_pool_of_many_rounds() -> None:
    count, rng = 30, np.random.default_rng(3)
    i, j = np.triu_indices(count, 1)
    scores = rng.random(len(i))
    block = Rows(i, j, scores, rng.integers(3, 7, len(i)))
    taken = fill_pool(iter([block]), np.arange(count), np.arange(count), np.full(count, 4.0), ROUND * 10).tolist()
    for shape in range(count):
        row = max((row for row in range(len(i)) if shape in (i[row], j[row])), key=lambda row: scores[row])
        assert [i[row], j[row]] in taken


@settings(max_examples=40)
@given(scores_of, sizes_of, clusters, st.integers(1, 20), st.permutations(range(len(FIRST))), st.integers(1, 12))
def test_no_order_and_no_chunk_matters(
    scores: np.ndarray, sizes: np.ndarray, shape: np.ndarray, size: int, order: list[int], parts: int
) -> None:
    block = rows(scores, sizes)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(pool, "CHUNK", 5)
        patched.setattr(pool, "PARTNERS", 2)
        whole = fill_pool(iter([block]), shape, shape, SAME, size)
        pieces = (block.at(part) for part in np.array_split(np.array(order), parts))
        assert np.array_equal(fill_pool(pieces, shape, shape, SAME, size), whole)


def test_the_shorter_outline_promises_more() -> None:
    count = 8
    i, j = np.triu_indices(count, 1)
    perimeter = np.array([8.0, *np.linspace(7, 4, count - 1)])
    scores = np.where(i == 0, 0.5 - 1e-3 * j, 0.2 + 1e-4 * (i + j))
    label = np.array([0, *range(1, count)])
    taken = fill_pool(iter([Rows(i, j, scores, np.full(len(i), 4))]), label, label, perimeter, ROUND).tolist()
    # The last, of the shortest outline, is the first partner of every shape; the best by score has entered by its n.
    assert [0, count - 1] in taken and [0, 1] in taken


def test_a_pool_of_nothing_is_empty() -> None:
    none = np.empty(0, np.int64)
    assert fill_pool(iter([]), np.arange(3), np.arange(3), np.full(3, 4.0), 5).shape == (0, 2)
    assert fill_pool(iter([Rows(none, none, np.empty(0), none)]), none, none, np.empty(0), 5).shape == (0, 2)
