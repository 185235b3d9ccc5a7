"""The stages of likeness: descriptors without failed shapes, near-duplicates by position, and margins of results."""

from __future__ import annotations

import math

import numpy as np
import pytest

import riot
from pipeline.stages import likeness, margin, near_duplicates
from pipeline.stages.near_duplicates import Described
from pipeline.stages.shape_arrays import join_single, pack_shapes
from pipeline.store.artifact import Artifact
from riot import Shape
from riot.parameters import LikenessParameters
from riot.transform.riot_file import to_json

PARAMETERS = LikenessParameters()


def lobed(lobes: int, depth: float = 0.3) -> Shape:
    angle = np.arange(180) * math.tau / 180
    radius = 1.0 + depth * np.cos(lobes * angle)
    return Shape.from_polygon(radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))


SHAPES = [lobed(3), None, lobed(5), lobed(3, 0.302)]


def described(shapes: list[Shape | None]) -> Artifact:
    return likeness.STAGE.run([Artifact(pack_shapes(shapes), {"errors": []})], [], None)


def collected(classes: tuple[str, ...]) -> Artifact:
    spec = Described(("a", "b", "c", "d"), classes, (0, 2))
    return near_duplicates.STAGE.run([described(SHAPES[:2]), described(SHAPES[2:])], [PARAMETERS], spec)


def test_a_batch_equals_the_join_of_its_shapes() -> None:
    batch, joined = described(SHAPES), join_single([described([shape]) for shape in SHAPES])
    assert batch.arrays.keys() == joined.arrays.keys()
    assert all((batch.arrays[name] == joined.arrays[name]).all() for name in batch.arrays)


def test_clusters_are_named_by_their_first_shape() -> None:
    whole = collected(("", "", "", ""))
    assert whole.arrays["positions"].tolist() == [0, 2, 3]
    assert whole.arrays["cluster"].tolist() == [0, 2, 0]
    assert whole.document["names"] == ["a", "c", "d"]


@pytest.mark.parametrize(
    ("classes", "groups"),
    [(("", "", "", ""), [0, 1, 0]), (("x", "x", "x", "y"), [0, 0, 1]), (("x", "", "", ""), [0, 1, 2])],
)
def test_another_thing_has_another_class_or_cluster(classes: tuple[str, ...], groups: list[int]) -> None:
    assert collected(classes).arrays["group"].tolist() == groups


def test_the_margin_names_the_nearest_other_thing() -> None:
    house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)])
    collection = near_duplicates.STAGE.run(
        [described([house, kite, lobed(3)])], [PARAMETERS], Described(("house", "kite", "clover"), ("",) * 3, (0,))
    )
    puzzle = riot.construct(house, kite)
    outlines = {"outline_p": puzzle.outline_p(), "outline_q": puzzle.outline_q()}
    constructed = Artifact(outlines, {"riot": to_json(puzzle)})
    inputs = [margin.STAGE.prepare(artifact) for artifact in (constructed, collection)]
    (added,) = margin.STAGE.tables
    row = added.values(margin.STAGE.run(inputs, [PARAMETERS], (0, 1)))
    assert row["other_p"] in ("kite", "clover") and row["other_q"] in ("house", "clover")
    assert row["margin"] == min(row["margin_p"], row["margin_q"]) < 1.0
