"""Selection: the best pairs that the limits admit, whatever the blocks' order and the size of the pool."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.stages import policies
from pipeline.stages.policies import (
    Block,
    Chosen,
    SelectionLimits,
    best_of_classes,
    labels,
    select_best,
)
from pipeline.stages.policies import select_global as select_within_limits

COUNT = 12


def blocks_of(scores: np.ndarray, size: int) -> list[Block]:
    """All pairs i < j of a symmetric matrix, in blocks of ``size`` shapes."""
    blocks = []
    for a in range(0, len(scores), size):
        for b in range(a, len(scores), size):
            pairs = [(i, j) for i in range(a, min(a + size, len(scores))) for j in range(b, min(b + size, len(scores)))]
            ij = np.array([(i, j) for i, j in pairs if i < j], dtype=np.int64).reshape(-1, 2)
            blocks.append((ij[:, 0], ij[:, 1], scores[ij[:, 0], ij[:, 1]]))
    return blocks


def plainly(scores: np.ndarray, classes: list[str], limits: SelectionLimits) -> list[tuple[int, int]]:
    """The policy by its definition: all admissible pairs in order, taken while no limit is hit."""
    order = sorted(
        (-scores[i, j], i, j) for i in range(len(classes)) for j in range(i + 1, len(classes)) if scores[i, j] > 0
    )
    chosen: list[tuple[int, int]] = []
    shapes: Counter[int] = Counter()
    class_pairs: Counter[frozenset[object]] = Counter()
    for _, i, j in order:
        if classes[i] == classes[j] != "":
            continue
        labels = frozenset({classes[i] or i, classes[j] or j})
        full = shapes[i] >= limits.per_shape or shapes[j] >= limits.per_shape
        if full or class_pairs[labels] >= limits.per_class_pair or len(chosen) >= limits.top:
            continue
        chosen.append((i, j))
        shapes.update((i, j))
        class_pairs[labels] += 1
    return chosen


def listed(chosen: Chosen, scores: np.ndarray) -> list[tuple[int, int]]:
    """The chosen pairs, once their scores are seen to be theirs."""
    assert chosen.score.tolist() == [scores[i, j] for i, j in chosen.pairs]
    return [(i, j) for i, j in chosen.pairs.tolist()]


def positive(blocks: list[Block], keep: np.ndarray) -> Iterator[Block]:
    """The candidates: with a score, and of the shapes to keep."""
    for i, j, score in blocks:
        rows = (score > 0) & keep[i] & keep[j]
        yield i[rows], j[rows], score[rows]


def select_global(blocks: Callable[[], Iterator[Block]], classes: list[str], limits: SelectionLimits) -> Chosen:
    label = labels(classes)

    def candidates(size: int) -> tuple[Iterator[Block], bool]:
        rows = positive(list(blocks()), np.ones(len(classes), bool))
        return ((i[apart], j[apart], score[apart]) for i, j, score in rows for apart in (label[i] != label[j],)), False

    return select_within_limits(candidates, label, limits)


def select_paper(blocks: Iterator[Block], classes: list[str], scores: np.ndarray, top: int) -> Chosen:
    return select_best(positive(list(blocks), best_of_classes(classes, scores)), top)


matrices = st.lists(st.integers(0, 6), min_size=COUNT * COUNT, max_size=COUNT * COUNT).map(
    lambda values: np.array(values, dtype=float).reshape(COUNT, COUNT) / 6
)
classes_of = st.lists(st.sampled_from(["", "bat", "cup", "dog"]), min_size=COUNT, max_size=COUNT)


@settings(max_examples=40)
@given(matrices, classes_of, st.integers(1, 20), st.integers(1, 4), st.integers(1, 4), st.integers(1, 5))
def test_global_is_its_definition(
    scores: np.ndarray, classes: list[str], top: int, per_class_pair: int, per_shape: int, size: int
) -> None:
    limits = SelectionLimits(top, per_class_pair, per_shape)
    blocks = blocks_of(scores, size)
    expected = plainly(scores, classes, limits)
    assert listed(select_global(lambda: iter(blocks), classes, limits), scores) == expected
    assert listed(select_global(lambda: iter(blocks[::-1]), classes, limits), scores) == expected


def test_a_small_pool_is_grown_until_it_suffices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(policies, "FIRST_POOL", 3)
    monkeypatch.setattr(policies, "GROWTH", 2)
    scores = np.random.default_rng(5).random((40, 40))
    classes = [f"c{number % 4}" for number in range(40)]
    limits = SelectionLimits(18, 3, 2)
    reads = []

    def blocks() -> Iterator[Block]:
        reads.append(1)
        return iter(blocks_of(scores, 7))

    chosen = select_global(blocks, classes, limits)
    assert listed(chosen, scores) == plainly(scores, classes, limits)
    assert len(reads) > 1


def test_paper_takes_the_best_shape_of_each_class() -> None:
    classes = ["a", "a", "b", "b", "", ""]
    rating = np.array([0.1, 0.9, 0.5, 0.5, 0.2, np.nan])
    scores = np.arange(36.0).reshape(6, 6) / 36
    chosen = select_paper(iter(blocks_of(scores, 4)), classes, rating, top=10)
    assert listed(chosen, scores) == [(2, 4), (1, 4), (1, 2)]
    assert listed(select_paper(iter(blocks_of(scores, 4)), classes, rating, top=1), scores) == [(2, 4)]


def test_pairs_without_a_score_are_never_chosen() -> None:
    scores = np.zeros((4, 4))
    assert listed(select_global(lambda: iter(blocks_of(scores, 2)), [""] * 4, SelectionLimits(5, 5, 5)), scores) == []
    assert listed(select_paper(iter(blocks_of(scores, 2)), [""] * 4, np.ones(4), 5), scores) == []
