"""The greedy cover: its value is monotone and submodular, and the greedy choice keeps the bound against brute force."""

from __future__ import annotations

import itertools
import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.stages.cover import Group, Weights, cover_value, greedy_cover, groups_of

PAIRS = 9
worths = st.lists(st.integers(0, 10), min_size=PAIRS, max_size=PAIRS).map(lambda values: np.array(values) / 10)
some_groups = [
    Group(name, power, again)
    for name, power, again in zip("abcdef", (1, 1, 0.25, 0.25, 2, 2), (0.5, 0.1) * 3, strict=True)
]
shown = st.lists(
    st.lists(st.sampled_from(some_groups), min_size=1, max_size=4, unique=True), min_size=PAIRS, max_size=PAIRS
)


def value(worth: np.ndarray, groups: list[list[Group]], rows: tuple[int, ...]) -> float:
    return cover_value([float(worth[row]) for row in rows], [groups[row] for row in rows])


@settings(max_examples=60)
@given(worths, shown, st.integers(1, 4))
def test_greedy_is_worth_its_share_of_the_best_choice(worth: np.ndarray, groups: list[list[Group]], count: int) -> None:
    best = max(value(worth, groups, rows) for rows in itertools.combinations(range(PAIRS), count))
    chosen = greedy_cover(worth, groups, count)
    assert len(set(chosen)) == len(chosen) == min(count, int((worth > 0).sum()))
    assert value(worth, groups, tuple(chosen)) >= (1 - 1 / math.e) * best - 1e-12


@settings(max_examples=60)
@given(worths, shown)
def test_each_step_adds_most(worth: np.ndarray, groups: list[list[Group]]) -> None:
    chosen = greedy_cover(worth, groups, PAIRS)
    for step in range(len(chosen)):
        before = tuple(chosen[:step])
        others = [row for row in range(PAIRS) if row not in before]
        most = max(value(worth, groups, (*before, row)) for row in others)
        assert value(worth, groups, (*before, chosen[step])) >= most - 1e-12


@settings(max_examples=60)
@given(worths, shown, st.sets(st.integers(0, PAIRS - 2)), st.sets(st.integers(0, PAIRS - 2)))
def test_the_value_is_monotone_and_submodular(
    worth: np.ndarray, groups: list[list[Group]], first: set[int], second: set[int]
) -> None:
    less, more, row = tuple(sorted(first & second)), tuple(sorted(first | second)), PAIRS - 1
    gain_of_less = value(worth, groups, (*less, row)) - value(worth, groups, less)
    gain_of_more = value(worth, groups, (*more, row)) - value(worth, groups, more)
    assert -1e-12 <= gain_of_more <= gain_of_less + 1e-12


def test_what_pairs_show() -> None:
    pairs, cluster = np.array([[0, 1], [2, 3], [4, 5]]), np.array([0, 0, 2, 2, 4, 5])
    names = ["bird", "cup", "", "cup", "", ""]
    weights = Weights(thing=(0.25, 0.1), other=(2.0, 0.5))

    def of_thing(*of: int | str) -> list[Group]:
        return [Group(name, 0.25, 0.1) for name in of]

    def of_other(*of: object) -> list[Group]:
        return [Group(name, 2.0, 0.5) for name in of]

    assert groups_of(pairs, names, cluster, weights) == [
        (*of_thing("bird", "cup"), *of_other(0, ("bird", "cup"))),
        (*of_thing(2, "cup"), *of_other((2, "cup"))),
        (*of_thing(4, 5), *of_other((4, 5))),
    ]
