"""Batches: every item once and in order, of bounded size, and mostly kept when the collection grows."""

from __future__ import annotations

import hashlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.plan.batches import cut


def digests(count: int, salt: str = "") -> list[str]:
    return [hashlib.sha256(f"{salt}{number}".encode()).hexdigest() for number in range(count)]


@settings(max_examples=60)
@given(st.integers(0, 300), st.integers(1, 40), st.text(max_size=3))
def test_batches_cover_everything_once_in_bounds(count: int, mean: int, salt: str) -> None:
    batches = cut(digests(count, salt), mean)
    assert [position for batch in batches for position in batch] == list(range(count))
    assert all(len(batch) <= 2 * mean for batch in batches)
    assert all(len(batch) >= max(1, mean // 4) for batch in batches[:-1])


@settings(max_examples=40)
@given(st.integers(0, 400), st.text(max_size=3))
def test_one_more_item_leaves_most_batches(position: int, salt: str) -> None:
    before = digests(400, salt)
    after = [*before[:position], hashlib.sha256(b"new").hexdigest(), *before[position:]]
    old = {tuple(before[batch.start : batch.stop]) for batch in cut(before, 16)}
    new = {tuple(after[batch.start : batch.stop]) for batch in cut(after, 16)}
    assert len(new - old) <= 6
    assert len(new & old) >= len(old) - 6


def test_sizes_are_about_the_mean() -> None:
    sizes = [len(batch) for batch in cut(digests(20_000), 32)]
    assert 24 <= sum(sizes) / len(sizes) <= 40


def test_equal_items_cannot_make_one_endless_batch() -> None:
    assert max(len(batch) for batch in cut(["same"] * 1000, 16)) <= 32


def test_a_mean_below_one_is_refused() -> None:
    with pytest.raises(ValueError, match="1 or more"):
        cut(digests(3), 0)
