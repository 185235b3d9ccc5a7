"""Shapes, trunks, transforms and motions count by content, and print as one line."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riot import Shape, Transform, trunks
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.transform.certificate import certify


@pytest.fixture(scope="module")
def transform() -> Transform:
    return exact_transform(exact_pair(5, 2)).planned()


def values(transform: Transform) -> list[Any]:
    pose = transform.pose(0.5)
    return [transform, transform.p, trunks(transform.p), transform.pieces[0], transform.motion(), transform.chain, pose]


def test_a_copy_equals_its_original_and_has_its_hash(transform: Transform) -> None:
    for value in values(transform):
        copy = pickle.loads(pickle.dumps(value))
        assert copy is not value
        assert copy == value
        assert len({copy, value}) == 1


def test_a_saved_transform_loads_equal(transform: Transform, tmp_path: Path) -> None:
    for number, saved in enumerate((transform, replace(transform, plan=None))):
        path = tmp_path / f"{number}.riot"
        saved.save(path)
        assert Transform.load(path) == saved
    assert transform != replace(transform, plan=None)


@given(st.integers(0, 40), st.sampled_from((-1e-12, 1e-12)))
def test_the_least_change_makes_another_shape(point: int, change: float) -> None:
    shape = Shape.from_polygon([(0, 0), (4, 0), (4, 3)], name="triangle")
    points = shape.points.copy()
    points[point % len(points), 0] += change
    assert replace(shape, points=points) != shape
    assert replace(shape, points=shape.points.copy()) == shape
    assert shape != shape.renamed("other")
    assert shape != shape.points.tolist()


def test_a_certificate_belongs_to_its_transform_alone(transform: Transform) -> None:
    copy = pickle.loads(pickle.dumps(transform))
    assert certify(copy) is not certify(transform)
    assert certify(copy) == certify(transform)


def test_every_text_is_one_line(transform: Transform) -> None:
    texts = [repr(value) for value in values(transform)]
    assert all("\n" not in text and len(text) < 100 for text in texts)
    assert repr(transform.p) == f"Shape({transform.p.name!r}, {len(transform.p.points)} points)"
    assert texts[0].startswith(f"Transform({transform.p.name!r} ⇄ {transform.q.name!r}, {len(transform)} pieces, IoU ")
    assert texts[0].endswith(", exact)")
    turned = replace(transform, angles=np.asarray(transform.angles) + 0.01)
    assert repr(turned).endswith(", approximate)")
