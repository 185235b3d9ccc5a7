"""Halves of blocks: every pair once, and fewer each time, down to the pair."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pipeline.plan.sub_block import Sides, SubBlock

sizes = st.integers(0, 9)


@given(st.booleans(), sizes, sizes)
def test_halves_hold_every_pair_once(same: bool, rows: int, columns: int) -> None:
    whole = SubBlock(Sides(1, 0 if same else 1), (0, rows), (0, rows if same else columns))
    pairs = list(whole.pairs())
    expected = [(i, j) for i in range(rows) for j in range(rows if same else columns) if i < j or not same]
    assert pairs == expected
    level = [whole]
    while level:
        halves = [half for sub_block in level for half in sub_block.halves()]
        single = [sub_block for sub_block in level if not sub_block.halves()]
        assert all(len(list(sub_block.pairs())) <= 1 for sub_block in single)
        assert sorted(pair for sub_block in (*halves, *single) for pair in sub_block.pairs()) == sorted(
            pair for sub_block in level for pair in sub_block.pairs()
        )
        assert all(
            len(list(half.pairs())) < len(list(sub_block.pairs())) for sub_block in level for half in sub_block.halves()
        )
        assert all(any(half.pairs()) for half in halves)
        level = halves
