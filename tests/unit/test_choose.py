"""The choice among what was constructed: near-duplicates once, the floor, and the user's wishes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pipeline.config.selection import SelectConfig
from pipeline.datasets.item import Item
from pipeline.errors import StartError
from pipeline.stages.candidates import Shapes
from pipeline.stages.choose import choose
from pipeline.stages.collected import Collected
from pipeline.stages.shortlist import varied
from pipeline.stages.wishes import check_wishes, wished_shapes
from riot import Shape
from riot.errors import ParameterError
from riot.parameters import LikenessParameters
from riot.scores.descriptor import descriptor
from riot.scores.likeness import DescriptorIndex, near_duplicates
from riot.scores.surprise import elongation

LIKENESS = LikenessParameters()
POLYGONS = {
    "square": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "square-2": [(0, 0), (1, 0.02), (1, 1), (0, 1)],
    "rod": [(0, 0), (5, 0), (5, 1), (0, 1)],
    "arrow": [(0, 0), (4, 1), (0, 2), (1, 1)],
    "ell": [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)],
    "triangle": [(0, 0), (2, 0), (1, 1.7)],
}
NAMES = list(POLYGONS)
CLASSES = ["square", "square", "rod", "arrow", "ell", "triangle"]


@pytest.fixture(scope="module")
def collected() -> Collected:
    shapes = [Shape.from_polygon(points, name) for name, points in POLYGONS.items()]
    index = DescriptorIndex.build([descriptor(shape) for shape in shapes])
    positions = np.arange(len(shapes))
    arrays = {
        "positions": positions,
        "cluster": near_duplicates(index, LIKENESS.near_duplicate, mirrored=LIKENESS.mirrored),
        "elongation": np.array([elongation(shape.points) for shape in shapes]),
        "perimeter": np.array([shape.perimeter for shape in shapes]),
        **index.to_arrays(),
    }
    return Collected.of(arrays, len(shapes))


def row(margin: float | None = 0.5, iou: float = 0.95, **more: Any) -> dict[str, Any]:
    both = {"margin_p": margin, "margin_q": margin, "other_p": "x", "other_q": "y"}
    both |= {"recognised_p": True, "recognised_q": True}
    return {"riot": "", "n": 4, "iou_p": iou, "iou_q": iou, "surprise": 0.3, **both, **more}


def chosen(rows: list[dict[str, Any]], pairs: list[tuple[int, int]], collected: Collected, **wishes: Any) -> list[int]:
    return choose(rows, np.array(pairs), CLASSES, collected, SelectConfig(**wishes), LIKENESS).tolist()


def test_near_duplicates_are_chosen_once(collected: Collected) -> None:
    assert collected.cluster.tolist() == [0, 0, 2, 3, 4, 5]
    rows = [row(0.5), row(0.6), row(0.4)]
    assert chosen(rows, [(0, 2), (1, 2), (2, 3)], collected) == [1, 2]
    assert chosen(rows, [(0, 2), (2, 1), (2, 3)], collected) == [1, 2]


def test_what_is_new_comes_before_what_is_a_little_better(collected: Collected) -> None:
    assert chosen([row(0.9), row(0.5), row(0.4)], [(0, 2), (0, 3), (4, 5)], collected) == [0, 2, 1]


def test_below_the_floor_or_mistaken_comes_last(collected: Collected) -> None:
    rows = [row(0.9, iou=0.85), row(-0.1), row(0.1), row(None, iou=0.99)]
    pairs = [(0, 2), (0, 3), (0, 4), (2, 3)]
    assert chosen(rows, pairs, collected) == [2, 3, 1, 0]
    assert chosen(rows, pairs, collected, top=1) == [2]
    assert chosen(rows, pairs, collected, min_iou=0.8)[0] == 0


def test_what_is_taken_for_another_thing_counts_less(collected: Collected) -> None:
    rows, pairs = [row(0.8, recognised_q=False), row(0.5), row(0.1)], [(0, 2), (0, 2), (3, 4)]
    assert chosen(rows, pairs, collected) == [1, 2]
    assert chosen([row(0.8), *rows[1:]], pairs, collected) == [0, 2]


def test_without_another_thing_the_iou_counts(collected: Collected) -> None:
    rows = [{"riot": "", "n": 3, "iou_p": iou, "iou_q": 0.99} for iou in (0.92, 0.97)]
    assert chosen(rows, [(0, 2), (3, 4)], collected) == [1, 0]


def test_wishes(collected: Collected) -> None:
    rows = [row(n=3), row(n=4, surprise=0.05), row(n=5, swings_flat=True), {"status": "rejected"}]
    pairs = [(0, 2), (0, 3), (0, 4), (0, 5)]
    assert set(chosen(rows, pairs, collected)) == {0, 1, 2}
    assert set(chosen(rows, pairs, collected, pieces=(4, 5))) == {1, 2}
    assert set(chosen(rows, pairs, collected, min_surprise=0.2)) == {0, 2}
    assert chosen(rows, pairs, collected, flat=True) == [2]


def test_the_shortlist_takes_the_best_bound_and_what_is_new_in_turn(collected: Collected) -> None:
    bounds, pairs = np.array([0.99, 0.98, 0.97, 0.9, 0.0]), np.array([(0, 2), (0, 3), (0, 4), (4, 5), (3, 5)])
    settings = SelectConfig(top=3, pool=1)
    assert varied(bounds, pairs, CLASSES, collected, settings, LIKENESS).tolist() == [0, 3, 1]
    settings = SelectConfig(top=10, pool=1)
    assert sorted(varied(bounds, pairs, CLASSES, collected, settings, LIKENESS).tolist()) == [0, 1, 2, 3]


def test_surprise_grows_with_elongation_and_is_none_for_the_same(collected: Collected) -> None:
    i, j = np.array([0, 0, 0]), np.array([0, 1, 2])
    same, alike, rod = collected.surprise(i, j, mirrored=True).tolist()
    assert same < 1e-6 < alike < 0.1 < 0.8 < rod
    assert Collected.of({}, 3).surprise(i[:1], j[:1], mirrored=True).tolist() == [0.0]


ITEMS = [Item(name, cls, f"{name}.png", "0") for name, cls in zip(NAMES, CLASSES, strict=True)]


def test_wished_shapes() -> None:
    i, j = np.array([0, 0, 2, 3]), np.array([2, 3, 3, 4])

    def wished(**wishes: Any) -> list[bool]:
        shapes = Shapes.of([""] * len(ITEMS), wished_shapes(SelectConfig(**wishes), ITEMS))
        return shapes.admit(i, j).tolist()

    assert wished() == [True] * 4
    assert wished(classes="rod") == [True, False, True, False]
    assert wished(classes=["rod", "ell"], shapes=["arrow"]) == [False, False, True, True]
    assert wished(exclude=["square", "ell"]) == [False, False, True, False]


@pytest.mark.parametrize(
    ("wishes", "words"),
    [
        ({"classes": ["sqare"]}, ["select.classes: the collection has no class sqare", "did you mean square?"]),
        ({"shapes": ["square-3"]}, ["select.shapes: the collection has no shape square-3", "did you mean square-2?"]),
        ({"exclude": ["zzz"]}, ["select.exclude: the collection has no shape or class zzz", "it has arrow, ell"]),
    ],
)
def test_a_wish_for_what_is_not_there_is_an_error(wishes: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(StartError) as raised:
        check_wishes(SelectConfig(**wishes), ITEMS)
    assert all(word in str(raised.value) for word in words)
    check_wishes(SelectConfig(classes="square", exclude=["rod", "ell"]), ITEMS)


@pytest.mark.parametrize(("given", "pieces"), [("3..5", (3, 4, 5)), (4, (4,)), ([3, 5], (3, 5))])
def test_numbers_of_pieces(given: Any, pieces: tuple[int, ...]) -> None:
    assert SelectConfig(pieces=given).pieces == pieces


@pytest.mark.parametrize("wishes", [{"pieces": 4}, {"flat": True}, {"min_surprise": 0.2}])
def test_a_policy_that_heeds_no_wish_refuses_it(wishes: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match=r"needs select\.policy=varied"):
        SelectConfig(policy="global", **wishes)


def test_two_pieces_are_too_few() -> None:
    with pytest.raises(ParameterError, match="pieces"):
        SelectConfig(pieces=2)
